#include "consistency/measurements.h"

#include "support/random.h"

namespace eifmap::test {
namespace {

Random random_of(int seed, std::uint64_t what) {
  return Random(static_cast<std::uint64_t>(seed) * 10 + what);
}

void add_positions(const FrameSource& source, const MeasurementSource& options, int seed,
                   std::vector<AbsoluteMeasurement>& all) {
  const Rigid3 earth = earth_from_world(seed);
  Random random = random_of(seed, 1);
  for (int i = 0; i < source.size(); i += options.gps_every) {
    const auto pose = source.world_from_camera(i);
    if (!pose) continue;
    AbsoluteMeasurement m;
    m.time_us = source.time_us(i);
    m.lever = {0.1, -0.3, 0.05};
    m.position = earth * (*pose * m.lever) + options.gps_sigma * random.normal_vector<3>();
    m.covariance = options.gps_sigma * options.gps_sigma * Eigen::Matrix3d::Identity();
    all.push_back(m);
  }
}

void add_distance(const FrameSource& source, const MeasurementSource& options, int seed,
                  std::vector<AbsoluteMeasurement>& all) {
  const auto frame_at = [&source](double share) { return static_cast<int>(share * source.size()); };
  const int first = frame_at(options.distance_from), last = frame_at(options.distance_to);
  const auto a = source.world_from_camera(first), b = source.world_from_camera(last);
  if (!a || !b) return;
  const double length = (a->translation - b->translation).norm();
  AbsoluteMeasurement m;
  m.kind = MeasurementKind::kDistance;
  m.time_us = source.time_us(first);
  m.until_us = source.time_us(last);
  m.sigma = options.distance_sigma * length;
  m.length = length + m.sigma * random_of(seed, 2).normal();
  all.push_back(m);
}

}  // namespace

Rigid3 earth_from_world(int seed) {
  Random random = random_of(seed, 3);
  const Eigen::Vector3d turn = random.normal_vector<3>(), origin = 300 * random.normal_vector<3>();
  return {so3_exp(turn), origin};
}

std::vector<AbsoluteMeasurement> make_measurements(const FrameSource& source,
                                                   const MeasurementSource& options, int seed) {
  std::vector<AbsoluteMeasurement> all;
  if (options.distance_sigma > 0) add_distance(source, options, seed, all);
  if (options.gps_sigma > 0) add_positions(source, options, seed, all);
  return all;
}

}  // namespace eifmap::test
