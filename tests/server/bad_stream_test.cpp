// Every kind of bad input among the frames of a good stream: refused with its reason, and what is
// mapped is what the good frames alone give, byte for byte.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <ostream>

#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/image_message.h"
#include "server/camera_mapper.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

// Each keyframe at once: timing decides nothing, and two runs can be compared to the bit.
ServerConfig at_once() {
  ServerConfig config;
  config.handover_frames = 0;
  return config;
}

constexpr int kFrames = 25;

using Wire = std::vector<std::uint8_t>;

Wire wire(const FeatureFrame& frame) {
  return encode(to_message(frame));
}

struct BadInput {
  const char* name;
  Reason reason;
  ChannelKind kind;
  // From the good frame just mapped, and the one that comes next.
  std::function<Wire(const FeatureFrame& last, const FeatureFrame& next)> make;
};

void PrintTo(const BadInput& input, std::ostream* out) {
  *out << input.name;
}

BadInput frame(const char* name, Reason reason, std::function<void(FeatureFrame&)> damage) {
  return {name, reason, ChannelKind::kFeatures, [damage](const auto&, FeatureFrame next) {
            damage(next);
            return wire(next);
          }};
}

using DamageImage = std::function<void(ImageMessage&)>;
using DamageMessage = std::function<void(bot_core::image_t&)>;

BadInput image(
    const char* name, Reason reason, DamageImage damage,
    DamageMessage damage_message = [](auto&) {}) {
  return {name, reason, ChannelKind::kImage,
          [damage, damage_message](const auto&, const FeatureFrame& next) {
            ImageMessage image;
            image.time_us = next.time_us;
            image.width = image.row_stride = next.width;
            image.height = next.height;
            image.data.assign(static_cast<std::size_t>(image.width * image.height), 128);
            damage(image);
            bot_core::image_t message = to_message(image);
            damage_message(message);
            return encode(message);
          }};
}

BadInput image_message(const char* name, Reason reason, DamageMessage damage) {
  return image(
      name, reason, [](auto&) {}, std::move(damage));
}

void make_jpeg(ImageMessage& image, int width, int height) {
  image.format = PixelFormat::kMjpeg;
  image.row_stride = 0;
  cv::imencode(".jpg", cv::Mat(height, width, CV_8UC1, cv::Scalar(128)), image.data);
}

template <class Value>
std::function<void(FeatureFrame&)> set_u(Value value) {
  return [value](FeatureFrame& frame) { frame.keypoints[5].u = static_cast<float>(value); };
}

const BadInput kInputs[] = {
    {"RepeatedTime", Reason::kTimeNotIncreasing, ChannelKind::kFeatures,
     [](const FeatureFrame& last, const auto&) { return wire(last); }},
    {"BackwardTime", Reason::kTimeNotIncreasing, ChannelKind::kFeatures,
     [](FeatureFrame last, const auto&) {
       last.time_us -= 500'000;
       return wire(last);
     }},
    frame("TimeBeforeTheEpoch", Reason::kMalformedMessage, [](auto& f) { f.time_us = -1; }),
    frame("PlaceNotANumber", Reason::kBadFeatures, set_u(std::numeric_limits<double>::quiet_NaN())),
    frame("PlaceInfinite", Reason::kBadFeatures, set_u(std::numeric_limits<double>::infinity())),
    frame("PlaceOutsideTheImage", Reason::kBadFeatures, set_u(-40.0)),
    frame("NoSign", Reason::kBadFeatures, [](auto& f) { f.keypoints[5].laplacian_sign = 0; }),
    frame("NoSigma", Reason::kBadFeatures, [](auto& f) { f.keypoints[5].sigma_px = 0; }),
    frame("UnknownExtractor", Reason::kUnknownExtractor,
          [](auto& f) { f.extractor = static_cast<Extractor>(9); }),
    frame("AnotherExtractor", Reason::kUnknownExtractor,
          [](auto& f) { f.extractor = Extractor::kSift; }),
    frame("AnotherVersion", Reason::kUnknownExtractor, [](auto& f) { ++f.extractor_version; }),
    frame("AnotherSize", Reason::kBadImageSize, [](auto& f) { f.width = 1280, f.height = 960; }),
    frame("UnknownCalibration", Reason::kCalibrationMismatch,
          [](auto& f) { f.calibration_id = 7; }),
    frame("AnotherCamera", Reason::kMalformedMessage, [](auto& f) { f.camera = "cam1"; }),
    {"CutOff", Reason::kMalformedMessage, ChannelKind::kFeatures,
     [](const auto&, const FeatureFrame& next) {
       Wire bytes = wire(next);
       bytes.resize(bytes.size() / 2);
       return bytes;
     }},
    {"Garbage", Reason::kMalformedMessage, ChannelKind::kFeatures,
     [](const auto&, const auto&) { return Wire(5000, 0xa5); }},
    {"Empty", Reason::kMalformedMessage, ChannelKind::kImage,
     [](const auto&, const auto&) { return Wire(); }},
    image("ImageOfAnotherSize", Reason::kBadImageSize,
          [](ImageMessage& i) { i.width = 320, i.height = 240; }),
    image("JpegOfAnotherSize", Reason::kBadImageSize,
          [](ImageMessage& i) { make_jpeg(i, 320, 240); }),
    image("JpegCutOff", Reason::kCorruptImage,
          [](ImageMessage& i) {
            make_jpeg(i, i.width, i.height);
            i.data.resize(i.data.size() / 2);
          }),
    image("NoJpegAtAll", Reason::kCorruptImage,
          [](ImageMessage& i) {
            i.format = PixelFormat::kMjpeg;
            i.data.assign(4000, 0xff);
          }),
    image("FewerBytesThanPixels", Reason::kBadImageSize,
          [](ImageMessage& i) { i.data.pop_back(); }),
    image_message("UnknownPixelFormat", Reason::kBadPixelFormat,
                  [](bot_core::image_t& message) { message.pixelformat = 4711; }),
    image_message("SequenceNumberNoNumber", Reason::kMalformedMessage,
                  [](bot_core::image_t& message) {
                    message.metadata.at(0).value = {'x'};
                    message.metadata.at(0).n = 1;
                  }),
};

