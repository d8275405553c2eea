#include "convert/measurement_message.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "wire/channel.h"
#include "wire/layout.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

constexpr std::size_t kMostValues = 3;

void scan(LayoutScanner& in) {
  in.skip(4 * 8);  // utime to seq
  in.string("camera", kMaxText);
  in.skip(2);  // kind
  in.array("value", in.count("n", kMostValues), 8);
  in.array("covariance", in.count("n2", kMostValues * kMostValues), 8);
  in.skip(3 * 8 + 3 * 8);  // lever_arm; map_id, landmark
}

struct KindOnWire {
  MeasurementKind kind;
  std::int16_t wire;
  int values, covariances;  // numbers of each
};
constexpr KindOnWire kKinds[] = {
    {MeasurementKind::kPosition, measurement_t::KIND_POSITION, 3, 9},
    {MeasurementKind::kDistance, measurement_t::KIND_DISTANCE, 1, 1},
    {MeasurementKind::kOdometry, measurement_t::KIND_ODOMETRY, 1, 1},
    {MeasurementKind::kGravity, measurement_t::KIND_GRAVITY, 3, 1},
    {MeasurementKind::kLandmarks, measurement_t::KIND_LANDMARKS, 1, 1},
};

std::int16_t wire_kind(MeasurementKind kind) {
  return std::find_if(std::begin(kKinds), std::end(kKinds),
                      [kind](const KindOnWire& k) { return k.kind == kind; })
      ->wire;
}

// Null when there is none such.
const KindOnWire* kind_of(const measurement_t& message) {
  const auto* found =
      std::find_if(std::begin(kKinds), std::end(kKinds),
                   [&message](const KindOnWire& k) { return k.wire == message.kind; });
  return found == std::end(kKinds) ? nullptr : found;
}

std::string shape_problem(const measurement_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (!valid_time(message.utime2)) return "utime2 is " + std::to_string(message.utime2);
  if (message.publisher == 0) return "publisher is 0: a measurement needs a name";
  if (message.seq < 0 || !valid_seq(message.seq)) return "seq is " + std::to_string(message.seq);
  const KindOnWire* kind = kind_of(message);
  if (!kind) return "kind is " + std::to_string(message.kind) + ", must be 1 to 5";
  if (message.n != kind->values || message.n2 != kind->covariances)
    return "n and n2 are " + std::to_string(message.n) + " and " + std::to_string(message.n2) +
           ", of this kind they must be " + std::to_string(kind->values) + " and " +
           std::to_string(kind->covariances);
  return "";
}

AbsoluteMeasurement read_numbers(const measurement_t& message) {
  AbsoluteMeasurement m;
  m.kind = kind_of(message)->kind;
  if (m.kind == MeasurementKind::kPosition) {
    m.position = Eigen::Vector3d::Map(message.value.data());
    m.lever = Eigen::Vector3d::Map(message.lever_arm);
    m.covariance = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(message.covariance.data());
    return m;
  }
  m.sigma = std::sqrt(message.covariance[0]);  // of a negative one NaN
  if (m.kind == MeasurementKind::kGravity) {
    m.down = Eigen::Vector3d::Map(message.value.data());
    return m;
  }
  m.length = message.value[0];
  if (has_two_times(m.kind)) m.until_us = message.utime2;
  if (m.kind == MeasurementKind::kLandmarks) {
    m.map_id = message.map_id;
    m.landmark = {message.landmark[0], message.landmark[1]};
  }
  return m;
}

std::string number_problem(Reason reason, const measurement_t& message) {
  if (reason == Reason::kBadMeasurementCovariance)
    return message.kind == measurement_t::KIND_GRAVITY
               ? "its covariance is not above 0 and at most 1 rad^2"
               : "its covariance is not finite, symmetric and positive definite";
  if (has_two_times(kind_of(message)->kind) && message.utime2 <= message.utime)
    return "utime2 is " + std::to_string(message.utime2) + ", not after utime";
  if (message.kind == measurement_t::KIND_LANDMARKS)
    return "its length is not above 0, or it names no map and two landmarks: map " +
           std::to_string(message.map_id) + ", landmarks " + std::to_string(message.landmark[0]) +
           " and " + std::to_string(message.landmark[1]);
  return "its numbers are not finite, or a length is not above 0";
}

}  // namespace

measurement_t to_message(const NamedMeasurement& named) {
  const AbsoluteMeasurement& m = named.measurement;
  measurement_t message;
  message.utime = m.time_us;
  message.publisher = m.id.publisher;
  message.seq = m.id.seq;
  message.camera = named.camera;
  message.kind = wire_kind(m.kind);
  std::fill_n(message.lever_arm, 3, 0.0);
  std::fill_n(message.landmark, 2, 0);
  message.map_id = message.utime2 = 0;
  if (m.kind == MeasurementKind::kPosition) {
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = m.covariance;
    message.value.assign(m.position.begin(), m.position.end());
    message.covariance.assign(rows.data(), rows.data() + rows.size());
    std::copy(m.lever.begin(), m.lever.end(), message.lever_arm);
  } else {
    message.covariance = {m.sigma * m.sigma};  // whose root is the sigma again, to the bit
    message.value = {m.length};
  }
  if (m.kind == MeasurementKind::kGravity) message.value.assign(m.down.begin(), m.down.end());
  if (has_two_times(m.kind)) message.utime2 = m.until_us;
  if (m.kind == MeasurementKind::kLandmarks) {
    message.map_id = m.map_id;
    std::copy(m.landmark.begin(), m.landmark.end(), message.landmark);
  }
  message.n = static_cast<std::int32_t>(message.value.size());
  message.n2 = static_cast<std::int32_t>(message.covariance.size());
  return message;
}

Decoded<NamedMeasurement> decode_measurement(Bytes bytes) {
  using Result = Decoded<NamedMeasurement>;
  const Decoded<measurement_t> decoded = decode_checked<measurement_t>(bytes, scan);
  if (!decoded.ok()) return Result::refuse(decoded.reason, decoded.detail);
  const measurement_t& message = decoded.value;
  if (std::string problem = shape_problem(message); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, problem);
  Result result;
  AbsoluteMeasurement& m = result.value.measurement;
  m = read_numbers(message);
  m.time_us = message.utime;
  m.id = {message.publisher, message.seq};
  result.value.camera = message.camera;
  if (const Reason reason = check_measurement(m); reason != Reason::kNone)
    return Result::refuse(reason, number_problem(reason, message));
  return result;
}

}  // namespace eifmap
