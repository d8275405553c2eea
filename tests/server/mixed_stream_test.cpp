// A good stream with every kind of bad input in between, in any order: what is mapped and published
// is what the good stream alone gives, to the bit.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <utility>

#include "convert/camera_message.h"
#include "convert/feature_message.h"
#include "convert/image_message.h"
#include "convert/map_message.h"
#include "convert/measurement_message.h"
#include "convert/relative_message.h"
#include "decision.h"
#include "published/published_map.h"
#include "server/camera_mapper.h"
#include "support/feature_world.h"
#include "support/random.h"

namespace eifmap {
namespace {

constexpr int kFrames = 45;
constexpr int kMostInARow = 5;  // of those that are late: Mapper::kPatience is believed

using Wire = std::vector<std::uint8_t>;

template <class Value>
Wire wire(const Value& value) {
  return encode(to_message(value));
}

Camera other_camera() {
  Camera camera = synthetic_camera();
  camera.fx *= 1.02;
  return camera;
}

// What a mapper is offered, and what became of what is good.
class Stream {
 public:
  Stream() {
    ServerConfig config;
    config.handover_frames = 2;  // beside, and by count, so that timing decides nothing
    mapper_.emplace(config);
    mapper_->take_calibration("cam0", wire(NamedCamera{1, "cam0", synthetic_camera()}));
  }

  void map(const FeatureFrame& frame) {
    const CameraMapper::Mapped mapped =
        mapper_->take_frame({"cam0", ChannelKind::kFeatures}, wire(frame));
    ASSERT_FALSE(mapped.result.rejected) << mapped.result.detail;
    publish(mapped.update);
    digests_.push_back(decision_of(mapped.result).state_digest);
    maps_.push_back(map_.digest());
    tracking_ = mapped.result.state == TrackingState::kTracking;
  }
  void finish() {
    publish(mapper_->adopt_keyframe(true));
    maps_.push_back(map_.digest());
  }

  Reason offer(ChannelKind kind, const Wire& bytes) {
    switch (kind) {
      case ChannelKind::kCalibration:
        return mapper_->take_calibration("cam0", bytes).reason;
      case ChannelKind::kMeasurement:
        return mapper_->take_measurement("cam0", bytes).reason;
      default: {
        const CameraMapper::Mapped mapped = mapper_->take_frame({"cam0", kind}, bytes);
        EXPECT_TRUE(mapped.result.rejected);
        EXPECT_FALSE(mapped.update);
        EXPECT_FALSE(mapped.result.detail.empty());
        return mapped.result.reason;
      }
    }
  }

  const CameraMapper& mapper() const { return *mapper_; }
  bool tracking() const { return tracking_; }
  const std::vector<std::int64_t>& digests() const { return digests_; }
  const std::vector<std::int64_t>& maps() const { return maps_; }  // of the published map

 private:
  void publish(const std::optional<MapUpdate>& update) {
    if (update) map_.apply(to_message(*update, {42, "cam0"}, 1));
  }

