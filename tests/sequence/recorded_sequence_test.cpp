#include "sequence/recorded_sequence.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "sequence/camera_file.h"
#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

constexpr const char* kCalibration =
    R"({"width": 64, "height": 48, "fx": 50, "fy": 51, "cx": 31.5, "cy": 23.5,
        "distortion": [0, 0, 0, 0, 0], "rectified": true})";

// Three images whose gray is 10 times their number; names out of order of creation.
class RecordedSequenceTest : public testing::Test {
 protected:
  RecordedSequenceTest() {
    std::filesystem::create_directories(folder_.path() / "images");
    for (int i : {2, 0, 1})
      cv::imwrite((folder_.path() / "images" / ("00000" + std::to_string(i) + ".png")).string(),
                  cv::Mat(48, 64, CV_8UC1, cv::Scalar(10 * i)));
    folder_.write("images/readme.txt", "no image");
    folder_.write("times.txt", "100.0000004\n100.0333336\n\n100.1\n");
    folder_.write("calib.json", kCalibration);
  }

  std::string problem() const { return RecordedSequence::open(folder_.path()).problem; }
  void expect_problem(const std::string& wanted) const {
    EXPECT_NE(problem().find(wanted), std::string::npos) << "got: " << problem();
  }

  TemporaryFolder folder_;
};

TEST_F(RecordedSequenceTest, ReadsAFolder) {
  const auto opened = RecordedSequence::open(folder_.path());
  ASSERT_EQ(opened.problem, "");
  const auto& sequence = *opened.sequence;
  ASSERT_EQ(sequence.size(), 3);
  EXPECT_EQ(sequence.time_us(0), 100000000);
  EXPECT_EQ(sequence.time_us(1), 100033334);  // rounded, not cut
  EXPECT_EQ(sequence.camera().fy, 51);
  EXPECT_EQ(sequence.camera().model, CameraModel::kPinhole);
  EXPECT_TRUE(sequence.ground_truth().empty());
  for (int i = 0; i < 3; ++i) {
    const auto image = sequence.load_gray(i);
    ASSERT_EQ(image.problem, "");
    EXPECT_EQ(image.image.type(), CV_8UC1);
    EXPECT_EQ(image.image.at<std::uint8_t>(7, 9), 10 * i);
    const std::string bytes = read_text(sequence.image_file(i));
    const auto file = sequence.load_bytes(i);
    EXPECT_EQ(std::string(file.bytes.begin(), file.bytes.end()), bytes);
  }
  EXPECT_THROW(sequence.load_gray(3), std::out_of_range);
}

TEST_F(RecordedSequenceTest, ReadsDistortionAndTruth) {
  folder_.write("calib.json", R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 32, "cy": 24,
                                  "distortion": [-0.28, 0.07, 0.0002, 0.00002, 0]})");
  folder_.write("groundtruth.tum", "100 1 2 3 0 0 0 1\n");
  const auto opened = RecordedSequence::open(folder_.path());
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.sequence->camera().model, CameraModel::kRadialTangential);
  EXPECT_EQ(opened.sequence->camera().distortion[1], 0.07);
  ASSERT_EQ(opened.sequence->ground_truth().size(), 1u);
}

TEST_F(RecordedSequenceTest, ReadsTheModel) {
  const auto model_of = [this](const std::string& rest) {
    folder_.write("calib.json",
                  R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 32, "cy": 24, )" + rest);
    const CameraFile file = read_camera(folder_.path() / "calib.json");
    EXPECT_EQ(file.problem, "");
    return file.camera.model;
  };
  EXPECT_EQ(model_of(R"("model": "fisheye", "distortion": [0.01, 0.002, 0, 0]})"),
            CameraModel::kFisheye);
  EXPECT_EQ(model_of(R"("model": "fisheye"})"), CameraModel::kFisheye);
  EXPECT_EQ(model_of(R"("model": "pinhole", "distortion": [0, 0]})"), CameraModel::kPinhole);
  EXPECT_EQ(model_of(R"("model": "radial_tangential", "distortion": [-0.1]})"),
            CameraModel::kRadialTangential);
}

TEST_F(RecordedSequenceTest, SaysWhichFileAndValueIsWrong) {
  folder_.write("times.txt", "1\n2\n");
  expect_problem("times.txt: has 2 times for 3 images");
  folder_.write("times.txt", "1\n3\n2\n");
  expect_problem("times.txt line 3: 2 s is not after");
  folder_.write("times.txt", "1\ntwo\n3\n");
  expect_problem("times.txt line 2: 'two' is no time");
  std::filesystem::remove(folder_.path() / "times.txt");
  expect_problem("times.txt: cannot be read");
  EXPECT_NE(RecordedSequence::open(folder_.path() / "none").problem.find("is no folder"),
            std::string::npos);
}

TEST_F(RecordedSequenceTest, SaysWhatIsWrongWithTheCalibration) {
  folder_.write("calib.json", "{\"width\": 64,");
  expect_problem("calib.json line 1: is no JSON");
  folder_.write("calib.json", R"({"width": 64, "height": 48, "fx": 50, "cx": 32, "cy": 24})");
  expect_problem("calib.json: 'fy' is missing");
  folder_.write("calib.json", R"({"width": 64.5, "height": 48})");
  expect_problem("'width' is 64.5");
  folder_.write("calib.json",
                R"({"width": 64, "height": 48, "fx": -5, "fy": 5, "cx": 1, "cy": 1})");
  expect_problem("calib.json: camera: fx is -5");
  folder_.write("calib.json",
                R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 1, "cy": 1,
                    "distortion": [1, "two"]})");
  expect_problem("'distortion' is");
  const std::string numbers =
      R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 1, "cy": 1,)";
  folder_.write("calib.json", numbers + R"("model": "double_sphere"})");
  expect_problem("'model' is \"double_sphere\"");
  folder_.write("calib.json", numbers + R"("model": "pinhole", "distortion": [0.1]})");
  expect_problem("'model' is pinhole");
  folder_.write("calib.json", numbers + R"("model": "fisheye", "distortion": [0, 0, 0, 0, 0.1]})");
  expect_problem("a fisheye has k1 k2 k3 k4");
}

TEST_F(RecordedSequenceTest, BadImagesAreSentencesToo) {
  folder_.write("images/000000.png", "this is no PNG");
  folder_.write("images/000002.png", "");
  cv::imwrite((folder_.path() / "images" / "000001.png").string(),
              cv::Mat(10, 64, CV_8UC1, cv::Scalar(1)));
  const auto opened = RecordedSequence::open(folder_.path());
  ASSERT_EQ(opened.problem, "");
  EXPECT_NE(opened.sequence->load_gray(0).problem.find("cannot be decoded"), std::string::npos);
  EXPECT_NE(opened.sequence->load_gray(1).problem.find("is 64x10, but calib.json says 64x48"),
            std::string::npos);
  EXPECT_NE(opened.sequence->load_gray(2).problem.find("cannot be read, or is empty"),
            std::string::npos);
}

// Every image would be refused: better said at once.
TEST_F(RecordedSequenceTest, AFirstImageOfAnotherSizeIsAnotherCamera) {
  cv::imwrite((folder_.path() / "images" / "000000.png").string(),
              cv::Mat(96, 128, CV_8UC1, cv::Scalar(1)));
  expect_problem("the images are 128x96, but calib.json says 64x48");
}

}  // namespace
}  // namespace eifmap
