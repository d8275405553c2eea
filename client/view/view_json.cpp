#include "client/view/view_json.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace eifmap::view_json {
namespace {

template <class Vector>
void append_numbers(Json& list, const Vector& values) {
  for (int i = 0; i < static_cast<int>(values.size()); ++i) list.push_back(number(values[i]));
}

void append_rotation(Json& list, const Eigen::Quaterniond& q) {
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) list.push_back(number(value));
}

}  // namespace

Json number(double value) {
  if (!std::isfinite(value)) return nullptr;
  constexpr double kSteps = 1e5;
  return std::round(value * kSteps) / kSteps + 0.0;  // no -0
}

Json pose(const FrameResult& result) {
  Json position = Json::array(), quaternion = Json::array();
  append_numbers(position, result.map_from_camera.translation);
  append_rotation(quaternion, result.map_from_camera.rotation);
  Json json{{"position", position},
            {"quaternion", quaternion},
            {"ellipsoid", nullptr},
            {"sigmas", nullptr}};
  if (result.covariance_status == CovarianceStatus::kNone) return json;
  const Eigen::Matrix3d covariance = result.covariance.topLeftCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  if (solver.info() != Eigen::Success) return json;
  json["ellipsoid"] = json["sigmas"] = Json::array();
  for (const int axis : {2, 1, 0}) {  // eigenvalues rise
    const double sigma = std::sqrt(std::max(0.0, solver.eigenvalues()[axis]));
    // Axes of the first, well-known poses are shorter than number() keeps: they are as they are.
    for (int i = 0; i < 3; ++i)
      json["ellipsoid"].push_back(static_cast<float>(3 * sigma * solver.eigenvectors()(i, axis)));
    json["sigmas"].push_back(sigma);
  }
  return json;
}

Json status(const status_t& status) {
  return {{"name", status.name},
          {"version", status.version},
          {"host", status.host},
          {"input_hz", number(status.input_hz)},
          {"pose_hz", number(status.pose_hz)},
          {"latency_ms_p50", number(status.latency_ms_p50)},
          {"latency_ms_p99", number(status.latency_ms_p99)},
          {"received", status.frames_received},
          {"processed", status.frames_processed},
          {"dropped", status.frames_dropped},
          {"rejected", status.frames_rejected},
          {"gaps", status.sequence_gaps},
          {"keyframes", status.num_keyframes},
          {"landmarks", status.num_landmarks},
          {"rss_bytes", status.rss_bytes}};
}

Json lens(const NamedCamera& named) {
  const Camera& camera = named.camera;
  return {{"width", camera.width},
          {"height", camera.height},
          {"half_width", number(0.5 * camera.width / camera.fx)},
          {"half_height", number(0.5 * camera.height / camera.fy)}};
}

Json features(const FeatureFrame& features) {
  Json points = Json::array();
  for (const Keypoint& keypoint : features.keypoints) {
    points.push_back(std::lround(keypoint.u));
    points.push_back(std::lround(keypoint.v));
    points.push_back(keypoint.laplacian_sign);
  }
  return {{"width", features.width}, {"height", features.height}, {"points", std::move(points)}};
}

Json path(const ShownPath& path, std::size_t from) {
  Json steps = Json::array();
  for (std::size_t i = from; i < path.steps().size(); ++i) {
    append_numbers(steps, path.steps()[i].position);
    steps.push_back(path.steps()[i].joined ? 1 : 0);
  }
  return {{"from", from}, {"steps", std::move(steps)}};
}

void append(Json& list, std::int64_t id, const ShownKeyframe& keyframe) {
  list.push_back(id);
  append_numbers(list, keyframe.map_from_camera.translation);
  append_rotation(list, keyframe.map_from_camera.rotation);
}

void append(Json& list, std::int64_t id, const ShownLandmark& landmark) {
  list.push_back(id);
  list.push_back(landmark.anchor);
  append_numbers(list, landmark.position);
  list.push_back(landmark.signed_observations);
  list.push_back(number(landmark.sigma));
}

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace eifmap::view_json
