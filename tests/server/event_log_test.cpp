// Logs as liblcm writes them, and what is left of damaged ones.
#include "server/event_log.h"

#include <gtest/gtest.h>

#include <lcm/lcm-cpp.hpp>
#include <sstream>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

class EventLogTest : public testing::Test {
 protected:
  // Three events by liblcm's own writer, the second one with a message of no bytes.
  void SetUp() override {
    {
      lcm::LogFile out(file(), "w");
      for (const char* text : {"first", "", "the third"}) {
        std::string message = text;
        lcm::LogEvent event;
        event.timestamp = 1'000'000 + static_cast<std::int64_t>(message.size());
        event.channel = "eifmap.cam0." + message.substr(0, 3);
        event.datalen = static_cast<std::int32_t>(message.size());
        event.data = message.data();
        ASSERT_EQ(out.writeEvent(&event), 0);
      }
    }
    text_ = read_text(file());
  }

  std::string file() const { return (folder_.path() / "log").string(); }

  // How many events can be read, and what is said then.
  std::pair<std::int64_t, std::string> read(const std::string& text) const {
    EventLog log(folder_.write("other", text));
    while (log.next()) log.read_message();
    return {log.events(), log.problem()};
  }

  const TemporaryFolder folder_;
  std::string text_;
};

TEST_F(EventLogTest, HasWhatWasWritten) {
  EventLog log{std::filesystem::path(file())};
  const char* messages[] = {"first", "", "the third"};
  for (const std::string message : messages) {
    ASSERT_TRUE(log.next()) << log.problem();
    EXPECT_EQ(log.channel(), "eifmap.cam0." + message.substr(0, 3));
    EXPECT_EQ(log.time_us(), 1'000'000 + static_cast<std::int64_t>(message.size()));
    const auto bytes = log.read_message();
    EXPECT_EQ(std::string(bytes.begin(), bytes.end()), message);
  }
  EXPECT_FALSE(log.next());
  EXPECT_EQ(log.problem(), "");
}

TEST_F(EventLogTest, WhatIsPassedOverNeedNotBeRead) {
  EventLog log{std::filesystem::path(file())};
  ASSERT_TRUE(log.next() && log.next() && log.next());
  const auto bytes = log.read_message();
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "the third");
}

TEST_F(EventLogTest, CutAnywhereItIsReadUpToThere) {
  const std::size_t first = text_.size() - 9 - 15 - 28 - 12 - 28;
  for (std::size_t size = 1; size < text_.size(); ++size) {
    const auto [events, problem] = read(text_.substr(0, size));
    EXPECT_LT(events, 3);
    if (size < first) {
      EXPECT_EQ(events, 0);
    }
    // Between two events nothing tells that there were more.
    if (size != first && size != first + 28 + 12) {
      EXPECT_NE(problem.find("is cut off at byte"), std::string::npos) << size << ": " << problem;
    }
  }
  EXPECT_EQ(read(text_.substr(0, text_.size() - 1)).first, 2);
}

TEST_F(EventLogTest, EveryByteMayBeAnother) {
  for (std::size_t at = 0; at < text_.size(); ++at)
    for (const char other : {'\0', '\x7f', '\x80', '\xff'}) {
      std::string damaged = text_;
      damaged[at] = other;
      const auto [events, problem] = read(damaged);
      EXPECT_TRUE(events == 3 || !problem.empty()) << at;
    }
}

TEST_F(EventLogTest, AfterGarbageNothingIsBelieved) {
  const auto [events, problem] = read(text_ + "garbage, as long as a header is" + text_);
  EXPECT_EQ(events, 3);
  EXPECT_NE(problem.find("is corrupt at byte " + std::to_string(text_.size())), std::string::npos)
      << problem;
}

TEST_F(EventLogTest, AnotherFileIsNoLog) {
  for (const char* text : {"{\"utime\": 1, \"and\": \"so on, for a while\"}", "\x89PNG\r\n"}) {
    const auto [events, problem] = read(text);
    EXPECT_EQ(events, 0);
    EXPECT_NE(problem.find("give a log that lcm-logger wrote"), std::string::npos) << problem;
  }
  EventLog none(folder_.path() / "none");
  EXPECT_FALSE(none.next());
  EXPECT_NE(none.problem().find("none: cannot be read"), std::string::npos) << none.problem();
  EXPECT_EQ(read(""), (std::pair<std::int64_t, std::string>(0, "")));
}

TEST_F(EventLogTest, ADirectoryIsNoLog) {
  EventLog log(folder_.path());
  EXPECT_FALSE(log.next());
  EXPECT_NE(log.problem(), "");
}

}  // namespace
}  // namespace eifmap
