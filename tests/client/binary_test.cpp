// The real program as a process of its own.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "sequence/temporary_folder.h"
#include "sequence/trajectory_error.h"

namespace eifmap {
namespace {

struct Finished {
  int code = -1;
  std::string output;  // both streams
};

Finished eifmap_program(const std::string& arguments) {
  const std::string command = std::string(EIFMAP_BINARY) + " " + arguments + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  Finished result;
  if (!pipe) return result;
  std::array<char, 4096> buffer;
  while (fgets(buffer.data(), buffer.size(), pipe)) result.output += buffer.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.code = WEXITSTATUS(status);
  return result;
}

TEST(EifmapProgram, EvalPrintsTheFigures) {
  const TemporaryFolder folder;
  std::vector<TimedPose> truth, estimate;
  for (int i = 0; i < 50; ++i) {
    const Rigid3 pose(so3_exp({0, 0.05 * i, 0}), {0.1 * i, 0.02 * i * i, std::sin(0.3 * i)});
    truth.push_back({100000 * i, pose});
    if (i % 5 != 0)
      estimate.push_back(
          {100000 * i,
           {pose.rotation, 2 * pose.translation + Eigen::Vector3d(0.01 * (i % 2), 0, 0)}});
  }
  const std::string gt = (folder.path() / "gt.tum").string();
  const std::string est = (folder.path() / "est.tum").string();
  ASSERT_EQ(write_tum(gt, truth), "");
  ASSERT_EQ(write_tum(est, estimate), "");
  std::string times = "# seconds\n";
  for (int i = 0; i < 50; ++i) times += std::to_string(0.1 * i) + "\n";
  const std::string times_file = folder.write("times.txt", times).string();

  const auto wanted = trajectory_error(read_tum(gt).poses, read_tum(est).poses, {0.05, 50});
  EXPECT_DOUBLE_EQ(wanted.coverage.value(), 0.8);
  const std::string arguments = "eval --gt " + gt + " --est " + est;
  EXPECT_EQ(eifmap_program(arguments + " --times " + times_file).output, plain_text(wanted));
  const auto json = eifmap_program(arguments + " --nframes 50 --json");
  EXPECT_EQ(json.code, 0);
  EXPECT_EQ(json.output, json_text(wanted) + "\n");

  const auto no_times = eifmap_program(arguments + " --times " + times_file + ".none");
  EXPECT_EQ(no_times.code, 1);
  EXPECT_NE(no_times.output.find("times.txt.none: cannot be read"), std::string::npos);

  folder.write("few.tum", "0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(
      eifmap_program("eval --gt " + gt + " --est " + (folder.path() / "few.tum").string()).code, 1);
}

TEST(EifmapProgram, SaysWhatIsWrongAndEndsWithACode) {
  const TemporaryFolder folder;
  const std::string none = (folder.path() / "none").string();
  const auto publish = eifmap_program("publish " + none);
  EXPECT_EQ(publish.code, 2);
  EXPECT_NE(publish.output.find("none: does not exist"), std::string::npos) << publish.output;
  EXPECT_NE(eifmap_program("eval --gt " + none + " --est " + none).output.find("cannot be read"),
            std::string::npos);
  EXPECT_EQ(eifmap_program("publish").code, 2);
  EXPECT_EQ(eifmap_program("publish --simulate moon --lcm-url memq://").code, 2);
  EXPECT_EQ(eifmap_program("publish --as pictures " + none).code, 2);
  EXPECT_EQ(eifmap_program("log").code, 2);
  EXPECT_EQ(eifmap_program("fly").code, 2);
  EXPECT_EQ(eifmap_program("").code, 2);
  EXPECT_EQ(eifmap_program("--help").code, 0);
  const auto view = eifmap_program("view --lcm-url memq:// --address nowhere");
  EXPECT_EQ(view.code, 2);
  EXPECT_NE(view.output.find("--address is 'nowhere', wanted an IPv4 address"), std::string::npos)
      << view.output;
  EXPECT_EQ(eifmap_program("view --lcm-url memq:// --camera 'two words'").code, 2);
  const auto log = eifmap_program("log --lcm-url nonsense:// " + (folder.path() / "log").string());
  EXPECT_EQ(log.code, 1);
  EXPECT_NE(log.output.find("LCM cannot be opened at nonsense://"), std::string::npos)
      << log.output;
}

}  // namespace
}  // namespace eifmap
