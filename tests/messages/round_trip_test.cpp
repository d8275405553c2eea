// What is encoded comes back as it was, to the bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "convert/earth_fields.h"
#include "messages/samples.h"

namespace eifmap {
namespace {

void expect_same_keypoint(const Keypoint& a, const Keypoint& b) {
  EXPECT_EQ(a.u, b.u);
  EXPECT_EQ(a.v, b.v);
  EXPECT_EQ(a.sigma_px, b.sigma_px);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.angle, b.angle);
  EXPECT_EQ(a.response, b.response);
  EXPECT_EQ(a.laplacian_sign, b.laplacian_sign);
}

void expect_same_pose(const Rigid3& a, const Rigid3& b) {
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
  EXPECT_EQ(a.translation, b.translation);
}

class RoundTripFeatures : public testing::TestWithParam<int> {};

TEST_P(RoundTripFeatures, Exact) {
  const FeatureFrame frame = samples::features(GetParam());
  const Decoded<FeatureFrame> decoded = decode_features(encode(to_message(frame)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  const FeatureFrame& back = decoded.value;
  EXPECT_EQ(back.time_us, frame.time_us);
  EXPECT_EQ(back.publisher, frame.publisher);
  EXPECT_EQ(back.seq, frame.seq);
  EXPECT_EQ(back.camera, frame.camera);
  EXPECT_EQ(back.calibration_id, frame.calibration_id);
  EXPECT_EQ(back.width, frame.width);
  EXPECT_EQ(back.height, frame.height);
  EXPECT_EQ(back.extractor, frame.extractor);
  EXPECT_EQ(back.extractor_version, frame.extractor_version);
  EXPECT_EQ(back.descriptors, frame.descriptors);
  ASSERT_EQ(back.keypoints.size(), frame.keypoints.size());
  for (std::size_t i = 0; i < frame.keypoints.size(); ++i)
    expect_same_keypoint(back.keypoints[i], frame.keypoints[i]);
  EXPECT_EQ(encode(to_message(back)), encode(to_message(frame)));
}

INSTANTIATE_TEST_SUITE_P(Sizes, RoundTripFeatures, testing::Values(0, 1, 50, 1000));

TEST(RoundTrip, Camera) {
  const NamedCamera camera = samples::camera();
  const Decoded<NamedCamera> decoded = decode_camera(encode(to_message(camera)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(decoded.value.name, camera.name);
  EXPECT_EQ(decoded.value.camera.id(), camera.camera.id());
  EXPECT_EQ(decoded.value.camera.distortion, camera.camera.distortion);
}

TEST(RoundTrip, FisheyeCamera) {
  NamedCamera camera = samples::camera();
  camera.camera.model = CameraModel::kFisheye;
  camera.camera.distortion = {-0.01, 0.004, -0.001, 0.0002, 0};
  const Decoded<NamedCamera> decoded = decode_camera(encode(to_message(camera)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(decoded.value.camera.model, CameraModel::kFisheye);
  EXPECT_EQ(decoded.value.camera.id(), camera.camera.id());
}

TEST(RoundTrip, Image) {
  const ImageMessage image = samples::image();
  const Decoded<ImageMessage> decoded = decode_image(encode(to_message(image)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(decoded.value.seq, image.seq);
  EXPECT_EQ(decoded.value.publisher, image.publisher);
  EXPECT_EQ(decoded.value.calibration_id, image.calibration_id);
  EXPECT_EQ(decoded.value.row_stride, image.row_stride);
  EXPECT_EQ(decoded.value.data, image.data);
}

TEST(RoundTrip, Pose) {
  const PublishedPose pose = samples::published_pose();
  const Decoded<PublishedPose> decoded = decode_pose(encode(to_message(pose)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  const FrameResult& back = decoded.value.result;
  EXPECT_EQ(decoded.value.origin.server_epoch, pose.origin.server_epoch);
  EXPECT_EQ(back.state, pose.result.state);
  EXPECT_EQ(back.source, pose.result.source);
  EXPECT_EQ(back.reason, pose.result.reason);
  EXPECT_EQ(back.covariance, pose.result.covariance);
  EXPECT_EQ(back.map_seq, pose.result.map_seq);
  EXPECT_EQ(back.scale.status, ScaleStatus::kFixed);
  EXPECT_EQ(back.scale.metres_per_unit, pose.result.scale.metres_per_unit);
  EXPECT_EQ(back.scale.sigma, pose.result.scale.sigma);
  expect_same_pose(back.map_from_camera, pose.result.map_from_camera);
  expect_same_pose(back.reference_from_camera, pose.result.reference_from_camera);
}

TEST(RoundTrip, Decision) {
  PublishedDecision decision = samples::published_decision();
  for (const std::int64_t job : {kAdoptedAtOnce, std::int64_t{0}, std::int64_t{12}}) {
    decision.decision.adopted_job = job;
    const Decoded<PublishedDecision> decoded = decode_decision(encode(to_message(decision)));
    ASSERT_TRUE(decoded.ok()) << decoded.detail;
    EXPECT_EQ(decoded.value.decision, decision.decision);
    EXPECT_EQ(decoded.value.origin.server_epoch, decision.origin.server_epoch);
    EXPECT_EQ(decoded.value.origin.camera, decision.origin.camera);
  }
}

void expect_same(const AbsoluteMeasurement& a, const AbsoluteMeasurement& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.kind, b.kind);
  EXPECT_EQ(a.time_us, b.time_us);
  EXPECT_EQ(a.until_us, b.until_us);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.lever, b.lever);
  EXPECT_EQ(a.down, b.down);
  EXPECT_EQ(a.map_id, b.map_id);
  EXPECT_EQ(a.landmark, b.landmark);
  EXPECT_EQ(a.length, b.length);
  EXPECT_EQ(a.sigma, b.sigma);
}

TEST(RoundTrip, Measurement) {
  for (const NamedMeasurement& measurement : samples::measurements()) {
    const Decoded<NamedMeasurement> decoded = decode_measurement(encode(to_message(measurement)));
    ASSERT_TRUE(decoded.ok()) << decoded.detail;
    EXPECT_EQ(decoded.value.camera, measurement.camera);
    expect_same(decoded.value.measurement, measurement.measurement);
  }
}

void expect_same(const RelativeRequest& a, const RelativeRequest& b) {
  EXPECT_EQ(a.requester, b.requester);
  EXPECT_EQ(a.request_id, b.request_id);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.map_id, b.map_id);
  EXPECT_EQ(a.a, b.a);
  EXPECT_EQ(a.b, b.b);
}

TEST(RoundTrip, RelativeRequestAndAnswer) {
  const RelativeRequest request = samples::relative_request();
  const auto asked = decode_relative_request(encode(to_message(request)));
  ASSERT_TRUE(asked.ok()) << asked.detail;
  EXPECT_EQ(asked.value.time_us, request.time_us);
  expect_same(asked.value, request);
  const RelativeAnswer answer = samples::relative_answer();
  const auto answered = decode_relative(encode(to_message(answer)));
  ASSERT_TRUE(answered.ok()) << answered.detail;
  expect_same(answered.value.request, answer.request);
  EXPECT_EQ(answered.value.time_us, answer.time_us);
  EXPECT_EQ(answered.value.origin.server_epoch, 42);
  EXPECT_EQ(answered.value.map_epoch, answer.map_epoch);
  EXPECT_EQ(answered.value.map_seq, answer.map_seq);
  EXPECT_EQ(answered.value.reason, Reason::kNone);
  expect_same_pose(answered.value.view.a_from_b, answer.view.a_from_b);
  EXPECT_EQ(answered.value.view.covariance, answer.view.covariance);
}

TEST(RoundTrip, Command) {
  const command_t command = samples::command();
  const Decoded<command_t> decoded = decode_command(encode(command));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  const command_t& back = decoded.value;
  EXPECT_EQ(back.sender, -6);
  EXPECT_EQ(back.request_id, 3);
  EXPECT_EQ(back.server_epoch, 42);
  EXPECT_EQ(back.ticket, command.ticket);
  EXPECT_EQ(back.camera, "cam0");
  EXPECT_EQ(argument(back, "sigma"), "0.01");
  EXPECT_EQ(argument(back, "name"), "");
  EXPECT_EQ(back.mac, command.mac);
  EXPECT_EQ(encode(back), encode(command));
}

TEST(RoundTrip, Reply) {
  const reply_t reply = samples::reply();
  const Decoded<reply_t> decoded = decode_reply(encode(reply));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(decoded.value.result, reply_t::RESULT_ERROR);
  EXPECT_EQ(decoded.value.message, reply.message);
  EXPECT_EQ(decoded.value.values[0].key, "keyframes");
  EXPECT_EQ(encode(decoded.value), encode(reply));
}

TEST(RoundTrip, AnySigmaToTheBit) {
  NamedMeasurement length = samples::length();
  for (double& sigma = length.measurement.sigma; sigma < 100; sigma *= 1.0137) {
    const auto decoded = decode_measurement(encode(to_message(length)));
    ASSERT_TRUE(decoded.ok()) << decoded.detail;
    ASSERT_EQ(decoded.value.measurement.sigma, sigma);
  }
}

TEST(RoundTrip, Status) {
  const status_t status = samples::status();
  const Decoded<status_t> decoded = decode_status(encode(status));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  EXPECT_EQ(decoded.value.message, status.message);
  EXPECT_EQ(decoded.value.diagnostics[0].value, "12");
  const EarthState earth = read_earth(decoded.value);
  EXPECT_EQ(earth.status, EarthStatus::kPlaced);
  EXPECT_EQ(earth.earth_from_map.translation, Eigen::Vector3d(0, -12.5, 0));
  EXPECT_EQ(earth.earth_from_map.rotation.y(), 0.8);
  EXPECT_EQ(earth.covariance(1, 2), 8);
  status_t again{};
  write_earth(earth, again);
  EXPECT_TRUE(std::equal(std::begin(again.earth_covariance), std::end(again.earth_covariance),
                         std::begin(status.earth_covariance)));
  EXPECT_EQ(again.earth, status.earth);
}

TEST(RoundTrip, MapPart) {
  const MapUpdate update = samples::map_update(3, 40, 6);
  const Decoded<map_part_t> decoded = decode_map_part(encode(to_message(update, {42, "cam0"}, 77)));
  ASSERT_TRUE(decoded.ok()) << decoded.detail;
  const map_part_t& back = decoded.value;
  EXPECT_EQ(back.utime, 77);
  EXPECT_EQ(back.server_epoch, 42);
  EXPECT_EQ(back.seq, update.seq);
  EXPECT_EQ(back.base_seq, update.base_seq);
  ASSERT_EQ(back.keyframes.size(), update.keyframes.size());
  expect_same_pose(read_pose(back.keyframes[2].position, back.keyframes[2].quaternion),
                   update.keyframes[2].map_from_camera);
  EXPECT_TRUE(std::isnan(back.keyframes[2].covariance[20]));  // unknown stays unknown
  EXPECT_EQ(back.keyframes[1].covariance[1], update.keyframes[1].covariance(0, 1));
  EXPECT_EQ(back.keyframes[1].covariance[20], update.keyframes[1].covariance(5, 5));
  ASSERT_EQ(back.landmarks.size(), update.landmarks.size());
  EXPECT_TRUE(std::isnan(back.landmarks[39].covariance[0]));
  EXPECT_EQ(back.landmarks[1].covariance[4], update.landmarks[1].covariance(1, 2));
  EXPECT_EQ(back.landmarks[39].position[1], update.landmarks[39].position_in_anchor[1]);
  EXPECT_EQ(back.observations.size(), update.observations.size());
}

}  // namespace
}  // namespace eifmap
