#include "server/camera_mapper.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/image_message.h"
#include "features/front_end.h"
#include "server/held.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

const Channel kFeatures{"cam0", ChannelKind::kFeatures};
const Channel kImage{"cam0", ChannelKind::kImage};

std::vector<std::uint8_t> calibration(const Camera& camera, const std::string& name = "cam0") {
  return encode(to_message(NamedCamera{1, name, camera}));
}

std::vector<std::uint8_t> bytes(const FeatureFrame& frame) {
  return encode(to_message(frame));
}

Camera changed_camera() {
  Camera camera = synthetic_camera();
  camera.fx = 510;
  return camera;
}

// Each keyframe at once, as map_alone() does it: timing decides nothing.
ServerConfig at_once() {
  ServerConfig config;
  config.handover_frames = 0;
  return config;
}

std::vector<FrameResult> map_alone(int frames) {
  const SyntheticStream stream;
  Mapper mapper(synthetic_camera(), {});
  std::vector<FrameResult> results;
  for (int i = 0; i < frames; ++i) results.push_back(mapper.process(stream.frame(i)));
  return results;
}

void expect_same(const FrameResult& a, const FrameResult& b) {
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.map_from_camera.rotation.coeffs(), b.map_from_camera.rotation.coeffs());
  EXPECT_EQ(a.map_from_camera.translation, b.map_from_camera.translation);
}

TEST(CameraMapper, WithoutCalibrationFramesAreRejected) {
  CameraMapper mapper{ServerConfig{}};
  const FrameResult result = mapper.take_frame(kFeatures, bytes(SyntheticStream().frame(0))).result;
  EXPECT_TRUE(result.rejected);
  EXPECT_EQ(result.reason, Reason::kNoCalibration);
  EXPECT_EQ(mapper.camera(), "");
}

TEST(CameraMapper, CalibrationOfTheConfigurationStays) {
  ServerConfig config;
  config.calibration = synthetic_camera();
  CameraMapper mapper(config);
  EXPECT_FALSE(mapper.take_frame(kFeatures, bytes(SyntheticStream().frame(0))).result.rejected);
  EXPECT_EQ(mapper.camera(), "cam0");
  EXPECT_EQ(mapper.take_calibration("cam0", calibration(synthetic_camera())).reason, Reason::kNone);
  EXPECT_EQ(mapper.take_calibration("cam0", calibration(changed_camera())).reason,
            Reason::kCalibrationMismatch);
}

// Who asks for no results has none noted, and is told so; poses are the same.
TEST(CameraMapper, NotesNoResultsUnlessItIsToWriteThem) {
  ServerConfig config = at_once();
  config.calibration = synthetic_camera();
  CameraMapper mapper(config);
  mapper.keep_no_results();
  const SyntheticStream stream;
  const std::vector<FrameResult> alone = map_alone(6);
  for (int i = 0; i < 6; ++i)
    expect_same(mapper.take_frame(kFeatures, bytes(stream.frame(i))).result,
                alone[static_cast<std::size_t>(i)]);
  EXPECT_FALSE(mapper.has_results());
  EXPECT_EQ(mapper.write_results("nowhere"), "no results were kept");
  EXPECT_FALSE(std::filesystem::exists("nowhere"));
}

