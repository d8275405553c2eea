// Feature frames of a camera among points whose descriptors never change: the mapper's input
// without images.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "frame.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "simulation/feature_world.h"
#include "support/random.h"

namespace eifmap {

inline Camera synthetic_camera() {
  return feature_world_camera();
}

class SyntheticStream {
 public:
  explicit SyntheticStream(std::uint64_t seed = 1) {
    test::Random random(seed);
    for (int i = 0; i < 900; ++i) {
      points_.push_back({random.uniform(-8, 14), random.uniform(-4, 4), random.uniform(4, 10)});
      Eigen::Matrix<double, kDescriptorSize, 1> descriptor;
      for (double& x : descriptor) x = random.uniform(-1, 1);
      descriptor *= 254 / descriptor.norm();
      for (const double x : descriptor)
        descriptors_.push_back(static_cast<std::int8_t>(std::lround(x)));
    }
  }

  // The i-th image, 0.1 s and `step` sideways after the one before; the noise is the same in every
  // call.
  FeatureFrame frame(int i, double step = 0.1) const {
    return view(i, Rigid3({1, 0, 0, 0}, {step * i, 0, 0}));
  }

  // The i-th image, taken from anywhere. `wrong_share`: of the features, whose descriptors are
  // those of another point.
  FeatureFrame view(int i, const Rigid3& world_from_camera, double wrong_share = 0) const {
    const Camera camera = synthetic_camera();
    test::Random noise(static_cast<std::uint64_t>(i) + 1000);
    const Rigid3 camera_from_world = world_from_camera.inverse();
    FeatureFrame frame;
    frame.time_us = 1'000'000 + 100'000 * i;
    frame.publisher = 7;
    frame.seq = i;
    frame.camera = "cam0";
    frame.calibration_id = camera.id();
    frame.width = camera.width;
    frame.height = camera.height;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Eigen::Vector3d x = camera_from_world * points_[k];
      const Eigen::Vector2d jitter(0.3 * noise.normal(), 0.3 * noise.normal());
      const std::size_t looks_like =
          noise.uniform() < wrong_share ? noise.bits() % points_.size() : k;
      if (x.z() < 0.5) continue;
      const Eigen::Vector2d pixel = camera.pixel_from_normalized(x.hnormalized()) + jitter;
      if (pixel.minCoeff() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
      const float response = 1.0f / static_cast<float>(k + 1);  // so that they are sorted
      // A sigma of 0.15 px, since the mapper's sigma_factor doubles what a keypoint says.
      frame.keypoints.push_back({static_cast<float>(pixel.x()), static_cast<float>(pixel.y()),
                                 0.15f, 2.0f, 0.0f, response,
                                 static_cast<std::int8_t>(k % 2 == 0 ? 1 : -1)});
      const auto begin = descriptors_.begin() + static_cast<long>(looks_like) * kDescriptorSize;
      frame.descriptors.insert(frame.descriptors.end(), begin, begin + kDescriptorSize);
    }
    return frame;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::int8_t> descriptors_;
};

}  // namespace eifmap
