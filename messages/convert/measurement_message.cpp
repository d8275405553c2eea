#include "convert/measurement_message.h"

#include <algorithm>
#include <cmath>

#include "convert/channel.h"
#include "convert/layout.h"
#include "convert/limits.h"

namespace eifmap {
namespace {

constexpr std::size_t kMostValues = 3;

void scan(LayoutScanner& in) {
  in.skip(4 * 8);  // utime to seq
  in.string("camera", kMaxText);
  in.skip(2);  // kind
  in.array("value", in.count("n", kMostValues), 8);
  in.array("covariance", in.count("n2", kMostValues * kMostValues), 8);
  in.skip(3 * 8);  // lever_arm
}

std::int16_t wire_kind(MeasurementKind kind) {
  switch (kind) {
    case MeasurementKind::kPosition:
      return measurement_t::KIND_POSITION;
    case MeasurementKind::kDistance:
      return measurement_t::KIND_DISTANCE;
    case MeasurementKind::kOdometry:
      break;
  }
  return measurement_t::KIND_ODOMETRY;
}

bool is_position(const measurement_t& message) {
  return message.kind == measurement_t::KIND_POSITION;
}

std::string shape_problem(const measurement_t& message) {
  if (!valid_camera_name(message.camera)) return "the camera's name is not 1 to 24 of A-Za-z0-9_-";
  if (!valid_time(message.utime)) return "utime is " + std::to_string(message.utime);
  if (!valid_time(message.utime2)) return "utime2 is " + std::to_string(message.utime2);
  if (message.publisher == 0) return "publisher is 0: a measurement needs a name";
  if (message.seq < 0 || !valid_seq(message.seq)) return "seq is " + std::to_string(message.seq);
  if (message.kind < measurement_t::KIND_POSITION || message.kind > measurement_t::KIND_ODOMETRY)
    return "kind is " + std::to_string(message.kind) + ", must be 1, 2 or 3";
  const int n = is_position(message) ? 3 : 1;
  if (message.n != n || message.n2 != n * n)
    return "n and n2 are " + std::to_string(message.n) + " and " + std::to_string(message.n2) +
           ", of this kind they must be " + std::to_string(n) + " and " + std::to_string(n * n);
  return "";
}

AbsoluteMeasurement read_position(const measurement_t& message) {
  AbsoluteMeasurement m;
  for (int i = 0; i < 3; ++i) {
    m.position[i] = message.value[static_cast<std::size_t>(i)];
    m.lever[i] = message.lever_arm[i];
    for (int j = 0; j < 3; ++j)
      m.covariance(i, j) = message.covariance[static_cast<std::size_t>(3 * i + j)];
  }
  return m;
}

AbsoluteMeasurement read_length(const measurement_t& message) {
  AbsoluteMeasurement m;
  m.kind = message.kind == measurement_t::KIND_DISTANCE ? MeasurementKind::kDistance
                                                        : MeasurementKind::kOdometry;
  m.until_us = message.utime2;
  m.length = message.value[0];
  m.sigma = std::sqrt(message.covariance[0]);  // of a negative one NaN
  return m;
}

std::string number_problem(Reason reason, const measurement_t& message) {
  if (reason == Reason::kBadMeasurementCovariance)
    return "its covariance is not finite, symmetric and positive definite";
  if (!is_position(message) && message.utime2 <= message.utime)
    return "utime2 is " + std::to_string(message.utime2) + ", not after utime";
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
  message.utime2 = 0;
  if (m.kind == MeasurementKind::kPosition) {
    message.value.assign(m.position.begin(), m.position.end());
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) message.covariance.push_back(m.covariance(i, j));
    std::copy(m.lever.begin(), m.lever.end(), message.lever_arm);
  } else {
    message.utime2 = m.until_us;
    message.value = {m.length};
    message.covariance = {m.sigma * m.sigma};  // whose root is the sigma again, to the bit
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
  m = is_position(message) ? read_position(message) : read_length(message);
  m.time_us = message.utime;
  m.id = {message.publisher, message.seq};
  result.value.camera = message.camera;
  if (const Reason reason = check_measurement(m); reason != Reason::kNone)
    return Result::refuse(reason, number_problem(reason, message));
  return result;
}

}  // namespace eifmap