// What is refused costs nothing that is mapped: the poses are those of the good frames alone.
TEST(CameraMapper, RejectedInputLeavesTheMapAsItIs) {
  const SyntheticStream stream;
  const std::vector<FrameResult> expected = map_alone(25);
  EXPECT_EQ(expected.back().state, TrackingState::kTracking) << "else this test shows little";
  CameraMapper mapper{at_once()};
  ASSERT_EQ(mapper.take_calibration("cam0", calibration(synthetic_camera())).reason, Reason::kNone);

  const auto expect_rejected = [&](const Channel& channel, Bytes wire, Reason reason) {
    const CameraMapper::Mapped mapped = mapper.take_frame(channel, wire);
    EXPECT_TRUE(mapped.result.rejected);
    EXPECT_EQ(mapped.result.reason, reason);
    EXPECT_FALSE(mapped.update);
  };
  for (int i = 0; i < 25; ++i) {
    const FeatureFrame frame = stream.frame(i);
    expect_same(mapper.take_frame(kFeatures, bytes(frame)).result, expected[i]);

    expect_rejected(kFeatures, bytes(frame), Reason::kTimeNotIncreasing);
    expect_rejected(kImage, bytes(frame), Reason::kMalformedMessage);
    FeatureFrame other = stream.frame(i + 1);
    other.calibration_id = changed_camera().id();
    expect_rejected(kFeatures, bytes(other), Reason::kCalibrationMismatch);
    other = stream.frame(i + 1);
    other.camera = "cam1";
    expect_rejected(kFeatures, bytes(other), Reason::kMalformedMessage);
    other = stream.frame(i + 1);
    other.keypoints[3].laplacian_sign = 0;
    expect_rejected(kFeatures, bytes(other), Reason::kBadFeatures);
    EXPECT_EQ(mapper.take_calibration("cam0", bytes(frame)).reason, Reason::kMalformedMessage);
    EXPECT_EQ(mapper.take_calibration("cam0", calibration(synthetic_camera())).reason,
              Reason::kNone);
  }
  EXPECT_EQ(mapper.statistics().starts, 1);
}

TEST(CameraMapper, ChangedCalibrationBeginsANewMapWithANewNumber) {
  const SyntheticStream stream;
  CameraMapper mapper{ServerConfig{}};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  std::int64_t first_map = 0, second_map = 0, first_epoch = 0, second_epoch = 0;
  for (int i = 0; i < 25; ++i) {
    const FrameResult result = mapper.take_frame(kFeatures, bytes(stream.frame(i))).result;
    first_map = result.map_id;
    first_epoch = result.map_epoch;
  }
  ASSERT_GT(first_map, 0);

  EXPECT_EQ(mapper.take_calibration("cam0", calibration(changed_camera())).reason, Reason::kNone);
  bool whole = false;
  for (int i = 0; i < 25; ++i) {  // the clock begins again, too
    FeatureFrame frame = stream.frame(i);
    frame.calibration_id = changed_camera().id();
    const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(frame));
    ASSERT_FALSE(mapped.result.rejected) << mapped.result.detail;
    EXPECT_EQ(mapped.new_calibration.empty(), i > 0);
    second_map = mapped.result.map_id;
    second_epoch = mapped.result.map_epoch;
    if (!mapped.update) continue;
    EXPECT_EQ(mapped.update->map_id, second_map);
    EXPECT_EQ(mapped.update->map_epoch, second_epoch);
    whole = whole || mapped.update->base_seq == -1;
  }
  EXPECT_GT(second_map, first_map);
  EXPECT_GT(second_epoch, first_epoch) << "clients order maps by it";
  EXPECT_TRUE(whole) << "the first update of a new map is a whole map";
}

TEST(CameraMapper, AnotherCalibrationWithoutFramesOfItsOwnChangesNothing) {
  const SyntheticStream stream;
  const std::vector<FrameResult> expected = map_alone(25);
  CameraMapper mapper{at_once()};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  for (int i = 0; i < 25; ++i) {
    if (i > 0) mapper.take_calibration("cam0", calibration(changed_camera()));
    mapper.take_calibration("cam0", calibration(synthetic_camera()));
    FeatureFrame frame = stream.frame(i);
    if (i % 2 == 1) frame.calibration_id = 0;
    const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(frame));
    expect_same(mapped.result, expected[static_cast<std::size_t>(i)]);
    EXPECT_EQ(mapped.new_calibration, "");
  }
  EXPECT_EQ(mapper.statistics().starts, 1);
}

