// Bytes that nobody honest sends: each is refused with a reason, or is a valid value, and no size
// field can make the decoder allocate more than the message's own bytes justify.
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <limits>
#include <new>
#include <random>

#include "messages/samples.h"
#include "wire/limits.h"

namespace {

std::size_t largest_allocation = 0;

void* counted(std::size_t size) {
  largest_allocation = std::max(largest_allocation, size);
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  return counted(size);
}
void* operator new[](std::size_t size) {
  return counted(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace eifmap {
namespace {

using Wire = std::vector<std::uint8_t>;

// True when the bytes were taken as a value; false when they were refused, with a reason and words.
using Decoder = std::function<bool(Bytes)>;

template <class Value>
Decoder decoder(Decoded<Value> (*decode)(Bytes)) {
  return [decode](Bytes bytes) {
    const Decoded<Value> decoded = decode(bytes);
    if (!decoded.ok()) {
      EXPECT_NE(decoded.detail, "");
    }
    return decoded.ok();
  };
}

struct Sample {
  const char* name;
  Wire bytes;
  Decoder decode;
};

std::vector<Sample> all_samples() {
  const map_part_t part = to_message(samples::map_update(2, 5, -1), {42, "cam0"}, 7);
  const map_request_t request = samples::map_request();
  return {
      {"camera", encode(to_message(samples::camera())), decoder(&decode_camera)},
      {"features", encode(to_message(samples::features(4))), decoder(&decode_features)},
      {"image", encode(to_message(samples::image())), decoder(&decode_image)},
      {"pose", encode(to_message(samples::published_pose())), decoder(&decode_pose)},
      {"decision", encode(to_message(samples::published_decision())), decoder(&decode_decision)},
      {"position", encode(to_message(samples::position())), decoder(&decode_measurement)},
      {"landmarks", encode(to_message(samples::landmarks())), decoder(&decode_measurement)},
      {"relative request", encode(to_message(samples::relative_request())),
       decoder(&decode_relative_request)},
      {"relative", encode(to_message(samples::relative_answer())), decoder(&decode_relative)},
      {"command", encode(samples::command()), decoder(&decode_command)},
      {"reply", encode(samples::reply()), decoder(&decode_reply)},
      {"map part", encode(part), decoder(&decode_map_part)},
      {"map request", encode(request), decoder(&decode_map_request)},
      {"said by pose", encode(to_message(samples::published_pose())), decoder(&said_by_pose)},
      {"said by status", encode(samples::status()), decoder(&said_by_status)},
      {"status", encode(samples::status()), decoder(&decode_status)}};
}

// Entries in memory are at most this many times larger than on the wire; plus the words of a
// detail.
void decode_within_bound(const Sample& sample, Bytes bytes) {
  largest_allocation = 0;
  sample.decode(bytes);
  EXPECT_LE(largest_allocation, 16 * bytes.size() + 1024) << sample.name;
}

void put_int32(Wire& bytes, std::size_t at, std::int32_t value) {
  for (int i = 0; i < 4; ++i)
    bytes[at + static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (24 - 8 * i));
}

TEST(Hostile, SamplesAreValid) {
  for (const Sample& sample : all_samples())
    EXPECT_TRUE(sample.decode(sample.bytes)) << sample.name;
}

TEST(Hostile, EveryTruncationIsRefused) {
  for (const Sample& sample : all_samples())
    for (std::size_t size = 0; size < sample.bytes.size(); ++size) {
      // A copy of just this size, so that a sanitizer sees a read past its end.
      const Wire cut(sample.bytes.begin(), sample.bytes.begin() + static_cast<long>(size));
      EXPECT_FALSE(sample.decode(cut)) << sample.name << " of " << size << " bytes";
    }
}

TEST(Hostile, BytesTooManyAreRefused) {
  for (Sample& sample : all_samples()) {
    sample.bytes.push_back(0);
    EXPECT_FALSE(sample.decode(sample.bytes)) << sample.name;
  }
}

TEST(Hostile, OtherTypesAreRefused) {
  constexpr long kFingerprint = 8;  // bytes
  for (const Sample& sample : all_samples())
    for (const Sample& other : all_samples())
      EXPECT_EQ(sample.decode(other.bytes),
                std::equal(sample.bytes.begin(), sample.bytes.begin() + kFingerprint,
                           other.bytes.begin()))
          << sample.name << " and " << other.name;
}

TEST(Hostile, AnySizeAnywhereAllocatesNoMoreThanTheBytesJustify) {
  const std::int32_t sizes[] = {-1,
                                std::numeric_limits<std::int32_t>::min(),
                                std::numeric_limits<std::int32_t>::max(),
                                1 << 20,
                                20000,
                                64};
  for (const Sample& sample : all_samples())
    for (std::size_t at = 0; at + 4 <= sample.bytes.size(); ++at)
      for (const std::int32_t size : sizes) {
        Wire bytes = sample.bytes;
        put_int32(bytes, at, size);
        decode_within_bound(sample, bytes);
      }
}

TEST(Hostile, EveryBitFlipIsRefusedOrValid) {
  for (const Sample& sample : all_samples())
    for (std::size_t at = 0; at < sample.bytes.size(); ++at)
      for (int bit = 0; bit < 8; ++bit) {
        Wire bytes = sample.bytes;
        bytes[at] ^= static_cast<std::uint8_t>(1 << bit);
        decode_within_bound(sample, bytes);
      }
}

TEST(Hostile, RandomDamageIsRefusedOrValid) {
  std::mt19937 random(5);
  for (const Sample& sample : all_samples())
    for (int trial = 0; trial < 2000; ++trial) {
      Wire bytes = sample.bytes;
      for (unsigned damage = 1 + random() % 8; damage > 0; --damage)
        bytes[8 + random() % (bytes.size() - 8)] = static_cast<std::uint8_t>(random());
      if (random() % 2 == 0) bytes.resize(random() % (bytes.size() + 1));
      decode_within_bound(sample, bytes);
    }
}

TEST(Hostile, ImageOf56BytesWithNegativeSize) {
  Wire bytes = encode(to_message(samples::image()));
  bytes.resize(56);
  put_int32(bytes, 8 + 8 + 16, -1);
  const Decoded<ImageMessage> decoded = decode_image(bytes);
  EXPECT_EQ(decoded.reason, Reason::kMalformedMessage);
  EXPECT_NE(decoded.detail.find("size is -1"), std::string::npos) << decoded.detail;
}

template <class Change>
Reason features_with(Change change) {
  feature_frame_t message = to_message(samples::features(4));
  change(message);
  return decode_features(encode(message)).reason;
}

TEST(Hostile, FeatureValues) {
  using F = feature_frame_t;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(features_with([](F&) {}), Reason::kNone);
  EXPECT_EQ(features_with([=](F& f) { f.u[3] = nan; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([=](F& f) { f.angle[0] = nan; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([=](F& f) { f.response[0] = nan; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.u[2] = 640; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.v[2] = -1; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.scale[1] = 0; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.sigma_px[1] = -1; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.laplacian_sign[1] = 0; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.laplacian_sign[1] = 2; }), Reason::kBadFeatures);
  EXPECT_EQ(features_with([](F& f) { f.extractor = 9; }), Reason::kUnknownExtractor);
  EXPECT_EQ(features_with([](F& f) { f.descriptor_size = 32; }), Reason::kMalformedMessage);
  EXPECT_EQ(features_with([](F& f) {
              f.camera =
                  "k\xc3\xbc"
                  "che";
            }),
            Reason::kMalformedMessage);
  EXPECT_EQ(features_with([](F& f) { f.width = -640; }), Reason::kMalformedMessage);
  EXPECT_EQ(features_with([](F& f) { f.utime = -1; }), Reason::kMalformedMessage);
  EXPECT_EQ(features_with([](F& f) {
              f.descriptors.pop_back();
              --f.descriptor_bytes;
            }),
            Reason::kMalformedMessage);
}

template <class Change>
Reason decision_with(Change change) {
  decision_t message = to_message(samples::published_decision());
  change(message);
  return decode_decision(encode(message)).reason;
}

TEST(Hostile, DecisionValues) {
  using D = decision_t;
  EXPECT_EQ(decision_with([](D&) {}), Reason::kNone);
  EXPECT_EQ(decision_with([](D& d) { d.adopted_job = kAdoptedAtOnce; }), Reason::kNone);
  EXPECT_EQ(decision_with([](D& d) { d.adopted_job = -2; }), Reason::kMalformedMessage);
  EXPECT_EQ(decision_with([](D& d) { d.utime = -1; }), Reason::kMalformedMessage);
  EXPECT_EQ(decision_with([](D& d) { d.camera = "../cam"; }), Reason::kMalformedMessage);
  EXPECT_EQ(decision_with([](D& d) { d.camera = ""; }), Reason::kMalformedMessage);
  EXPECT_EQ(decision_with([](D& d) { d.after_reset = 2; }), Reason::kMalformedMessage);
  EXPECT_EQ(decision_with([](D& d) { d.measurements[1].seq = -1; }), Reason::kMalformedMessage);
}

template <class Change>
Reason measurement_with(const NamedMeasurement& sample, Change change) {
  measurement_t message = to_message(sample);
  change(message);
  return decode_measurement(encode(message)).reason;
}

TEST(Hostile, MeasurementValues) {
  using M = measurement_t;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const auto expect_of = [](const NamedMeasurement& sample, Reason reason, auto change) {
    EXPECT_EQ(measurement_with(sample, change), reason);
  };
  for (const NamedMeasurement& any : samples::measurements()) {
    expect_of(any, Reason::kNone, [](M&) {});
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.utime = -1; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.utime2 = 1LL << 60; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.publisher = 0; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.seq = -1; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.seq = kMaxSeq + 1; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.camera = "../cam"; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.kind = 0; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.kind = 9; });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.value.resize(m.n = 2); });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.covariance.resize(m.n2 = 0); });
    expect_of(any, Reason::kMalformedMessage, [](M& m) { m.value.resize(m.n = 4); });
    expect_of(any, Reason::kBadMeasurement, [=](M& m) { m.value[0] = nan; });
    expect_of(any, Reason::kBadMeasurement, [=](M& m) { m.value[0] = inf; });
    expect_of(any, Reason::kBadMeasurement, [=](M& m) { m.value[0] = 1e300; });
    for (const double bad : {nan, inf, -1.0, 0.0, 1e300})
      expect_of(any, Reason::kBadMeasurementCovariance, [=](M& m) { m.covariance[0] = bad; });
  }
  const NamedMeasurement position = samples::position(), length = samples::length();
  expect_of(position, Reason::kBadMeasurement, [=](M& m) { m.lever_arm[2] = nan; });
  expect_of(position, Reason::kBadMeasurementCovariance, [](M& m) { m.covariance[1] = 0.2; });
  expect_of(position, Reason::kBadMeasurementCovariance,
            [](M& m) { m.covariance[1] = m.covariance[3] = 5; });  // symmetric and indefinite
  expect_of(length, Reason::kBadMeasurement, [](M& m) { m.utime2 = m.utime; });
  expect_of(length, Reason::kBadMeasurement, [](M& m) { m.value[0] = 0; });
  expect_of(length, Reason::kMalformedMessage, [](M& m) { m.kind = measurement_t::KIND_POSITION; });
  const NamedMeasurement gravity = samples::gravity(), landmarks = samples::landmarks();
  expect_of(gravity, Reason::kBadMeasurement, [](M& m) { m.value = {0, 0, 0}; });
  expect_of(gravity, Reason::kBadMeasurement, [=](M& m) { m.value[2] = nan; });
  expect_of(gravity, Reason::kBadMeasurementCovariance, [](M& m) { m.covariance[0] = 1.1; });
  expect_of(landmarks, Reason::kBadMeasurement, [](M& m) { m.map_id = 0; });
  expect_of(landmarks, Reason::kBadMeasurement, [](M& m) { m.landmark[1] = -1; });
  expect_of(landmarks, Reason::kBadMeasurement, [](M& m) { m.landmark[0] = m.landmark[1]; });
  expect_of(landmarks, Reason::kBadMeasurement, [](M& m) { m.value[0] = -1; });
}

TEST(Hostile, RelativeValues) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto request = [](bool valid, auto change) {
    relative_request_t message = to_message(samples::relative_request());
    change(message);
    EXPECT_EQ(decode_relative_request(encode(message)).ok(), valid);
  };
  const auto answer = [](bool valid, auto change) {
    relative_t message = to_message(samples::relative_answer());
    change(message);
    EXPECT_EQ(decode_relative(encode(message)).ok(), valid);
  };
  request(true, [](relative_request_t&) {});
  request(false, [](relative_request_t& m) { m.requester = 0; });
  request(false, [](relative_request_t& m) { m.camera = "a.b"; });
  request(false, [](relative_request_t& m) { m.utime = -1; });
  answer(true, [](relative_t&) {});
  answer(false, [](relative_t& m) { m.requester = 0; });
  answer(false, [=](relative_t& m) { m.covariance[35] = nan; });
  answer(false, [](relative_t& m) { m.quaternion[0] = 2; });
  // Without an answer nobody looks at what is none.
  answer(true, [=](relative_t& m) { m.reason = 110, m.covariance[35] = nan; });
}

TEST(Hostile, CommandValues) {
  const auto expect = [](bool valid, auto change) {
    command_t message = samples::command();
    change(message);
    EXPECT_EQ(decode_command(encode(message)).ok(), valid);
  };
  using C = command_t;
  expect(true, [](C&) {});
  expect(true, [](C& m) { m.command = 999; });  // the server says that it does not know it
  expect(true, [](C& m) { m.mac.clear(), m.mac_size = 0; });
  expect(false, [](C& m) { m.mac.resize(m.mac_size = 31); });
  expect(false, [](C& m) { m.mac.resize(m.mac_size = 33); });
  expect(false, [](C& m) { m.sender = 0; });
  expect(false, [](C& m) { m.request_id = 0; });
  expect(false, [](C& m) { m.request_id = std::numeric_limits<std::int64_t>::min(); });
  expect(false, [](C& m) { m.server_epoch = -1; });
  expect(false, [](C& m) { m.ticket = -1; });
  expect(false, [](C& m) { m.utime = -1; });
  expect(false, [](C& m) { m.camera = "../cam"; });
  expect(false, [](C& m) { m.args[1].key = m.args[0].key; });
  expect(false, [](C& m) { m.args[1].value = std::string(kMaxArgument + 1, 'x'); });
  expect(false, [](C& m) {
    for (int i = 0; i < 20; ++i) m.args.push_back(samples::named(std::to_string(i), ""));
    m.num_args = static_cast<std::int32_t>(m.args.size());
  });
}

TEST(Hostile, ReplyValues) {
  const auto expect = [](bool valid, auto change) {
    reply_t message = samples::reply();
    change(message);
    EXPECT_EQ(decode_reply(encode(message)).ok(), valid);
  };
  using R = reply_t;
  expect(true, [](R&) {});
  expect(true, [](R& m) { m.mac.resize(m.mac_size = 32); });
  expect(false, [](R& m) { m.mac.resize(m.mac_size = 16); });
  expect(false, [](R& m) { m.result = 6; });
  expect(false, [](R& m) { m.result = -1; });
  expect(false, [](R& m) { m.sender = 0; });
  expect(false, [](R& m) { m.camera = ""; });
  expect(false, [](R& m) { m.message = std::string(kMaxText + 1, 'x'); });
}

TEST(Hostile, EarthValues) {
  const auto expect = [](bool valid, auto change) {
    status_t status = samples::status();
    change(status);
    EXPECT_EQ(decode_status(encode(status)).ok(), valid);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  expect(true, [](status_t&) {});
  expect(true, [=](status_t& s) { s.earth_covariance[0] = nan; });  // unknown
  expect(true, [=](status_t& s) { s.earth = 0, s.earth_position[0] = nan; });
  expect(false, [](status_t& s) { s.earth = 3; });
  expect(false, [](status_t& s) { s.earth = -1; });
  expect(false, [=](status_t& s) { s.earth_position[0] = nan; });
  expect(false, [](status_t& s) { s.earth_quaternion[0] = 0.1; });
}

// Of a pose and of a status.
TEST(Hostile, ScaleValues) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect = [](bool valid, std::int8_t scale, double metres, double sigma) {
    pose_t pose = to_message(samples::published_pose());
    status_t status = samples::status();
    pose.scale = status.scale = scale;
    pose.metres_per_unit = status.metres_per_unit = metres;
    pose.sigma_log_scale = status.sigma_log_scale = sigma;
    EXPECT_EQ(decode_pose(encode(pose)).ok(), valid);
    EXPECT_EQ(decode_status(encode(status)).ok(), valid);
  };
  expect(true, 0, 1, nan);
  expect(true, 1, 30, 0.01);
  expect(false, 2, 1, 0.01);
  expect(false, -1, 1, 0.01);
  expect(false, 1, 0, 0.01);
  expect(false, 1, nan, 0.01);
  expect(false, 1, 1, -0.01);
}

template <class Change>
Reason camera_with(Change change) {
  camera_t message = to_message(samples::camera());
  message.calibration_id = 0;
  change(message);
  return decode_camera(encode(message)).reason;
}

TEST(Hostile, CalibrationValues) {
  EXPECT_EQ(camera_with([](camera_t&) {}), Reason::kNone);
  EXPECT_EQ(camera_with([](camera_t& c) { c.calibration_id = 5; }), Reason::kBadCalibration);
  EXPECT_EQ(camera_with([](camera_t& c) { c.model = 3; }), Reason::kBadCalibration);
  EXPECT_EQ(camera_with([](camera_t& c) { c.width = 1 << 30; }), Reason::kBadCalibration);
  EXPECT_EQ(camera_with([](camera_t& c) { c.cx = std::numeric_limits<double>::infinity(); }),
            Reason::kBadCalibration);
  EXPECT_EQ(camera_with([](camera_t& c) { c.camera = ""; }), Reason::kMalformedMessage);
  EXPECT_EQ(camera_with([](camera_t& c) {
              c.distortion.push_back(0);
              c.num_distortion = 6;
            }),
            Reason::kMalformedMessage);
}

template <class Change>
Reason image_with(Change change) {
  bot_core::image_t message = to_message(samples::image());
  change(message);
  return decode_image(encode(message)).reason;
}

TEST(Hostile, ImageValues) {
  using I = bot_core::image_t;
  EXPECT_EQ(image_with([](I&) {}), Reason::kNone);
  EXPECT_EQ(image_with([](I& i) { i.row_stride = -24; }), Reason::kBadImageSize);
  EXPECT_EQ(image_with([](I& i) { i.row_stride = 19; }), Reason::kBadImageSize);
  EXPECT_EQ(image_with([](I& i) { i.height = 11; }), Reason::kBadImageSize);
  EXPECT_EQ(image_with([](I& i) { i.width = std::numeric_limits<std::int32_t>::max(); }),
            Reason::kBadImageSize);
  EXPECT_EQ(image_with([](I& i) { i.pixelformat = 12345; }), Reason::kBadPixelFormat);
  // Twice the bytes of GRAY.
  EXPECT_EQ(image_with([](I& i) { i.pixelformat = I::PIXEL_FORMAT_YUYV; }), Reason::kBadImageSize);
  EXPECT_EQ(image_with([](I& i) { i.metadata[0].value[0] = 'x'; }), Reason::kMalformedMessage);
  // seq, as wild as it can be
  EXPECT_EQ(image_with([](I& i) {
              const std::string_view text = "9223372036854775807";
              i.metadata[0].value.assign(text.begin(), text.end());
              i.metadata[0].n = static_cast<std::int32_t>(text.size());
            }),
            Reason::kMalformedMessage);
}

}  // namespace
}  // namespace eifmap