  std::optional<CameraMapper> mapper_;
  PublishedMap map_;
  bool tracking_ = false;
  std::vector<std::int64_t> digests_, maps_;
};

// From the good frame just mapped and the one that comes next. `expected`: kNone is not checked.
struct Bad {
  const char* name;
  std::function<void(Stream& stream, const FeatureFrame& last, FeatureFrame next, test::Random&)>
      offer;
};

Bad frame(const char* name, Reason expected, std::function<void(FeatureFrame&)> damage) {
  return {name, [=](Stream& stream, const auto&, FeatureFrame next, test::Random&) {
            damage(next);
            EXPECT_EQ(stream.offer(ChannelKind::kFeatures, wire(next)), expected);
          }};
}

Bad image(const char* name, Reason expected, std::function<void(ImageMessage&)> damage) {
  return {name, [=](Stream& stream, const auto&, const FeatureFrame& next, test::Random&) {
            ImageMessage image;
            image.time_us = next.time_us;
            image.publisher = next.publisher;
            image.width = image.row_stride = next.width;
            image.height = next.height;
            image.data.assign(static_cast<std::size_t>(next.width * next.height), 90);
            damage(image);
            EXPECT_EQ(stream.offer(ChannelKind::kImage, wire(image)), expected);
          }};
}

Bad measurement(const char* name, Reason expected, std::function<void(NamedMeasurement&)> damage) {
  return {name, [=](Stream& stream, const FeatureFrame& last, const auto&, test::Random&) {
            NamedMeasurement named{"cam0", {}};
            named.measurement.id = {8, last.seq};
            named.measurement.time_us = last.time_us;
            damage(named);
            EXPECT_EQ(stream.offer(ChannelKind::kMeasurement, wire(named)), expected);
          }};
}

// On any channel: cut somewhere, or with a byte changed among those that say what it is.
void offer_damaged(Stream& stream, const auto&, FeatureFrame next, test::Random& random) {
  const ChannelKind kinds[] = {ChannelKind::kFeatures, ChannelKind::kImage,
                               ChannelKind::kCalibration, ChannelKind::kMeasurement};
  const ChannelKind kind = kinds[random.bits() % std::size(kinds)];
  Wire bytes = wire(next);
  if (random.bits() % 2 == 0)
    bytes.resize(random.bits() % bytes.size());
  else
    bytes[random.bits() % 8] ^= 0x55;
  EXPECT_EQ(stream.offer(kind, bytes), Reason::kMalformedMessage);
}

const float kNan = std::numeric_limits<float>::quiet_NaN();

std::vector<Bad> all_bad() {
  return {
      {"Damaged", &offer_damaged<FeatureFrame>},
      {"Again",
       [](Stream& stream, const FeatureFrame& last, const auto&, test::Random&) {
         EXPECT_EQ(stream.offer(ChannelKind::kFeatures, wire(last)), Reason::kTimeNotIncreasing);
       }},
      {"Late",
       [](Stream& stream, FeatureFrame last, const auto&, test::Random& random) {
         last.time_us -= static_cast<std::int64_t>(random.bits() % 400'000);
         EXPECT_EQ(stream.offer(ChannelKind::kFeatures, wire(last)), Reason::kTimeNotIncreasing);
       }},
      frame("NotFinite", Reason::kBadFeatures, [](auto& f) { f.keypoints[3].v = kNan; }),
      frame("Outside", Reason::kBadFeatures, [](auto& f) { f.keypoints[3].u = 1e6f; }),
      frame("OtherVersion", Reason::kUnknownExtractor, [](auto& f) { ++f.extractor_version; }),
      frame("OtherCamera", Reason::kMalformedMessage, [](auto& f) { f.camera = "cam1"; }),
      frame("OtherSize", Reason::kBadImageSize, [](auto& f) { f.width += 8; }),
      frame("UnknownCalibration", Reason::kCalibrationMismatch,
            [](auto& f) { f.calibration_id = 7; }),
      {"AnotherPublishersExtractor",
       [](Stream& stream, const auto&, FeatureFrame next, test::Random&) {
         if (!stream.tracking()) return;  // else it would begin a stream
         next.publisher += 1;
         next.extractor = Extractor::kSift;
         EXPECT_EQ(stream.offer(ChannelKind::kFeatures, wire(next)), Reason::kUnknownExtractor);
       }},
      {"CalibrationWithoutFrames",
       [](Stream& stream, const auto&, FeatureFrame next, test::Random&) {
         EXPECT_EQ(
             stream.offer(ChannelKind::kCalibration, wire(NamedCamera{1, "cam0", other_camera()})),
             Reason::kNone);
         next.calibration_id = other_camera().id();
         next.height += 8;
         EXPECT_EQ(stream.offer(ChannelKind::kFeatures, wire(next)), Reason::kBadImageSize);
       }},
      {"CalibrationOfNumbersThatAreNone",
       [](Stream& stream, const auto&, const auto&, test::Random&) {
         camera_t message = to_message(NamedCamera{1, "cam0", synthetic_camera()});
         message.fy = std::numeric_limits<double>::infinity();
         EXPECT_EQ(stream.offer(ChannelKind::kCalibration, encode(message)),
                   Reason::kBadCalibration);
       }},
      image("SizeOfAnImage", Reason::kBadImageSize,
            [](ImageMessage& i) { i.width = 320, i.height = 240; }),
      image("CorruptJpeg", Reason::kCorruptImage,
            [](ImageMessage& i) {
              i.format = PixelFormat::kMjpeg;
              cv::imencode(".jpg", cv::Mat(i.height, i.width, CV_8UC1, cv::Scalar(90)), i.data);
              i.data.resize(i.data.size() / 2);
            }),
      {"PixelFormat",
       [](Stream& stream, const auto&, const FeatureFrame& next, test::Random&) {
         ImageMessage image;
         image.time_us = next.time_us;
         image.width = image.row_stride = next.width;
         image.height = next.height;
         image.data.assign(static_cast<std::size_t>(next.width * next.height), 90);
         bot_core::image_t message = to_message(image);
         message.pixelformat = 4711;
         EXPECT_EQ(stream.offer(ChannelKind::kImage, encode(message)), Reason::kBadPixelFormat);
       }},
      measurement("MeasurementOfNoNumber", Reason::kBadMeasurement,
                  [](auto& m) { m.measurement.position.x() = kNan; }),
      measurement("MeasurementWithoutSigma", Reason::kBadMeasurementCovariance,
                  [](auto& m) { m.measurement.covariance.setZero(); }),
      measurement("MeasurementOfAnotherCamera", Reason::kMalformedMessage,
                  [](auto& m) { m.camera = "cam1"; }),
      {"RequestOfWhatIsNotThere",
       [](Stream& stream, const auto&, const auto&, test::Random&) {
         const RelativeRequest request{1, 9, 1, "cam0", 1, 100'000, 3};
         EXPECT_EQ(stream.mapper().answer(request).reason, Reason::kKeyframeUnknown);
       }},
  };
}

class MixedStream : public testing::TestWithParam<unsigned> {};

TEST_P(MixedStream, IsTheGoodOneToTheBit) {
  const SyntheticStream good;
  Stream alone;
  for (int i = 0; i < kFrames; ++i) alone.map(good.frame(i));
  alone.finish();
  ASSERT_GT(alone.mapper().statistics().keyframes, 6) << "else this shows little";
  ASSERT_NE(alone.maps().back(), 0);

  Stream mixed;
  const std::vector<Bad> bad = all_bad();
  test::Random random(GetParam());
  std::set<std::string> offered;
  for (int i = 0; i < kFrames; ++i) {
    mixed.map(good.frame(i));
    ASSERT_EQ(mixed.digests().back(), alone.digests()[static_cast<std::size_t>(i)]) << i;
    for (std::uint64_t n = random.bits() % (kMostInARow + 1); n > 0; --n) {
      const Bad& next = bad[random.bits() % bad.size()];
      SCOPED_TRACE(next.name);
      next.offer(mixed, good.frame(i), good.frame(i + 1), random);
      offered.insert(next.name);
    }
  }
  mixed.finish();
  EXPECT_EQ(mixed.digests(), alone.digests());
  EXPECT_EQ(mixed.maps(), alone.maps());
  EXPECT_EQ(mixed.mapper().statistics().starts, 1);
  EXPECT_EQ(mixed.mapper().statistics().losses, alone.mapper().statistics().losses);
  EXPECT_GT(offered.size(), bad.size() * 3 / 4) << "else this shows little";
}

// A driver that hangs, and gives the same picture again with new times.
TEST(FrozenStream, IsACameraThatStands) {
  const SyntheticStream good;
  Stream stream;
  for (int i = 0; i < kFrames; ++i) stream.map(good.frame(i));
  stream.finish();
  const MapperStatistics before = stream.mapper().statistics();
  for (int i = kFrames; i < kFrames + 60; ++i) {
    FeatureFrame frozen = good.frame(kFrames - 1);
    frozen.time_us = good.frame(i).time_us;
    frozen.seq = i;
    stream.map(frozen);
    ASSERT_TRUE(stream.tracking());
  }
  stream.finish();
  const MapperStatistics& after = stream.mapper().statistics();
  EXPECT_LE(after.keyframes, before.keyframes + 1);
  EXPECT_EQ(after.starts, 1);
  EXPECT_EQ(after.losses, before.losses);
}

INSTANTIATE_TEST_SUITE_P(Seeds, MixedStream, testing::Range(1u, 9u));

}  // namespace
}  // namespace eifmap
