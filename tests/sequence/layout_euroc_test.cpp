// EuRoC MAV: folders made here.
#include "sequence/layout_fixture.h"

namespace eifmap {
namespace {

void expect_near(const Rigid3& a, const Rigid3& b) {
  EXPECT_LT((a.translation - b.translation).norm(), 1e-9);
  EXPECT_LT(a.rotation.angularDistance(b.rotation), 1e-7);
}

constexpr const char* kSensor = R"(# General sensor definitions.
sensor_type: camera
comment: VI-Sensor cam0 (MT9M034)

# Sensor extrinsics wrt. the body-frame.
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, 0.1,
         1.0, 0.0, 0.0, 0.2,
         0.0, 0.0, 1.0, 0.3,
         0.0, 0.0, 0.0, 1.0]

# Camera specific definitions.
rate_hz: 20
resolution: [64, 48]
camera_model: pinhole
intrinsics: [50.5, 51.5, 32.25, 24.75] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.7e-05]
)";

class EurocTest : public test::LayoutTest {
 protected:
  EurocTest() {
    folder_.image("mav0/cam0/data/1403636579763555584.png", 7);
    folder_.image("mav0/cam0/data/1403636579813555456.png", 8);
    folder_.write("mav0/cam0/data.csv",
                  "#timestamp [ns],filename\r\n"
                  "1403636579763555584,1403636579763555584.png\r\n"
                  "1403636579813555456,1403636579813555456.png\r\n");
    folder_.write("mav0/cam0/sensor.yaml", kSensor);
  }

  void truth(const std::string& rows) const {
    folder_.write("mav0/state_groundtruth_estimate0/data.csv",
                  "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], "
                  "q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n" +
                      rows);
  }
};

TEST_F(EurocTest, ReadsTheCameraAndItsLens) {
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  const RecordedSequence& sequence = *opened.sequence;
  EXPECT_EQ(sequence.layout(), "EuRoC MAV");
  expect_grays(sequence, {7, 8});
  EXPECT_EQ(sequence.time_us(0), 1403636579763556);  // nanoseconds, rounded
  EXPECT_EQ(sequence.time_us(1), 1403636579813555);
  const Camera& camera = sequence.camera();
  EXPECT_EQ(camera.model, CameraModel::kRadialTangential);
  EXPECT_EQ(camera.fx, 50.5);
  EXPECT_EQ(camera.fy, 51.5);
  EXPECT_EQ(camera.cx, 32.25);
  EXPECT_EQ(camera.cy, 24.75);
  EXPECT_EQ(camera.distortion, (std::array{-0.28, 0.07, 0.0002, 1.7e-05, 0.0}));
  EXPECT_TRUE(sequence.ground_truth().empty());
  const auto inside = RecordedSequence::open(folder_.path() / "mav0");
  EXPECT_EQ(inside.problem, "");
}

// The truth is the body's. The camera sits at (0.1, 0.2, 0.3) of it, turned by 90 degrees about its
// z axis.
TEST_F(EurocTest, TruthIsTurnedIntoTheCamerasPose) {
  truth(
      "1403636579763555584,4,5,6,1,0,0,0,9,9\n"
      "1403636579813555456,4,5,6,0.70710678,0,0.70710678,0,9,9\n");
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  const auto& poses = opened.sequence->ground_truth();
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_NEAR(poses[0].time_s, 1403636579.763556, 1e-6);
  const double quarter = M_PI / 2;
  expect_near(poses[0].world_from_camera, {so3_exp({0, 0, quarter}), {4.1, 5.2, 6.3}});
  // The body is turned by 90 degrees about y: its x points along the world's -z, its z along x.
  expect_near(poses[1].world_from_camera,
              {so3_exp({0, quarter, 0}) * so3_exp({0, 0, quarter}), {4.3, 5.2, 5.9}});
  // Where the camera looks: along the body's z, which is the world's x.
  EXPECT_LT(
      (poses[1].world_from_camera.rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitX())
          .norm(),
      1e-7);
}

