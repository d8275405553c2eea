#include "sequence/camera_file.h"

#include <gtest/gtest.h>

#include "sequence/image_file.h"
#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

// As ROS's camera_calibration writes it.
constexpr const char* kCameraInfo = R"(image_width: 640
image_height: 480
camera_name: head_camera
camera_matrix:
  rows: 3
  cols: 3
  data: [438.7, 0.0, 305.5, 0.0, 437.3, 243.7, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.36, 0.11, 0.001, -0.0005, 0.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.6, 0, 322.7, 0, 0, 393.6, 241.0, 0, 0, 0, 1, 0]
)";

// As cv::FileStorage writes it, OpenCV's own calibration program among others.
constexpr const char* kOpenCv = R"(%YAML:1.0
---
calibration_time: "Tue 01 Jan 2019"
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3e+02, 0., 320.5, 0., 5.31e+02,
       240.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -2.6e-01, -4.6e-02, 1.8e-03, -3.1e-04, 2.5e-01 ]
)";

class CameraFileTest : public testing::Test {
 protected:
  CameraFile read(const std::string& text, const std::string& name = "camera.yaml") const {
    return read_camera(folder_.write(name, text));
  }
  std::string problem_with(const std::string& from, const std::string& to) const {
    std::string text = kCameraInfo;
    text.replace(text.find(from), from.size(), to);
    return read(text).problem;
  }
  TemporaryFolder folder_;
};

TEST_F(CameraFileTest, ReadsCameraInfo) {
  for (const char* name : {"camera.yaml", "camera.yml"}) {
    const CameraFile file = read(kCameraInfo, name);
    ASSERT_EQ(file.problem, "");
    EXPECT_EQ(file.camera.width, 640);
    EXPECT_EQ(file.camera.height, 480);
    EXPECT_EQ(file.camera.fx, 438.7);
    EXPECT_EQ(file.camera.fy, 437.3);
    EXPECT_EQ(file.camera.cx, 305.5);
    EXPECT_EQ(file.camera.cy, 243.7);
    EXPECT_EQ(file.camera.model, CameraModel::kRadialTangential);
    EXPECT_EQ(file.camera.distortion[0], -0.36);
    EXPECT_EQ(file.camera.distortion[3], -0.0005);
  }
}

TEST_F(CameraFileTest, ReadsWhatOpenCvWrites) {
  const CameraFile file = read(kOpenCv);
  ASSERT_EQ(file.problem, "");
  EXPECT_EQ(file.camera.fx, 530);
  EXPECT_EQ(file.camera.cy, 240.5);
  EXPECT_EQ(file.camera.distortion[4], 0.25);
}

// As `rostopic echo` prints the message.
TEST_F(CameraFileTest, ReadsTheMessageAsText) {
  const CameraFile file = read(
      "height: 480\nwidth: 640\ndistortion_model: equidistant\nD: [0.01, 0.002, 0, 0]\n"
      "K: [300, 0, 320, 0, 301, 240, 0, 0, 1]\n");
  ASSERT_EQ(file.problem, "");
  EXPECT_EQ(file.camera.model, CameraModel::kFisheye);
  EXPECT_EQ(file.camera.fy, 301);
}

TEST_F(CameraFileTest, NoDistortionIsAPinhole) {
  const CameraFile file =
      read("height: 480\nwidth: 640\nD: []\nK: [300, 0, 320, 0, 301, 240, 0, 0, 1]\n");
  ASSERT_EQ(file.problem, "");
  EXPECT_EQ(file.camera.model, CameraModel::kPinhole);
}

TEST_F(CameraFileTest, SaysWhichLineOfTheYamlIsWrong) {
  const auto has = [](const std::string& problem, const std::string& wanted) {
    EXPECT_NE(problem.find(wanted), std::string::npos) << "got: " << problem;
    EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
  };
  has(problem_with("438.7, ", ""), "camera.yaml line 5: has 8 numbers; wanted 9");
  has(problem_with("438.7", "wide"), "camera.yaml line 7: 'wide' is no finite number");
  has(problem_with("image_width", "image_breadth"), "'image_width' is missing");
  has(problem_with("640", "640.5"), "camera.yaml line 1: '640.5' is no size");
  has(problem_with("plumb_bob", "thin_prism"), "line 8: distortion_model is 'thin_prism'");
  has(problem_with("-0.0005, 0.0", "-0.0005, 0.0, 0.1, 0.1, 0.1"), "has 8 coefficients");
  has(problem_with("438.7", "-438.7"), "camera.yaml: camera: fx is -438.7");
  has(problem_with("camera_name: head", "camera_name: [head"), "camera.yaml line ");
  has(read("just words").problem, "holds no keys");
  has(read("").problem, "cannot be read, or is empty");
  has(read_camera(folder_.path() / "none.yaml").problem, "cannot be read, or is empty");
}

TEST_F(CameraFileTest, SaysWhichLineOfTheJsonIsWrong) {
  const std::string problem =
      read("{\"width\": 640,\n\"height\": 480,\n\"fx\": 500 \"fy\": 500}", "calib.json").problem;
  EXPECT_NE(problem.find("calib.json line 3: is no JSON"), std::string::npos) << problem;
  EXPECT_NE(read("[1]", "calib.json").problem.find("is no JSON object"), std::string::npos);
  EXPECT_NE(read("{\"width\": 1e999}", "calib.json").problem.find("a number that is too large"),
            std::string::npos);
}

TEST(NaturalOrder, CountsAsPeopleDo) {
  EXPECT_TRUE(natural_less("frame9.png", "frame10.png"));
  EXPECT_FALSE(natural_less("frame10.png", "frame9.png"));
  EXPECT_TRUE(natural_less("a007.png", "a10.png"));
  EXPECT_TRUE(natural_less("a1b2.png", "a1b10.png"));
  EXPECT_TRUE(natural_less("a.png", "b.png"));
  EXPECT_TRUE(natural_less("a1", "a1b"));
  // Numbers longer than any integer, and equal ones that are written differently.
  EXPECT_TRUE(natural_less("99999999999999999999998", "99999999999999999999999"));
  EXPECT_NE(natural_less("7", "007"), natural_less("007", "7"));
  EXPECT_FALSE(natural_less("a", "a"));
}

}  // namespace
}  // namespace eifmap
