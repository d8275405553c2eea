#include "simulation/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace eifmap::simulation {
namespace {

double wave(double hertz, double seconds, double phase) {
  return std::sin(2 * std::numbers::pi * hertz * seconds + phase);
}

Rigid3 turned(const Rigid3& pose, double angle) {
  return {so3_exp({0, angle, 0}) * pose.rotation, pose.translation};
}

// From where it would be.
Rigid3 swaying_as_a_car(double t) {
  const Eigen::Vector3d centre(0.12 * wave(0.13, t, 0.5), 0.012 * wave(1.3, t, 0), 0);
  const Eigen::Vector3d attitude(0.004 * wave(1.1, t, 0.7), 0.012 * wave(0.13, t, 1.9),
                                 0.004 * wave(0.7, t, 0.2));
  return {so3_exp(attitude), centre};
}

// There and back, smoothly; `part` of the way in [0, 1].
double there_and_back(double part) {
  return 0.5 * (1 - std::cos(2 * std::numbers::pi * part));
}

}  // namespace

Motion walking(const Walk& walk) {
  return [walk](double t) { return walk.world_from_camera(t); };
}

Motion standing(const Rigid3& place) {
  return [place](double) { return place; };
}

Motion driving(const Rigid3& start, double speed) {
  return [=](double t) {
    Rigid3 driven = swaying_as_a_car(t);
    driven.translation.z() = speed * t;
    return start * driven;
  };
}

Motion driving_round(const RoundedRectangle& way, double height, double speed) {
  return [=](double t) {
    const auto [centre, along] = way.at(speed * t);
    const Eigen::Vector3d heading(0, std::atan2(along.x(), along.z()), 0);
    return Rigid3(so3_exp(heading), centre - Eigen::Vector3d(0, height, 0)) * swaying_as_a_car(t);
  };
}

Motion moving_sideways(const Rigid3& start, double speed) {
  return [=](double t) {
    const Eigen::Vector3d centre(speed * t, 0.03 * wave(0.3, t, 0), 0.1 * wave(0.09, t, 0));
    const Eigen::Vector3d attitude(0.02 * wave(0.19, t, 0), 0.12 * wave(0.11, t, 0),
                                   0.02 * wave(0.14, t, 0));
    return start * Rigid3(so3_exp(attitude), centre);
  };
}

Motion panning(const Rigid3& place, double angle, double period) {
  return [=](double t) { return turned(place, angle * there_and_back(t / period)); };
}

Motion with_pause(Motion motion, double from, double length) {
  return [=, motion = std::move(motion)](double t) {
    return motion(t < from ? t : std::max(from, t - length));
  };
}

Motion with_look_around(Motion motion, double from, double length, double angle) {
  return [=, paused = with_pause(std::move(motion), from, length)](double t) {
    const double part = std::clamp((t - from) / length, 0.0, 1.0);
    return turned(paused(t), angle * there_and_back(part));
  };
}

Motion with_carrying(Motion motion, double from, double length, double to) {
  return [=, motion = std::move(motion)](double t) {
    return motion(t < from ? t : to + std::max(0.0, t - from - length));
  };
}

}  // namespace eifmap::simulation