TEST_F(EurocTest, AFisheyeInTheSameLayout) {
  std::string sensor = kSensor;
  sensor.replace(sensor.find("radial-tangential"), 17, "equidistant");
  sensor.replace(sensor.find("[-0.28"), std::string::npos, "[0.003, 0.0007, -0.0002, 0.00002]\n");
  folder_.write("mav0/cam0/sensor.yaml", sensor);
  const auto opened = open();
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.sequence->camera().model, CameraModel::kFisheye);
  EXPECT_EQ(opened.sequence->camera().distortion[3], 0.00002);
}

TEST_F(EurocTest, SaysWhichFileAndLineIsWrong) {
  const auto sensor = [this](const char* from, const char* to) {
    std::string text = kSensor;
    text.replace(text.find(from), std::string(from).size(), to);
    folder_.write("mav0/cam0/sensor.yaml", text);
  };
  sensor("50.5, 51.5", "51.5");
  expect_problem({"sensor.yaml line 18: has 3 numbers; wanted 4: fx fy cx cy"});
  sensor("51.5, 32", "wide, 32");
  expect_problem({"sensor.yaml line 18: 'wide' is no finite number"});
  sensor("intrinsics", "internals");
  expect_problem({"sensor.yaml: 'intrinsics' is missing"});
  sensor("radial-tangential", "double-sphere");
  expect_problem({"sensor.yaml line 19: distortion_model is 'double-sphere'"});
  sensor("-0.28, ", "-0.28, [");
  expect_problem({"sensor.yaml line "});
  sensor("-1.0, 0.0, 0.1", "-2.0, 0.0, 0.1");
  expect_problem({"sensor.yaml line ", "T_BS is no rigid transform"});
  sensor("50.5", "-50.5");
  expect_problem({"sensor.yaml: camera: fx is -50.5"});
  folder_.write("mav0/cam0/sensor.yaml", "");
  expect_problem({"sensor.yaml: cannot be read, or is empty"});
  std::filesystem::remove(folder_.path() / "mav0/cam0/sensor.yaml");
  expect_problem({"has no calibration"});
  folder_.write("mav0/cam0/sensor.yaml", kSensor);

  truth("1403636579763555584,4,5,6,1,0,0\n");
  expect_problem({"data.csv line 2: has 7 words; wanted 8"});
  truth("1403636579763555584,4,5,6,1,0,0,zero\n");
  expect_problem({"data.csv line 2: 'zero' is no finite number"});
  truth("1403636579763555584,4,5,6,0,0,0,0\n");
  expect_problem({"data.csv line 2: the quaternion is not of length 1"});
  truth("1403636579.76,4,5,6,1,0,0,0\n");
  expect_problem({"state_groundtruth_estimate0/data.csv line 2: '1403636579.76' is no time"});
  truth("");
  EXPECT_EQ(open().problem, "");

  folder_.write("mav0/cam0/data.csv", "#timestamp [ns],filename\n1403636579763555584,a.png\n");
  expect_problem({"data.csv line 2: ", "cam0/data/a.png is not there"});
  std::filesystem::remove(folder_.path() / "mav0/cam0/data.csv");
  expect_problem({"cam0/data.csv: cannot be read"});
}

TEST_F(EurocTest, TruthWithoutThePlaceOfTheCameraIsPassedOver) {
  truth("1403636579763555584,4,5,6,1,0,0,0\n");
  std::filesystem::remove(folder_.path() / "mav0/cam0/sensor.yaml");
  const auto opened = open(hfov(60));
  ASSERT_EQ(opened.problem, "");
  EXPECT_TRUE(opened.sequence->ground_truth().empty());
  ASSERT_EQ(opened.sequence->notes().size(), 2u);
  EXPECT_NE(opened.sequence->notes()[0].find("is passed over"), std::string::npos);
}

}  // namespace
}  // namespace eifmap