class BadStream : public testing::TestWithParam<BadInput> {
 protected:
  void SetUp() override {
    mapper_.take_calibration("cam0",
                             encode(to_message(NamedCamera{1, "cam0", synthetic_camera()})));
  }

  // Trajectories, keyframes and points; the report has times in it.
  static std::string results_of(const CameraMapper& mapper, const std::string& name) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) /
                                         ("bad_stream_" + name + "_" + std::to_string(getpid()));
    EXPECT_EQ(mapper.write_results(folder), "");
    std::string all;
    for (const char* file :
         {"trajectory.tum", "trajectory_final.tum", "keyframes.tum", "map.ply"}) {
      std::ifstream in(folder / file, std::ios::binary);
      all.append(std::istreambuf_iterator<char>(in), {});
    }
    std::filesystem::remove_all(folder);
    return all;
  }

  static const std::string& results_of_the_good() {
    static const std::string results = [] {
      CameraMapper mapper{at_once()};
      mapper.take_calibration("cam0",
                              encode(to_message(NamedCamera{1, "cam0", synthetic_camera()})));
      const SyntheticStream stream;
      for (int i = 0; i < kFrames; ++i)
        mapper.take_frame({"cam0", ChannelKind::kFeatures}, wire(stream.frame(i)));
      return results_of(mapper, "good");
    }();
    return results;
  }

  CameraMapper mapper_{at_once()};
};

TEST_P(BadStream, CostsNothingThatIsMapped) {
  const SyntheticStream stream;
  const Channel channel{"cam0", GetParam().kind};
  for (int i = 0; i < kFrames; ++i) {
    const FeatureFrame good = stream.frame(i);
    ASSERT_FALSE(mapper_.take_frame({"cam0", ChannelKind::kFeatures}, wire(good)).result.rejected);
    const CameraMapper::Mapped bad =
        mapper_.take_frame(channel, GetParam().make(good, stream.frame(i + 1)));
    ASSERT_TRUE(bad.result.rejected);
    ASSERT_EQ(bad.result.reason, GetParam().reason) << bad.result.detail;
    ASSERT_FALSE(bad.result.detail.empty());
    ASSERT_FALSE(bad.update);
  }
  EXPECT_GT(mapper_.statistics().keyframes, 3) << "else this test shows little";
  EXPECT_EQ(results_of(mapper_, GetParam().name), results_of_the_good());
}

INSTANTIATE_TEST_SUITE_P(Inputs, BadStream, testing::ValuesIn(kInputs),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace eifmap