// A frame that names no calibration belongs to the one of its size.
TEST(CameraMapper, TheSizeTellsWhichCalibration) {
  const SyntheticStream stream;
  Camera larger = synthetic_camera();
  larger.width += 160;
  CameraMapper mapper{ServerConfig{}};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  ASSERT_FALSE(mapper.take_frame(kFeatures, bytes(stream.frame(0))).result.rejected);
  mapper.take_calibration("cam0", calibration(larger));
  FeatureFrame frame = stream.frame(1);
  frame.calibration_id = 0;
  EXPECT_EQ(mapper.take_frame(kFeatures, bytes(frame)).new_calibration, "");
  frame = stream.frame(2);
  frame.calibration_id = 0;
  frame.width = larger.width;
  const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(frame));
  EXPECT_FALSE(mapped.result.rejected) << mapped.result.detail;
  EXPECT_NE(mapped.new_calibration, "");
}

TEST(CameraMapper, AFaultOfOursCostsTheFrameAndNotTheMap) {
  const SyntheticStream stream;
  CameraMapper mapper{ServerConfig{}};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  FrameResult before;
  for (int i = 0; i < 25; ++i) before = mapper.take_frame(kFeatures, bytes(stream.frame(i))).result;
  ASSERT_EQ(before.state, TrackingState::kTracking);

  mapper.set_step_observer([](std::string_view step, bool begins) {
    if (step == "observe" && begins) throw std::invalid_argument("two of a kind");
  });
  const CameraMapper::Mapped fault = mapper.take_frame(kFeatures, bytes(stream.frame(25)));
  EXPECT_TRUE(fault.result.rejected);
  EXPECT_EQ(fault.result.reason, Reason::kInternalError);
  EXPECT_EQ(fault.result.detail, "two of a kind");
  EXPECT_FALSE(fault.update);

  mapper.set_step_observer({});
  const FrameResult after = mapper.take_frame(kFeatures, bytes(stream.frame(26))).result;
  EXPECT_EQ(after.state, TrackingState::kTracking);
  EXPECT_EQ(after.map_id, before.map_id);
}

// `around_job`: in the thread of the keyframes.
Handover beside(std::function<void()> around_job) {
  return {Handover::When::kWhenDone, 0, {}, std::move(around_job)};
}

// Maps until a keyframe's job is there, and returns the last update before it; `next`: the frame
// after the keyframe's.
MapUpdate map_until_beside(CameraMapper& mapper, const SyntheticStream& stream, int& next) {
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  MapUpdate last;
  for (next = 0; next < 60 && !mapper.maps_beside(); ++next) {
    const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(stream.frame(next)));
    if (mapped.update) last = *mapped.update;
  }
  return last;
}

TEST(CameraMapper, BeforeItOnlyLocalizesTheKeyframeUnderWayComesIntoTheMap) {
  using namespace std::chrono_literals;
  const SyntheticStream stream;
  Held held;
  CameraMapper mapper(ServerConfig{}, beside([&held] { held.wait(); }));
  int next = 0;
  const MapUpdate before = map_until_beside(mapper, stream, next);
  const std::int64_t keyframes = mapper.statistics().keyframes;
  auto command = std::async(std::launch::async, [&mapper] { mapper.localize_only(true); });
  EXPECT_EQ(command.wait_for(50ms), std::future_status::timeout) << "the job is held";
  held.release();
  command.get();

  EXPECT_TRUE(mapper.localizes_only());
  EXPECT_EQ(mapper.statistics().keyframes, keyframes + 1);
  const std::optional<MapUpdate> update = mapper.take_commanded();
  ASSERT_TRUE(update);
  EXPECT_EQ(update->base_seq, before.seq);
  const std::int64_t time_us = stream.frame(next - 1).time_us;
  EXPECT_TRUE(std::any_of(update->keyframes.begin(), update->keyframes.end(),
                          [time_us](const KeyframeView& k) { return k.time_us == time_us; }));

  int tracked = 0;
  for (int i = next; i < next + 20; ++i) {
    const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(stream.frame(i)));
    tracked += mapped.result.state == TrackingState::kTracking;
    EXPECT_EQ(mapped.result.map_seq, update->seq);
    EXPECT_FALSE(mapped.update);
    EXPECT_FALSE(mapper.maps_beside());
  }
  EXPECT_GE(tracked, 10) << "else this shows little";
  EXPECT_EQ(mapper.statistics().keyframes, keyframes + 1);
  mapper.localize_only(true);
  EXPECT_FALSE(mapper.take_commanded()) << "nothing was under way";
}

