#include "simulation/walk.h"

#include <cmath>
#include <numbers>

#include "simulation/footpath.h"

namespace eifmap::simulation {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

// The ellipse by its angle from the south, eastwards: (half_east sin, -half_north cos).
double metres_per_radian(const Walk& walk, double angle) {
  return std::hypot(walk.half_east * std::cos(angle), walk.half_north * std::sin(angle));
}

double arc_length(const Walk& walk, double angle) {
  constexpr int kSteps = 256;  // Simpson's rule
  const double h = angle / kSteps;
  double sum = metres_per_radian(walk, 0) + metres_per_radian(walk, angle);
  for (int i = 1; i < kSteps; ++i) sum += (i % 2 == 1 ? 4 : 2) * metres_per_radian(walk, i * h);
  return sum * h / 3;
}

// Where on the ellipse one is after `length` m: Newton on the arc length, which is smooth and
// monotonous.
double angle_at(const Walk& walk, double length) {
  double angle = kTurn * length / walk.lap_length();
  for (int i = 0; i < 8; ++i)
    angle -= (arc_length(walk, angle) - length) / metres_per_radian(walk, angle);
  return angle;
}

Footprint on_ellipse(const Walk& walk, double length) {
  const double angle = angle_at(walk, length);
  return {{walk.half_east * std::sin(angle), 0, -walk.half_north * std::cos(angle)},
          Eigen::Vector3d(walk.half_east * std::cos(angle), 0, walk.half_north * std::sin(angle))
              .normalized()};
}

// An arc takes half a second. The rectangle lies so that the first turn leads between a column and
// a hedge, an arm's length from either.
RoundedRectangle rectangle(const Walk& walk) {
  constexpr double kWest = -6.5, kEast = 2.45, kSouth = -5.2, kNorth = 6.3;  // m
  return {kWest, kEast, kSouth, kNorth, 0.5 * walk.speed / (kTurn / 4)};
}

Footprint place_on_path(const Walk& walk, double length) {
  if (walk.path == Path::kEllipse) return on_ellipse(walk, length);
  if (walk.path == Path::kRectangle) return rectangle(walk).at(length);
  return {{0, 0, length}, {0, 0, 1}};
}

Eigen::Quaterniond turn(double angle, const Eigen::Vector3d& axis) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis));
}

}  // namespace

double Walk::lap_length() const {
  return path == Path::kEllipse ? arc_length(*this, kTurn) : rectangle(*this).lap_length();
}

TurnTimes first_turn(const Walk& walk) {
  const RoundedRectangle way = rectangle(walk);
  const double begin = way.side_length(0) / walk.speed;
  return {begin, begin + way.radius * kTurn / 4 / walk.speed};
}

Rigid3 Walk::world_from_camera(double seconds) const {
  const auto [centre, along] = place_on_path(*this, speed * seconds);
  const auto wave = [seconds](double hertz, double phase) {
    return std::sin(kTurn * hertz * seconds + phase);
  };
  const Eigen::Vector3d left(-along.z(), 0, along.x());  // inwards

  // Two steps a second bob the body, one weight shift a second sways it; the hand wanders slowly.
  Rigid3 pose;
  pose.translation = centre + (0.035 * wave(0.95, 0.4) + 0.10 * wave(0.11, 1.0)) * left;
  pose.translation.y() = -eye_height + 0.022 * wave(1.9, 0) + 0.05 * wave(0.17, 2.0);
  const double heading = std::atan2(along.x(), along.z());  // about y (down), from north to east
  const double yaw = heading - inwards + 0.14 * wave(0.1, 0.8) + 0.012 * wave(0.95, 1.3);
  const double pitch = -0.02 + 0.035 * wave(0.21, 0.3) + 0.008 * wave(1.9, 0.9);
  const double lean = 0.03 * wave(0.16, 1.9) + 0.012 * wave(0.95, 0) + roll * wave(0.05, 0);
  pose.rotation = turn(yaw, Eigen::Vector3d::UnitY()) * turn(pitch, Eigen::Vector3d::UnitX()) *
                  turn(lean, Eigen::Vector3d::UnitZ());
  return pose;
}

}  // namespace eifmap::simulation
