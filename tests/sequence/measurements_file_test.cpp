#include "sequence/measurements_file.h"

#include <gtest/gtest.h>

#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

class MeasurementsFileTest : public testing::Test {
 protected:
  MeasurementsFile read(const std::string& text) {
    return read_measurements(folder_.write("m.jsonl", text));
  }
  void expect_problem(const std::string& line, const std::string& part) {
    const MeasurementsFile file = read(kGood + line + "\n");
    EXPECT_NE(file.problem.find("line 2: "), std::string::npos) << file.problem;
    EXPECT_NE(file.problem.find(part), std::string::npos) << file.problem;
    EXPECT_TRUE(file.measurements.empty());
  }
  const std::string kGood =
      R"({"kind": "position", "utime": 5, "position": [1, 2, 3], "sigma": 0.5})"
      "\n";

 private:
  const TemporaryFolder folder_;
};

TEST_F(MeasurementsFileTest, ReadsEveryKindInTheOrderOfUse) {
  const MeasurementsFile file = read(
      R"({"kind": "distance", "utime": 1, "utime2": 9, "length": 30, "sigma": 0.1})"
      "\n" +
      kGood +
      R"({"kind": "odometry", "utime": 2, "utime2": 7, "length": 3, "sigma": 0.2})"
      "\n"
      R"({"kind": "position", "utime": 6, "position": [1, 2, 3], "lever": [0, 0, 1],)"
      R"( "covariance": [4, 0, 0, 0, 5, 0, 0, 0, 6]})"
      "\n"
      R"({"kind": "gravity", "utime": 10, "down": [0, 9.8, 1], "sigma": 0.02})"
      "\n"
      R"({"kind": "landmarks", "utime": 11, "map": 1, "a": 7, "b": 0, "length": 2, "sigma": 1})"
      "\n");
  ASSERT_EQ(file.problem, "");
  ASSERT_EQ(file.measurements.size(), 6u);
  EXPECT_EQ(file.measurements[4].kind, MeasurementKind::kGravity);
  EXPECT_EQ(file.measurements[4].down, Eigen::Vector3d(0, 9.8, 1));
  EXPECT_EQ(file.measurements[4].sigma, 0.02);
  EXPECT_EQ(file.measurements[5].kind, MeasurementKind::kLandmarks);
  EXPECT_EQ(file.measurements[5].map_id, 1);
  EXPECT_EQ(file.measurements[5].landmark, (std::array<std::int64_t, 2>{7, 0}));
  EXPECT_EQ(file.measurements[5].length, 2);
  EXPECT_EQ(file.measurements[0].kind, MeasurementKind::kPosition);
  EXPECT_EQ(file.measurements[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(file.measurements[0].covariance(1, 1), 0.25);
  EXPECT_EQ(file.measurements[1].lever, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(file.measurements[1].covariance(2, 2), 6);
  EXPECT_EQ(file.measurements[2].kind, MeasurementKind::kOdometry);
  EXPECT_EQ(file.measurements[2].until_us, 7);
  EXPECT_EQ(file.measurements[3].kind, MeasurementKind::kDistance);
  EXPECT_EQ(file.measurements[3].length, 30);
}

TEST_F(MeasurementsFileTest, WhatIsWrittenIsReadBackToTheBit) {
  AbsoluteMeasurement position, distance;
  position.id = {-9'000'000'000'000'000'000, 4};
  position.time_us = 7;
  position.position = {1.0 / 3, -2e5 / 7, 1e-9};
  position.covariance << 1.0 / 3, 0.01, 0, 0.01, 0.7, 0, 0, 0, 0.9;
  position.lever = {0.1, 0.2, 0.3};
  distance.id = {5, 0};
  distance.kind = MeasurementKind::kDistance;
  distance.time_us = 8;
  distance.until_us = 9;
  distance.length = 1.0 / 7;
  distance.sigma = 0.1 / 3;
  AbsoluteMeasurement gravity, landmarks = distance;
  gravity.id = {5, 1};
  gravity.kind = MeasurementKind::kGravity;
  gravity.time_us = 10;
  gravity.down = {1.0 / 3, -9.8, 1e-9};
  gravity.sigma = 0.01 / 3;
  landmarks.id = {5, 2};
  landmarks.kind = MeasurementKind::kLandmarks;
  landmarks.time_us = 11;
  landmarks.until_us = 0;
  landmarks.map_id = 2;
  landmarks.landmark = {5'000'000'000, 3};
  const MeasurementsFile file = read(line_of(position) + "\n" + line_of(distance) + "\n" +
                                     line_of(gravity) + "\n" + line_of(landmarks) + "\n");
  ASSERT_EQ(file.problem, "");
  ASSERT_EQ(file.measurements.size(), 4u);
  EXPECT_EQ(file.measurements[2].down, gravity.down);
  EXPECT_EQ(file.measurements[2].sigma, gravity.sigma);
  EXPECT_EQ(file.measurements[3].map_id, 2);
  EXPECT_EQ(file.measurements[3].landmark, landmarks.landmark);
  EXPECT_EQ(file.measurements[3].length, landmarks.length);
  const AbsoluteMeasurement &a = file.measurements[0], &b = file.measurements[1];
  EXPECT_EQ(a.id, position.id);
  EXPECT_EQ(a.position, position.position);
  EXPECT_EQ(a.covariance, position.covariance);
  EXPECT_EQ(a.lever, position.lever);
  EXPECT_EQ(b.id, distance.id);
  EXPECT_EQ(b.kind, distance.kind);
  EXPECT_EQ(b.until_us, 9);
  EXPECT_EQ(b.length, distance.length);
  EXPECT_EQ(b.sigma, distance.sigma);
}

TEST_F(MeasurementsFileTest, EachHasAName) {
  EXPECT_EQ(read(kGood + kGood).measurements[1].id, (MeasurementId{0, 1}));
  expect_problem(R"({"kind": "position", "utime": 5, "position": [1, 2, 3], "sigma": 1, "seq": 1})",
                 "\"publisher\" is missing");
  expect_problem(
      R"({"kind": "position", "utime": 5, "position": [1, 2, 3], "sigma": 1, "publisher": 0, "seq": 0})",
      "those of a line before");
}

TEST_F(MeasurementsFileTest, SaysWhichLineIsWrongAndWhy) {
  expect_problem("{", "no JSON object");
  expect_problem(R"({"kind": "wind", "utime": 1})", "wanted position");
  expect_problem(R"({"kind": "gravity", "utime": 1, "down": [0, 0, 0], "sigma": 1})", "not finite");
  expect_problem(R"({"kind": "gravity", "utime": 1, "down": [0, 1, 0], "sigma": 2})",
                 "at most 1 rad");
  expect_problem(R"({"kind": "landmarks", "utime": 1, "map": 0, "a": 1, "b": 2, "length": 1,)"
                 R"( "sigma": 1})",
                 "name no map");
  expect_problem(R"({"kind": "landmarks", "utime": 1, "map": 1, "a": 2, "b": 2, "length": 1,)"
                 R"( "sigma": 1})",
                 "two landmarks");
  expect_problem(R"({"kind": "position", "utime": 1.5, "position": [1, 2, 3], "sigma": 1})",
                 "\"utime\" is no whole number");
  expect_problem(R"({"kind": "position", "utime": 1, "position": [1, 2], "sigma": 1})",
                 "no list of 3 numbers");
  expect_problem(R"({"kind": "position", "utime": 1, "position": [1, 2, 3]})",
                 "\"sigma\" is missing");
  expect_problem(R"({"kind": "position", "utime": 1, "position": [1, 2, 3], "sigma": 0})",
                 "not positive");
  expect_problem(R"({"kind": "position", "utime": 1, "position": [1, 2, 3], "sigma": 1, "x": 1})",
                 "\"x\" is not known");
  expect_problem(R"({"kind": "distance", "utime": 1, "utime2": 1, "length": 3, "sigma": 1})",
                 "not after");
  expect_problem(R"({"kind": "distance", "utime": 1, "utime2": 2, "length": -3, "sigma": 1})",
                 "length");
  EXPECT_NE(read("").problem, "");
}

}  // namespace
}  // namespace eifmap