TEST(CameraMapper, WhatTheKeyframeUnderWayThrowsIsSaidAndAnotherMapBegins) {
  const SyntheticStream stream;
  std::atomic<bool> faulty = true;
  CameraMapper mapper(ServerConfig{}, beside([&faulty] {
                        if (faulty) throw std::logic_error("a fault on purpose");
                      }));
  int next = 0;
  const MapUpdate before = map_until_beside(mapper, stream, next);
  ASSERT_TRUE(mapper.maps_beside());
  EXPECT_THROW(mapper.localize_only(true), std::runtime_error);
  EXPECT_FALSE(mapper.take_commanded());
  EXPECT_FALSE(mapper.maps_beside());
  EXPECT_EQ(mapper.statistics().keyframes, 0) << "of a map that was given up";
  EXPECT_EQ(mapper.take_frame(kFeatures, bytes(stream.frame(next))).result.reason,
            Reason::kNotRelocalized);

  faulty = false;
  mapper.localize_only(false);
  FrameResult last;
  for (int i = next + 1; i <= next + 25; ++i)
    last = mapper.take_frame(kFeatures, bytes(stream.frame(i))).result;
  EXPECT_EQ(last.state, TrackingState::kTracking);
  EXPECT_GT(last.map_id, before.map_id);
  mapper.adopt_keyframe(true);
  EXPECT_GT(mapper.statistics().keyframes, 2) << "the first two are of its start";
}

TEST(CameraMapper, AtTheEndAKeyframeThatFailsCostsItselfAndNotTheMap) {
  const SyntheticStream stream;
  CameraMapper mapper(ServerConfig{}, beside([] { throw std::logic_error("a fault on purpose"); }));
  int next = 0;
  map_until_beside(mapper, stream, next);
  ASSERT_TRUE(mapper.maps_beside());
  const std::int64_t keyframes = mapper.statistics().keyframes;
  ASSERT_GT(keyframes, 1);
  EXPECT_THROW(mapper.adopt_keyframe(true), std::runtime_error);
  EXPECT_EQ(mapper.statistics().keyframes, keyframes);
}

TEST(CameraMapper, ImagesTooSmallForFeaturesAreRefused) {
  ServerConfig config;
  config.calibration = synthetic_camera();
  config.calibration->width = 31;
  config.calibration->height = 40;
  config.calibration->cx = config.calibration->cy = 15;
  ASSERT_EQ(config.problem(), "");
  CameraMapper mapper(config);
  ImageMessage image;
  image.time_us = 1000;
  image.width = image.row_stride = 31;
  image.height = 40;
  image.data.assign(31 * 40, 100);
  const FrameResult result = mapper.take_frame(kImage, encode(to_message(image))).result;
  EXPECT_TRUE(result.rejected);
  EXPECT_EQ(result.reason, Reason::kBadImageSize);
  EXPECT_NE(result.detail.find("32x32"), std::string::npos) << result.detail;
}

