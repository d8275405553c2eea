#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "capture/open_source.h"
#include "sequence/image_folder.h"

namespace eifmap {
namespace {

constexpr int kImages = 7;

class VideoTest : public testing::Test {
 protected:
  // Uniform images, each 30 brighter than the last: compression does not mix them up.
  VideoTest() : file_(folder_.path() / "walk.avi") {
    cv::VideoWriter writer(file_.string(), cv::CAP_OPENCV_MJPEG,
                           cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {64, 48});
    EXPECT_TRUE(writer.isOpened());
    for (int i = 0; i < kImages; ++i)
      writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 + 30 * i)));
  }

  std::unique_ptr<ImageSource> open() const {
    OpenedSource opened = open_source(file_.string(), hfov(60));
    EXPECT_EQ(opened.problem, "");
    return std::move(opened.source);
  }

  static SequenceOptions hfov(double degrees) {
    SequenceOptions options;
    options.hfov_deg = degrees;
    return options;
  }

  static int gray_of(ImageSource& source, int i) {
    const GrayImage image = source.gray(i);
    EXPECT_EQ(image.problem, "");
    EXPECT_EQ(image.image.type(), CV_8UC1);
    return image.image.empty() ? -1 : image.image.at<std::uint8_t>(20, 30);
  }

  std::string problem_of(const std::string& what, const SequenceOptions& options) const {
    const std::string problem = open_source(what, options).problem;
    EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
    return problem;
  }
  void expect_problem(const std::string& what, const std::string& wanted,
                      const SequenceOptions& options = hfov(60)) const {
    const std::string problem = problem_of(what, options);
    EXPECT_NE(problem.find(wanted), std::string::npos) << "got: " << problem;
  }

  test::ImageFolder folder_;
  std::filesystem::path file_;
};

TEST_F(VideoTest, GivesItsImages) {
  const auto source = open();
  ASSERT_TRUE(source);
  EXPECT_EQ(source->name(), "walk.avi");
  EXPECT_EQ(source->kind(), "video");
  EXPECT_FALSE(source->live());
  EXPECT_EQ(source->size(), kImages);
  EXPECT_EQ(source->camera().width, 64);
  EXPECT_EQ(source->camera().height, 48);
  EXPECT_EQ(source->camera().cx, 31.5);
  ASSERT_EQ(source->notes().size(), 1u) << "of the guess alone: the container has a rate";
  for (int i = 0; i < kImages; ++i) {
    ASSERT_TRUE(source->has(i)) << i;
    EXPECT_NEAR(gray_of(*source, i), 20 + 30 * i, 3) << i;
  }
  EXPECT_FALSE(source->has(kImages));
  EXPECT_EQ(source->problem(), "") << "the end of a recording is none";
}

TEST_F(VideoTest, TimesAreTheContainers) {
  const auto source = open();
  for (int i = 0; i < kImages; ++i) EXPECT_EQ(source->time_us(i), 40000 * i) << "25 a second";
}

TEST_F(VideoTest, ImagesMayBePassedOverAndBeginAgain) {
  const auto source = open();
  ASSERT_TRUE(source->has(4));
  EXPECT_NEAR(gray_of(*source, 4), 140, 3);
  const std::int64_t time = source->time_us(4);
  EXPECT_FALSE(source->has(50));
  ASSERT_TRUE(source->has(0));
  EXPECT_NEAR(gray_of(*source, 0), 20, 3);
  ASSERT_TRUE(source->has(4));
  EXPECT_EQ(source->time_us(4), time);
}

TEST_F(VideoTest, WantsACalibrationOfItsSize) {
  expect_problem(file_.string(), "has no calibration; give it by --calib FILE", {});
  SequenceOptions options;
  options.calibration = folder_.write(
      "calib.json", R"({"width": 640, "height": 480, "fx": 500, "fy": 500, "cx": 320, "cy": 240})");
  expect_problem(file_.string(), "the images are 64x48, but", options);
  options.calibration = folder_.write(
      "calib.json", R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 32, "cy": 24})");
  const OpenedSource opened = open_source(file_.string(), options);
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.source->camera().fx, 50);
  EXPECT_TRUE(opened.source->notes().empty());
}

TEST_F(VideoTest, WhatIsNoneIsASentence) {
  testing::internal::CaptureStderr();
  expect_problem(folder_.write("text.avi", "this is no video").string(),
                 "text.avi: cannot be opened as a video");
  expect_problem(folder_.write("empty.mp4", "").string(), "empty.mp4: cannot be opened as a video");
  std::string bytes = read_text(file_);
  expect_problem(folder_.write("short.avi", bytes.substr(0, 500)).string(), "short.avi: ");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << "a library does not print";
}

TEST_F(VideoTest, OneImageIsNoVideo) {
  expect_problem(folder_.image("one.png", 5).string(),
                 "one.png: is a single image; give the folder");
}

TEST_F(VideoTest, ACameraThatIsNotThere) {
  testing::internal::CaptureStderr();
  expect_problem("/dev/video987", "/dev/video987: there is no such camera");
  expect_problem("987", "/dev/video987: there is no such camera");
  expect_problem("/dev/null", "/dev/null: cannot be opened as a camera");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(VideoTest, NothingThereSaysWhatMayBe) {
  expect_problem((folder_.path() / "none").string(),
                 "does not exist; give a folder of images, a video file, or a camera");
}

TEST_F(VideoTest, AFolderIsARecordedSequence) {
  folder_.image("shots/1.png", 40);
  const OpenedSource opened = open_source((folder_.path() / "shots/").string(), hfov(60));
  ASSERT_EQ(opened.problem, "");
  EXPECT_EQ(opened.source->name(), "shots");
  EXPECT_EQ(opened.source->kind(), "plain");
  EXPECT_TRUE(opened.source->has(0));
  EXPECT_FALSE(opened.source->has(1));
}

}  // namespace
}  // namespace eifmap
