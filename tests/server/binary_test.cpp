// The real program as a process of its own.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "sequence/temporary_folder.h"

extern char** environ;

namespace eifmap {
namespace {

using namespace std::chrono_literals;

class Process {
 public:
  Process(std::vector<std::string> arguments, const std::filesystem::path& output) {
    arguments.insert(arguments.begin(), EIFMAP_SERVER_BINARY);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Process() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

  bool started() const { return pid_ > 0; }
  void signal(int number) const { kill(pid_, number); }

  // The exit code; -1 when a signal ended it or it did not end in 30 s.
  int wait() {
    for (int i = 0; i < 3000; ++i) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      std::this_thread::sleep_for(10ms);
    }
    return -1;
  }

 private:
  pid_t pid_ = -1;
};

struct Ended {
  int code;
  std::string output;
};

Ended run(const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  Process process(arguments, folder.path() / "output");
  const int code = process.wait();
  return {code, read_text(folder.path() / "output")};
}

class StopBySignal : public testing::TestWithParam<int> {};

TEST_P(StopBySignal, EndsCleanly) {
  const TemporaryFolder folder;
  const auto output = folder.path() / "output";
  Process server({"--lcm-url", "memq://"}, output);
  ASSERT_TRUE(server.started());
  for (int i = 0; i < 1000 && read_text(output).find("listening") == std::string::npos; ++i)
    std::this_thread::sleep_for(10ms);
  server.signal(GetParam());
  EXPECT_EQ(server.wait(), 0);
  EXPECT_NE(read_text(output).find("stopped"), std::string::npos) << read_text(output);
}

INSTANTIATE_TEST_SUITE_P(Signals, StopBySignal, testing::Values(SIGTERM, SIGINT));

TEST(Binary, PrintsTheWholeConfiguration) {
  const Ended ended = run({"--print-config", "--input", "lossless", "--camera", "front"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_NE(ended.output.find(R"("input": "lossless")"), std::string::npos) << ended.output;
  EXPECT_NE(ended.output.find(R"("camera": "front")"), std::string::npos);
  EXPECT_NE(ended.output.find(R"("relinearize_px")"), std::string::npos);
}

TEST(Binary, RefusesAnUnknownKeyByItsName) {
  const TemporaryFolder folder;
  const auto file = folder.write("config.json", R"({"mapper": {"edge": {"enabld": true}}})");
  const Ended ended = run({"--config", file.string()});
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.output.find("mapper.edge.enabld"), std::string::npos) << ended.output;
}

TEST(Binary, SaysWhatIsWrongWithItsOptions) {
  EXPECT_EQ(run({"--no-such-option"}).code, 2);
  EXPECT_EQ(run({"--input", "fastest"}).code, 2);
  EXPECT_EQ(run({"--sequence", "/nowhere"}).code, 2) << "there is no --output";
  const Ended ended = run({"--sequence", "/nowhere", "--output", "/tmp/never"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_NE(ended.output.find("/nowhere"), std::string::npos) << ended.output;
  EXPECT_EQ(run({"--help"}).code, 0);
}

TEST(Binary, SaysWhenTheNetworkDoesNotOpen) {
  const Ended ended = run({"--lcm-url", "nonsense://"});
  EXPECT_EQ(ended.code, 1);
  EXPECT_NE(ended.output.find("nonsense://"), std::string::npos) << ended.output;
}

}  // namespace
}  // namespace eifmap