TEST(CameraMapper, AGuessedCalibrationServesUntilARealOneComes) {
  ServerConfig config;
  config.hfov_deg = 60;
  CameraMapper mapper(config);
  const SyntheticStream stream;
  const auto anonymous = [&stream](int i) {
    FeatureFrame frame = stream.frame(i);
    frame.calibration_id = 0;
    return bytes(frame);
  };
  EXPECT_FALSE(mapper.take_frame(kFeatures, anonymous(0)).result.rejected);
  EXPECT_TRUE(mapper.calibration_is_guessed());
  EXPECT_FALSE(mapper.take_frame(kFeatures, anonymous(1)).result.rejected);
  FeatureFrame named = stream.frame(2);
  named.calibration_id = synthetic_camera().id();
  EXPECT_EQ(mapper.take_frame(kFeatures, bytes(named)).result.reason, Reason::kCalibrationMismatch)
      << "a frame that names a calibration is not to be mapped with a guess";
  EXPECT_EQ(mapper.take_calibration("cam0", calibration(synthetic_camera())).reason, Reason::kNone);
  const CameraMapper::Mapped changed = mapper.take_frame(kFeatures, anonymous(3));
  EXPECT_FALSE(changed.result.rejected) << changed.result.detail;
  EXPECT_NE(changed.new_calibration, "");
  EXPECT_FALSE(mapper.calibration_is_guessed());
  named = stream.frame(4);
  named.calibration_id = synthetic_camera().id();
  EXPECT_FALSE(mapper.take_frame(kFeatures, bytes(named)).result.rejected);
}

TEST(CameraMapper, ABadFrameIsNothingToGuessFrom) {
  ServerConfig config;
  config.hfov_deg = 60;
  CameraMapper mapper(config);
  const SyntheticStream stream;
  FeatureFrame bad = stream.frame(0);
  bad.calibration_id = 0;
  bad.camera = "other";  // on a channel of cam0
  bad.width = bad.height = 64;
  bad.keypoints.clear();
  bad.descriptors.clear();
  EXPECT_EQ(mapper.take_frame(kFeatures, bytes(bad)).result.reason, Reason::kMalformedMessage);
  FeatureFrame good = stream.frame(1);
  good.calibration_id = 0;
  const FrameResult result = mapper.take_frame(kFeatures, bytes(good)).result;
  EXPECT_FALSE(result.rejected) << result.detail;
  EXPECT_TRUE(mapper.calibration_is_guessed());
}

TEST(CameraMapper, ARealCalibrationBeforeTheFirstGoodFrameStays) {
  ServerConfig config;
  config.hfov_deg = 60;
  CameraMapper mapper(config);
  const SyntheticStream stream;
  ImageMessage broken;
  broken.time_us = 1;
  broken.width = 640, broken.height = 480;
  broken.format = PixelFormat::kMjpeg;
  broken.data.assign(1000, 0xff);
  EXPECT_EQ(mapper.take_frame(kImage, encode(to_message(broken))).result.reason,
            Reason::kCorruptImage);
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  for (int i = 0; i < 3; ++i) {
    FeatureFrame frame = stream.frame(i);
    frame.calibration_id = 0;
    ASSERT_FALSE(mapper.take_frame(kFeatures, bytes(frame)).result.rejected);
  }
  EXPECT_FALSE(mapper.calibration_is_guessed());
  FeatureFrame named = stream.frame(3);
  named.calibration_id = synthetic_camera().id();
  const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(named));
  EXPECT_FALSE(mapped.result.rejected) << mapped.result.detail;
  EXPECT_EQ(mapped.new_calibration, "") << "it is the one in use";
}

TEST(CameraMapper, NoGuessUnasked) {
  CameraMapper mapper{ServerConfig{}};
  FeatureFrame frame = SyntheticStream().frame(0);
  frame.calibration_id = 0;
  EXPECT_EQ(mapper.take_frame(kFeatures, bytes(frame)).result.reason, Reason::kNoCalibration);
}

