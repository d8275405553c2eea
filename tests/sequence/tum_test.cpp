#include "sequence/tum.h"

#include <gtest/gtest.h>

#include <random>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

std::vector<TimedPose> random_poses(int count) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  std::vector<TimedPose> poses;
  for (int i = 0; i < count; ++i) {
    Rigid3 pose;
    pose.rotation.coeffs() << normal(random), normal(random), normal(random), normal(random);
    pose.rotation.normalize();
    pose.translation = 1e3 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    poses.push_back({1305031102175304 + 33333 * i, pose});
  }
  return poses;
}

TEST(Tum, WhatIsWrittenReadsBackBitForBit) {
  const TemporaryFolder folder;
  const auto poses = random_poses(300);
  ASSERT_EQ(write_tum(folder.path() / "a.tum", poses), "");
  const auto read = read_tum(folder.path() / "a.tum");
  ASSERT_EQ(read.problem, "");
  ASSERT_EQ(read.poses.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(std::llround(read.poses[i].time_s * 1e6), poses[i].time_us);
    EXPECT_EQ(read.poses[i].world_from_camera.translation, poses[i].world_from_camera.translation);
    EXPECT_EQ(read.poses[i].world_from_camera.rotation.coeffs(),
              poses[i].world_from_camera.rotation.coeffs());
  }
}

TEST(Tum, LineHasNineDecimalsOfTimeAndTheFewestDigits) {
  const Rigid3 pose({1, 0, 0, 0}, {0.1, -2, 3e-20});
  EXPECT_EQ(tum_line({1500000, pose}), "1.500000000 0.1 -2 3e-20 0 0 0 1");
  EXPECT_EQ(tum_line({-1500001, pose}), "-1.500001000 0.1 -2 3e-20 0 0 0 1");
}

TEST(Tum, ReadsWhatOthersWrite) {
  const TemporaryFolder folder;
  const auto file = folder.write("a.tum",
                                 "# time tx ty tz qx qy qz qw\n"
                                 "2.5, 1, 2, 3, 0, 0, 0, 2\n"
                                 "1 nan 0 0 0 0 0 1\n"
                                 "1.5 4 5 6 0 0 0 1 # a remark\n"
                                 "3 1 2");
  const auto read = read_tum(file);
  ASSERT_EQ(read.problem, "");
  ASSERT_EQ(read.poses.size(), 2u);  // sorted; the nan and the broken last line are passed over
  EXPECT_EQ(read.poses[0].time_s, 1.5);
  EXPECT_EQ(read.poses[1].world_from_camera.rotation.w(), 1);  // made unit
}

TEST(Tum, SaysWhichLineAndWord) {
  const TemporaryFolder folder;
  const auto word =
      read_tum(folder.write("a.tum", "1 0 0 0 0 0 0 1\n2 0 zero 0 0 0 0 1\n")).problem;
  EXPECT_NE(word.find("a.tum line 2: 'zero'"), std::string::npos) << word;
  const auto zero = read_tum(folder.write("b.tum", "1 0 0 0 0 0 0 0\n")).problem;
  EXPECT_NE(zero.find("b.tum line 1: the quaternion is zero"), std::string::npos) << zero;
  EXPECT_NE(read_tum(folder.path() / "none.tum").problem.find("none.tum"), std::string::npos);
  EXPECT_NE(write_tum(folder.path() / "no" / "a.tum", {}).find("cannot be written"),
            std::string::npos);
}

}  // namespace
}  // namespace eifmap
