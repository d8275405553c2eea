// One valid value of each message.
#pragma once

#include <random>

#include "command/command_message.h"
#include "convert/camera_message.h"
#include "convert/decision_message.h"
#include "convert/feature_message.h"
#include "convert/image_message.h"
#include "convert/map_message.h"
#include "convert/measurement_message.h"
#include "convert/pose_message.h"
#include "convert/relative_message.h"
#include "convert/status_message.h"
#include "published/map_part.h"
#include "published/map_request.h"
#include "published/said_of_map.h"

namespace eifmap::samples {

inline NamedCamera camera() {
  NamedCamera sample;
  sample.time_us = 1'700'000'000'000'000;
  sample.name = "front-left_2";
  sample.camera = {640,   480,    CameraModel::kRadialTangential,   520.25, 521.5,
                   319.5, 239.75, {-0.25, 0.125, 1e-3, -2e-3, 0.01}};
  return sample;
}

inline FeatureFrame features(int n = 50, unsigned seed = 1) {
  std::mt19937 random(seed);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() % 65536) / 65536.0f;
  };
  FeatureFrame frame;
  frame.time_us = 1'700'000'000'123'456;
  frame.publisher = -1234567890123456789;
  frame.seq = 17;
  frame.camera = "cam0";
  frame.calibration_id = camera().camera.id();
  frame.width = 640;
  frame.height = 480;
  for (int i = 0; i < n; ++i) {
    frame.keypoints.push_back({uniform(-0.5f, 639.5f), uniform(-0.5f, 479.5f), uniform(0.1f, 2),
                               uniform(1, 20), uniform(-3, 3), 1.0f / static_cast<float>(i + 1),
                               static_cast<std::int8_t>(i % 2 == 0 ? 1 : -1)});
    for (int k = 0; k < kDescriptorSize; ++k)
      frame.descriptors.push_back(static_cast<std::int8_t>(random() % 255 - 127));
  }
  return frame;
}

inline ImageMessage image() {
  ImageMessage image;
  image.time_us = 1'700'000'000'000'001;
  image.publisher = 99;
  image.seq = 3;
  image.calibration_id = -7;
  image.width = 20;
  image.height = 10;
  image.row_stride = 24;
  for (int i = 0; i < 240; ++i) image.data.push_back(static_cast<std::uint8_t>(i));
  return image;
}

inline Rigid3 pose(double a) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(a, Eigen::Vector3d(1, 2, 3).normalized())),
          {a, 1 / (a + 3), -2 * a}};
}

inline PublishedPose published_pose() {
  PublishedPose sample;
  sample.origin = {42, "cam0"};
  FrameResult& r = sample.result;
  r.time_us = 1'700'000'000'000'002;
  r.publisher = 99;
  r.seq = 4;
  r.map_id = 2;
  r.map_epoch = 1;
  r.map_seq = 9;
  r.state = TrackingState::kTracking;
  r.source = PoseSource::kScaleFit;
  r.reason = Reason::kNoBaseline;
  r.map_from_camera = pose(0.3);
  r.covariance_status = CovarianceStatus::kOptimistic;
  for (int i = 0; i < 36; ++i) r.covariance(i / 6, i % 6) = 1e-3 * i;
  r.reference_keyframe = 5;
  r.reference_from_camera = pose(-0.1);
  r.scale = {ScaleStatus::kFixed, 3.7, 0.012};
  r.num_matches = 200;
  r.num_inliers = 150;
  return sample;
}