TEST(CameraMapper, ARefusedFrameHasArrived) {
  const SyntheticStream stream;
  CameraMapper mapper{ServerConfig{}};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  mapper.take_frame(kFeatures, bytes(stream.frame(0)), stream.frame(0).time_us + 500);
  FeatureFrame bad = stream.frame(1);
  bad.calibration_id = changed_camera().id();
  EXPECT_TRUE(mapper.take_frame(kFeatures, bytes(bad)).result.rejected);
  mapper.take_frame(kFeatures, bytes(stream.frame(2)));
  mapper.take_frame(kFeatures, bytes(stream.frame(2)));
  EXPECT_EQ(mapper.streams().missing(), 0);
  EXPECT_EQ(mapper.streams().streams().front().duplicates, 1);
  EXPECT_EQ(mapper.streams().streams().front().clock_offset_us, 500);
}

TEST(CameraMapper, GapsAreWhatNeverArrived) {
  const SyntheticStream stream;
  CameraMapper mapper{ServerConfig{}};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  mapper.take_frame(kFeatures, bytes(stream.frame(0)));
  mapper.take_frame(kFeatures, bytes(stream.frame(1)));
  EXPECT_EQ(mapper.streams().missing(), 0);
  mapper.take_frame(kFeatures, bytes(stream.frame(4)));
  EXPECT_EQ(mapper.streams().missing(), 2);
  mapper.note_dropped(3);
  mapper.take_frame(kFeatures, bytes(stream.frame(8)));
  EXPECT_EQ(mapper.streams().missing(), 2) << "what the server dropped itself has arrived";
  FeatureFrame restarted = stream.frame(9);
  restarted.publisher = 8;
  restarted.seq = 1000;
  mapper.take_frame(kFeatures, bytes(restarted));
  EXPECT_EQ(mapper.streams().missing(), 2) << "another publisher counts by itself";
}

// Pictures of a textured wall before another, the camera moving sideways.
cv::Mat picture(int i) {
  static const cv::Mat texture = [] {
    cv::Mat noise(480, 1400, CV_8UC1);
    cv::RNG(3).fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, noise, {0, 0}, 3);
    cv::normalize(noise, noise, 0, 255, cv::NORM_MINMAX);
    return noise;
  }();
  cv::Mat image = texture.colRange(300 + 2 * i, 940 + 2 * i).clone();
  texture(cv::Rect(5 * i, 100, 640, 120)).copyTo(image.rowRange(100, 220));
  texture(cv::Rect(9 * i, 300, 640, 100)).copyTo(image.rowRange(300, 400));
  // ... and rolling.
  const cv::Mat turn = cv::getRotationMatrix2D({320, 240}, 2.0 * i, 1);
  cv::warpAffine(image, image, turn, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  return image;
}

// The extractor follows the camera's roll from image to image: not those of an image that is
// refused for its time.
TEST(CameraMapper, LateImagesLeaveNoTrace) {
  ServerConfig config = at_once();
  config.calibration = synthetic_camera();
  CameraMapper alone(config), disturbed(config);
  const auto image = [](int of, std::int64_t time_us) {
    const cv::Mat pixels = picture(of);
    ImageMessage gray;
    gray.time_us = time_us;
    gray.width = gray.row_stride = 640;
    gray.height = 480;
    gray.data.assign(pixels.datastart, pixels.dataend);
    return encode(to_message(gray));
  };
  for (int i = 0; i < 20; ++i) {
    const std::int64_t time_us = 1000 * (i + 1);
    const FrameResult a = alone.take_frame(kImage, image(i, time_us)).result;
    const FrameResult b = disturbed.take_frame(kImage, image(i, time_us)).result;
    expect_same(a, b);
    EXPECT_EQ(a.num_matches, b.num_matches);
    const FrameResult late = disturbed.take_frame(kImage, image(17 - i / 2, time_us - 500)).result;
    EXPECT_EQ(late.reason, Reason::kTimeNotIncreasing);
  }
}

