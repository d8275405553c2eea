#include "client/publisher.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>

#include "bus/outbox.h"
#include "client/memory_bus.h"
#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/feature_parts.h"
#include "convert/image_message.h"
#include "convert/measurement_message.h"
#include "features/front_end.h"
#include "sequence/temporary_folder.h"

namespace eifmap {
namespace {

using test::Recorder;

// Three images of blotches, the second one a JPEG.
class PublisherTest : public testing::Test {
 protected:
  PublisherTest() {
    std::filesystem::create_directories(folder_.path() / "images");
    for (int i = 0; i < 3; ++i) {
      cv::Mat image(120, 160, CV_8UC1);
      for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
          image.at<std::uint8_t>(y, x) =
              static_cast<std::uint8_t>(128 + 100 * std::sin(0.3 * x + i) * std::cos(0.37 * y));
      cv::imwrite(file(i), image);
    }
    folder_.write("times.txt", "10\n10.1\n10.25\n");
    folder_.write("calib.json",
                  R"({"width": 160, "height": 120, "fx": 150, "fy": 150, "cx": 80, "cy": 60})");
  }

  std::string file(int i) const {
    const std::string name = "00000" + std::to_string(i) + (i == 1 ? ".jpg" : ".png");
    return (folder_.path() / "images" / name).string();
  }

  std::unique_ptr<ImageSource> source() const {
    auto opened = RecordedSequence::open(folder_.path());
    EXPECT_EQ(opened.problem, "");
    return make_source(std::move(*opened.sequence));
  }

  static PublishOptions options(PublishAs as) {
    PublishOptions options;
    options.camera = "left";
    options.as = as;
    options.rate_hz = 0;
    return options;
  }

  static bool always(int) { return true; }