inline PublishedDecision published_decision() {
  return {{42, "cam0"},
          {1'700'000'000'000'002, -99, 4, 12, -1234567890123456789, {{-5, 7}, {3, 0}}, true}};
}

inline RelativeRequest relative_request() {
  return {1'700'000'000'000'005, -9, 4, "cam0", 2, 17, 3};
}

inline RelativeAnswer relative_answer() {
  RelativeAnswer sample;
  sample.request = relative_request();
  sample.time_us = sample.request.time_us + 7;
  sample.origin = {42, "cam0"};
  sample.map_epoch = 1;
  sample.map_seq = 99;
  sample.view.a_from_b = {{0.6, 0, -0.8, 0}, {1.0 / 3, -2, 1e-9}};
  for (int i = 0; i < 36; ++i) sample.view.covariance(i / 6, i % 6) = 1.0 / (i + 1);
  return sample;
}

inline NamedMeasurement position() {
  NamedMeasurement sample{"cam0", {}};
  AbsoluteMeasurement& m = sample.measurement;
  m.id = {-77, 12};
  m.time_us = 1'700'000'000'000'003;
  m.position = {1.5, -2.1, 1e4};
  m.covariance << 4, 0.1, 0, 0.1, 5, -0.2, 0, -0.2, 6;
  m.lever = {0.1, 0.2, -0.3};
  return sample;
}

inline NamedMeasurement length(MeasurementKind kind = MeasurementKind::kDistance) {
  NamedMeasurement sample{"cam0", {}};
  AbsoluteMeasurement& m = sample.measurement;
  m.id = {77, 0};
  m.kind = kind;
  m.time_us = 1'700'000'000'000'003;
  m.until_us = m.time_us + 1;
  m.length = 31.7;
  m.sigma = 0.1;
  return sample;
}

inline NamedMeasurement gravity() {
  NamedMeasurement sample{"cam0", {}};
  AbsoluteMeasurement& m = sample.measurement;
  m.id = {78, 1};
  m.kind = MeasurementKind::kGravity;
  m.time_us = 1'700'000'000'000'004;
  m.down = {0.2, 9.79, -0.4};
  m.sigma = 0.01;
  return sample;
}

inline NamedMeasurement landmarks() {
  NamedMeasurement sample = length(MeasurementKind::kLandmarks);
  sample.measurement.until_us = 0;
  sample.measurement.map_id = 3;
  sample.measurement.landmark = {1234567890123, 0};
  return sample;
}

inline std::vector<NamedMeasurement> measurements() {
  return {position(), length(), length(MeasurementKind::kOdometry), gravity(), landmarks()};
}

inline MapUpdate map_update(int keyframes, int landmarks, std::int64_t base_seq,
                            std::int64_t first_id = 0) {
  MapUpdate update;
  update.map_id = 1;
  update.base_seq = base_seq;
  update.seq = base_seq == -1 ? 1 : base_seq + 1;
  for (int i = 0; i < keyframes; ++i)
    update.keyframes.push_back({first_id + i, 1000 * (first_id + i), pose(0.01 * i)});
  for (int i = 0; i < landmarks; ++i) {
    update.landmarks.push_back({first_id + i, first_id + i % keyframes,
                                Eigen::Vector3d(0.5 * i, -0.25 * i, 4), i % 2 == 0 ? 1 : -1, 3});
    update.observations.push_back({first_id + i % keyframes, first_id + i, 1.5f * (i % 400), 7});
  }
  // Known of one of each kind; values that a float holds exactly.
  const auto symmetric = []<int N>(Eigen::Matrix<double, N, N>& m) {
    for (int row = 0; row < N; ++row)
      for (int column = 0; column < N; ++column)
        m(row, column) = (row == column ? 4.0 : 0.125 * (row + column + row * column));
  };
  if (keyframes > 1) symmetric(update.keyframes[1].covariance);
  if (landmarks > 1) symmetric(update.landmarks[1].covariance);
  return update;
}

inline map_request_t map_request() {
  map_request_t request{};
  request.utime = 1'700'000'000'000'006;
  request.requester = -5;
  request.camera = "cam0";
  request.server_epoch = 42;
  request.have_seq = 7;
  request.missing.resize(3);
  for (missing_part_t& missing : request.missing) {
    missing.seq = 8;
    missing.part = kAllParts;
    missing.whole = 0;
  }
  request.num_missing = 3;
  return request;
}

inline diagnostic_t named(const std::string& key, const std::string& value) {
  diagnostic_t entry;
  entry.key = key;
  entry.value = value;
  return entry;
}

inline command_t command() {
  command_t command{};
  command.utime = 1'700'000'000'000'008;
  command.sender = -6;
  command.request_id = 3;
  command.server_epoch = 42;
  command.ticket = 1LL << 60;
  command.camera = "cam0";
  command.command = command_t::CMD_SET_SCALE;
  command.args = {named("metres_per_unit", "2.5"), named("sigma", "0.01")};
  command.num_args = 2;
  for (int i = 0; i < 32; ++i) command.mac.push_back(static_cast<std::uint8_t>(250 + i));
  command.mac_size = 32;
  return command;
}

inline reply_t reply() {
  reply_t reply{};
  reply.utime = 1'700'000'000'000'009;
  reply.sender = -6;
  reply.request_id = 3;
  reply.server_epoch = 42;
  reply.ticket = (1LL << 60) + 7;
  reply.camera = "cam0";
  reply.command = command_t::CMD_SET_SCALE;
  reply.result = reply_t::RESULT_ERROR;
  reply.reason = 110;
  reply.message = "there is no map";
  reply.map_id = 2;
  reply.values = {named("keyframes", "0")};
  reply.num_values = 1;
  return reply;
}

inline status_t status() {
  status_t s{};
  s.metres_per_unit = 1;
  s.earth = status_t::EARTH_PLACED;
  s.earth_position[1] = -12.5;
  s.earth_quaternion[0] = 0.6;
  s.earth_quaternion[2] = 0.8;
  for (int i = 0; i < 36; ++i) s.earth_covariance[i] = i;
  s.utime = s.start_utime = 1'700'000'000'000'000;
  s.name = "eifmap-server";
  s.version = "0.1.0";
  s.host = "here";
  s.camera = "cam0";
  s.message = "the camera has only rotated";
  s.num_diagnostics = 2;
  s.diagnostics.resize(2);
  s.diagnostics[0].key = "reason.NO_BASELINE";
  s.diagnostics[0].value = "12";
  return s;
}

}  // namespace eifmap::samples