// Refused, it must not cost the map either.
TEST(CameraMapper, AFrameOfAnotherCalibrationThatDoesNotFitItChangesNothing) {
  const SyntheticStream stream;
  const std::vector<FrameResult> expected = map_alone(25);
  CameraMapper mapper{at_once()};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  for (int i = 0; i < 25; ++i) {
    expect_same(mapper.take_frame(kFeatures, bytes(stream.frame(i))).result, expected[i]);
    mapper.take_calibration("cam0", calibration(changed_camera()));
    FeatureFrame other = stream.frame(i + 1);
    other.calibration_id = changed_camera().id();
    other.width += 10;
    const CameraMapper::Mapped mapped = mapper.take_frame(kFeatures, bytes(other));
    EXPECT_EQ(mapped.result.reason, Reason::kBadImageSize);
    EXPECT_EQ(mapped.new_calibration, "");
  }
  EXPECT_EQ(mapper.statistics().starts, 1);
}

// Another publisher is a new stream only if its frames are of use to the map.
TEST(CameraMapper, AnotherPublisherOfAnotherExtractorChangesNothing) {
  const SyntheticStream stream;
  const std::vector<FrameResult> expected = map_alone(30);
  CameraMapper mapper{at_once()};
  mapper.take_calibration("cam0", calibration(synthetic_camera()));
  for (int i = 0; i < 30; ++i) {
    expect_same(mapper.take_frame(kFeatures, bytes(stream.frame(i))).result, expected[i]);
    if (expected[i].state != TrackingState::kTracking) continue;
    FeatureFrame other = stream.frame(i + 1);
    other.publisher = 8;
    other.extractor = Extractor::kSift;
    EXPECT_EQ(mapper.take_frame(kFeatures, bytes(other)).result.reason, Reason::kUnknownExtractor);
  }
  EXPECT_EQ(mapper.statistics().losses, 0);
}

class EveryExtractor : public ::testing::TestWithParam<ExtractorKind> {};

TEST_P(EveryExtractor, ImagesAndTheirFeaturesGiveTheSame) {
  ServerConfig config = at_once();
  config.calibration = synthetic_camera();
  config.features.extractor = GetParam();
  CameraMapper of_gray(config), of_jpeg(config), of_features(config);
  FeatureExtractor extractor(config.features);
  const int images = GetParam() == ExtractorKind::kSift ? 6 : 20;  // it is slow
  for (int i = 0; i < images; ++i) {
    ImageMessage jpeg;
    jpeg.time_us = 1000 * (i + 1);
    jpeg.width = 640;
    jpeg.height = 480;
    jpeg.format = PixelFormat::kMjpeg;
    cv::imencode(".jpg", picture(i), jpeg.data);
    const cv::Mat pixels = cv::imdecode(jpeg.data, cv::IMREAD_GRAYSCALE);
    ImageMessage gray = jpeg;
    gray.format = PixelFormat::kGray;
    gray.row_stride = 640;
    gray.data.assign(pixels.datastart, pixels.dataend);
    const FeatureFrame features =
        extract_frame(extractor, pixels, synthetic_camera(), {jpeg.time_us, 0, -1, "cam0"});

    const FrameResult a = of_gray.take_frame(kImage, encode(to_message(gray))).result;
    const FrameResult b = of_jpeg.take_frame(kImage, encode(to_message(jpeg))).result;
    const FrameResult c = of_features.take_frame(kFeatures, bytes(features)).result;
    ASSERT_FALSE(a.rejected) << a.detail;
    EXPECT_EQ(a.detail, c.detail);
    EXPECT_EQ(a.num_matches, c.num_matches);
    expect_same(a, c);
    EXPECT_EQ(b.detail, c.detail);
    expect_same(b, c);
  }
}

INSTANTIATE_TEST_SUITE_P(CameraMapper, EveryExtractor,
                         ::testing::Values(ExtractorKind::kSurfUpright,
                                           ExtractorKind::kSurfOriented, ExtractorKind::kSift,
                                           ExtractorKind::kAuto));

}  // namespace
}  // namespace eifmap