  TemporaryFolder folder_;
};

TEST_F(PublisherTest, CalibrationComesFirst) {
  Recorder recorder;
  const auto images = source();
  publish(*images, options(PublishAs::kRaw), recorder.sender(), always);
  ASSERT_EQ(recorder.messages().size(), 4u);
  const auto& first = recorder.messages().front();
  EXPECT_EQ(first.channel, "eifmap.left.calibration");
  const auto camera = decode_camera(first.bytes);
  ASSERT_TRUE(camera.ok()) << camera.detail;
  EXPECT_EQ(camera.value.name, "left");
  EXPECT_EQ(camera.value.camera.id(), images->camera().id());
}

TEST_F(PublisherTest, RawImagesAreThePixels) {
  Recorder recorder;
  const auto images = source();
  const auto result = publish(*images, options(PublishAs::kRaw), recorder.sender(), always);
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(result.published, 3);
  EXPECT_GT(result.publisher, 0);
  for (int i = 0; i < 3; ++i) {
    const auto& message = recorder.messages().at(static_cast<std::size_t>(i) + 1);
    EXPECT_EQ(message.channel, "eifmap.left.image");
    const auto image = decode_image(message.bytes);
    ASSERT_TRUE(image.ok()) << image.detail;
    EXPECT_EQ(image.value.time_us, images->time_us(i));
    EXPECT_EQ(image.value.seq, i);
    EXPECT_EQ(image.value.publisher, result.publisher);
    EXPECT_EQ(image.value.calibration_id, images->camera().id());
    const cv::Mat gray = images->gray(i).image;
    ASSERT_EQ(image.value.data.size(), gray.total());
    EXPECT_TRUE(std::equal(image.value.data.begin(), image.value.data.end(), gray.data));
  }
}

TEST_F(PublisherTest, AJpegFileTravelsAsItIs) {
  Recorder recorder;
  const auto images = source();
  publish(*images, options(PublishAs::kMjpeg), recorder.sender(), always);
  for (int i = 0; i < 3; ++i) {
    const auto image = decode_image(recorder.messages().at(static_cast<std::size_t>(i) + 1).bytes);
    ASSERT_TRUE(image.ok()) << image.detail;
    EXPECT_EQ(image.value.format, PixelFormat::kMjpeg);
    const std::string file_bytes = read_text(file(i));
    const bool same = std::string(image.value.data.begin(), image.value.data.end()) == file_bytes;
    EXPECT_EQ(same, i == 1);
    const cv::Mat decoded = cv::imdecode(image.value.data, cv::IMREAD_GRAYSCALE);
    EXPECT_LT(cv::norm(decoded, images->gray(i).image, cv::NORM_L1) / 19200, 3);
  }
}

// Each right before the first image that is not before it.
TEST_F(PublisherTest, MeasurementsLeaveNextToTheImagesOfTheirTimes) {
  Recorder recorder;
  const auto images = source();
  auto wanted = options(PublishAs::kRaw);
  const auto at = [&](std::int64_t time_us) {
    AbsoluteMeasurement m;
    m.time_us = time_us;
    m.position = {1e-6 * static_cast<double>(time_us), 2, 3};
    wanted.measurements.push_back(m);
  };
  for (const int time_us : {9'000'000, 10'000'000, 10'000'001, 10'100'000, 10'300'000}) at(time_us);
  const auto result = publish(*images, wanted, recorder.sender(), always);
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(result.measurements, 4) << "the last is after the last image";
  std::string order;
  std::int64_t seq = 0;
  for (const auto& message : recorder.messages()) {
    order += message.channel == "eifmap.left.measurement" ? 'm' : 'i';
    if (order.back() != 'm') continue;
    const auto decoded = decode_measurement(message.bytes);
    ASSERT_TRUE(decoded.ok()) << decoded.detail;
    EXPECT_EQ(decoded.value.camera, "left");
    EXPECT_EQ(decoded.value.measurement.id, (MeasurementId{result.publisher, seq}));
    EXPECT_EQ(decoded.value.measurement.position,
              wanted.measurements[static_cast<std::size_t>(seq++)].position);
  }
  EXPECT_EQ(order, "immimmii") << "the calibration first";
}

// Whoever extracts, the numbers are the same.
TEST_F(PublisherTest, FeaturesAreThoseOfTheImage) {
  Recorder recorder;
  const auto images = source();
  auto wanted = options(PublishAs::kFeatures);
  wanted.publisher = 77;
  publish(*images, wanted, recorder.sender(), always);
  FeatureExtractor extractor;
  for (int i = 0; i < 3; ++i) {
    const auto frame =
        decode_features(recorder.messages().at(static_cast<std::size_t>(i) + 1).bytes);
    ASSERT_TRUE(frame.ok()) << frame.detail;
    EXPECT_EQ(frame.value.publisher, 77);
    const auto here = extract_frame(extractor, images->gray(i).image, images->camera(),
                                    {images->time_us(i), 77, i, "left"});
    EXPECT_GT(here.keypoints.size(), 10u);
    EXPECT_EQ(encode(to_message(frame.value)), encode(to_message(here)));
  }
}

TEST_F(PublisherTest, EachStartHasItsOwnNumber) {
  Recorder recorder;
  const auto images = source();
  const auto a = publish(*images, options(PublishAs::kRaw), recorder.sender(), always);
  const auto b = publish(*images, options(PublishAs::kRaw), recorder.sender(), always);
  EXPECT_NE(a.publisher, b.publisher);
}

TEST_F(PublisherTest, StopsWhenAskedEvenWhileWaiting) {
  Recorder recorder;
  const auto images = source();
  auto slow = options(PublishAs::kRaw);
  slow.start_delay = std::chrono::hours(10);
  int asked = 0;
  const auto result =
      publish(*images, slow, recorder.sender(), [&asked](int) { return ++asked < 4; });
  EXPECT_EQ(result.published, 0);
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(
      publish(*images, options(PublishAs::kRaw), recorder.sender(), [](int i) { return i < 2; })
          .published,
      2);
}

TEST_F(PublisherTest, ABrokenImageIsASentence) {
  folder_.write("images/000001.jpg", "no picture");
  Recorder recorder;
  const auto result = publish(*source(), options(PublishAs::kRaw), recorder.sender(), always);
  EXPECT_EQ(result.published, 1);
  EXPECT_NE(result.problem.find("000001.jpg: cannot be decoded"), std::string::npos);
}

TEST_F(PublisherTest, FirstImagesEndWithTheirTruth) {
  folder_.write("groundtruth.tum", "10 0 0 0 0 0 0 1\n10.1 1 0 0 0 0 0 1\n10.25 2 0 0 0 0 0 1\n");
  const auto two = first_images(source(), 2);
  EXPECT_EQ(two->size(), 2);
  EXPECT_EQ(two->ground_truth().size(), 2u);
  EXPECT_EQ(first_images(source(), 9)->size(), 3);
}

// Two and a half passes: times and sequence numbers go on.
TEST_F(PublisherTest, ALoopGoesOn) {
  Recorder recorder;
  const auto images = looped(source());
  EXPECT_EQ(images->size(), ImageSource::kNoEnd);
  const auto result =
      publish(*images, options(PublishAs::kRaw), recorder.sender(), [](int i) { return i < 8; });
  EXPECT_EQ(result.problem, "");
  ASSERT_EQ(result.published, 8);
  // A pass of 0.25 s, and a mean step of 0.125 s from its last image to the first again.
  const std::int64_t times_ms[] = {10000, 10100, 10250, 10375, 10475, 10625, 10750, 10850};
  const auto once = source();
  for (int i = 0; i < 8; ++i) {
    const auto image = decode_image(recorder.messages().at(static_cast<std::size_t>(i) + 1).bytes);
    ASSERT_TRUE(image.ok()) << image.detail;
    EXPECT_EQ(image.value.seq, i);
    EXPECT_EQ(image.value.time_us, 1000 * times_ms[i]);
    const cv::Mat gray = once->gray(i % 3).image;
    EXPECT_TRUE(std::equal(image.value.data.begin(), image.value.data.end(), gray.data)) << i;
  }
}

TEST_F(PublisherTest, ALoopOfOneImageAndOneThatEndsWhenAsked) {
  const auto one = looped(first_images(source(), 1));
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(one->has(i));
    EXPECT_EQ(one->time_us(i), 10'000'000 + 100'000 * i);
  }
  Recorder recorder;
  const auto five = first_images(looped(source()), 5);
  EXPECT_EQ(five->size(), 5);
  EXPECT_EQ(publish(*five, options(PublishAs::kRaw), recorder.sender(), always).published, 5);
}

// The rate of a recording: the third image leaves 0.25 s after the first.
TEST_F(PublisherTest, KeepsTheRecordedRateOrTheOneAskedFor) {
  const auto seconds = [this](double rate_hz) {
    Recorder recorder;
    auto timed = options(PublishAs::kRaw);
    timed.rate_hz = rate_hz;
    const auto begin = std::chrono::steady_clock::now();
    publish(*source(), timed, recorder.sender(), always);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  };
  const double recorded = seconds(-1), asked = seconds(5), at_once = seconds(0);
  EXPECT_GE(recorded, 0.25);
  EXPECT_LT(recorded, 0.39);
  EXPECT_GE(asked, 0.4);
  EXPECT_LT(at_once, 0.2);
}

// As a camera's: they leave when they come, and the end has a reason.
class LiveSource : public DerivedSource {
 public:
  using DerivedSource::DerivedSource;
  int size() const override { return kNoEnd; }
  bool live() const override { return true; }
  std::string problem() const override { return "unplugged"; }
};

TEST_F(PublisherTest, LiveImagesLeaveAtOnceAndTheirEndIsAProblem) {
  Recorder recorder;
  LiveSource camera(source());
  auto slow = options(PublishAs::kRaw);
  slow.rate_hz = 0.01;
  const auto result = publish(camera, slow, recorder.sender(), always);
  EXPECT_EQ(result.published, 3);
  EXPECT_EQ(result.problem, "unplugged");
}

TEST_F(PublisherTest, TheCapKeepsTheStrongestFeatures) {
  Recorder recorder;
  const auto images = source();
  auto capped = options(PublishAs::kFeatures);
  capped.features.max_features = 7;
  publish(*images, capped, recorder.sender(), always);
  for (int i = 0; i < 3; ++i) {
    const auto frame =
        decode_features(recorder.messages().at(static_cast<std::size_t>(i) + 1).bytes);
    ASSERT_TRUE(frame.ok()) << frame.detail;
    EXPECT_EQ(frame.value.keypoints.size(), 7u);
  }
}

// For a link of small datagrams: parts that fit, and together are the frame, at the pace asked for.
TEST_F(PublisherTest, LargeFramesLeaveInPacedParts) {
  Recorder whole, in_parts;
  const auto images = source();
  auto wanted = options(PublishAs::kFeatures);
  wanted.publisher = 5;
  publish(*images, wanted, whole.sender(), always);
  wanted.max_message_bytes = 1400;
  const auto once = publish(*images, wanted, in_parts.sender(), always);
  EXPECT_EQ(once.published, 3);
  EXPECT_LE(once.largest_bytes, 1400u);
  ASSERT_EQ(in_parts.messages().size(), static_cast<std::size_t>(once.messages) + 1);
  EXPECT_GT(once.messages, 6);
  FeatureAssembler assembler;
  std::vector<FeatureFrame> frames;
  std::size_t bytes = 0;
  for (std::size_t i = 1; i < in_parts.messages().size(); ++i) {
    bytes += in_parts.messages()[i].bytes.size();
    auto part = decode_feature_part(in_parts.messages()[i].bytes);
    ASSERT_TRUE(part.ok()) << part.detail;
    for (FeatureFrame& frame : assembler.add(std::move(part.value)))
      frames.push_back(std::move(frame));
  }
  ASSERT_EQ(frames.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_EQ(encode(to_message(frames[i])), whole.messages().at(i + 1).bytes);

  // So many passes that there are two bursts more than the one that is free, half a second each.
  const int passes = static_cast<int>(3 * Outbox::kBurstBytes / bytes) + 1;
  wanted.bytes_per_s = 2 * Outbox::kBurstBytes;
  Recorder paced;
  const auto begin = std::chrono::steady_clock::now();
  const auto many = publish(*looped(source()), wanted, paced.sender(),
                            [passes](int i) { return i < 3 * passes; });
  EXPECT_EQ(many.messages, passes * once.messages);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(950));
}

TEST(PublishOptions, SaysWhichIsWrong) {
  PublishOptions options;
  EXPECT_EQ(options.problem(), "");
  options.camera = "front left";
  EXPECT_NE(options.problem().find("'front left'"), std::string::npos);
  options = {};
  options.jpeg_quality = 0;
  EXPECT_NE(options.problem().find("JPEG quality is 0"), std::string::npos);
  options = {};
  options.rate_hz = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(options.problem(), "");
}

}  // namespace
}  // namespace eifmap
