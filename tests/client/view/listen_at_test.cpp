#include "program/listen_at.h"

#include <gtest/gtest.h>

#include "client/view/page_server.h"

namespace eifmap {
namespace {

TEST(ListenAt, SaysWhatIsWrongAndWhatToDo) {
  EXPECT_EQ(listen_problem({"127.0.0.1", 0}), "");
  EXPECT_EQ(listen_problem({"everywhere", 0}),
            "--address is 'everywhere', wanted an IPv4 address of this machine, such as 127.0.0.1");
  EXPECT_EQ(listen_problem({"127.0.0.1", 70000}), "--port is 70000, wanted 0 to 65535");
  EXPECT_NE(listen_problem({"192.0.2.1", 0}).find("192.0.2.1, which is no address of this machine"),
            std::string::npos);
}

TEST(ListenAt, ATakenPortIsSaidToBe) {
  View view;
  const auto first = PageServer::open({"127.0.0.1", 0}, view);
  ASSERT_TRUE(first.server) << first.problem;
  const int port = first.server->port();
  EXPECT_GT(port, 0);
  const auto second = PageServer::open({"127.0.0.1", port}, view);
  EXPECT_FALSE(second.server);
  EXPECT_EQ(second.problem, "port " + std::to_string(port) +
                                " of 127.0.0.1 is taken: end the program that has it, or choose "
                                "another with --port");
}

TEST(ListenAt, OnlyItsOwnPagesMayLook) {
  EXPECT_TRUE(may_look("127.0.0.1:8090", "http://127.0.0.1:8090", true));
  EXPECT_TRUE(may_look("localhost:8090", "http://localhost:8090", true));
  EXPECT_TRUE(may_look("127.0.0.1:8090", "", true)) << "a program, not a browser";
  EXPECT_FALSE(may_look("127.0.0.1:8090", "http://elsewhere.example", true));
  EXPECT_FALSE(may_look("127.0.0.1:8090", "http://127.0.0.1:9999", true));
  // A name that its owner lets mean 127.0.0.1.
  EXPECT_FALSE(may_look("elsewhere.example:8090", "http://elsewhere.example:8090", true));
  EXPECT_TRUE(may_look("robot.local:8090", "http://robot.local:8090", false));
  EXPECT_FALSE(may_look("robot.local:8090", "http://elsewhere.example", false));
}

}  // namespace
}  // namespace eifmap
