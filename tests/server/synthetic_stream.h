// Feature frames of a camera that moves sideways past points whose descriptors never change.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "frame.h"
#include "geometry/camera.h"
#include "support/random.h"

namespace eifmap {

inline Camera synthetic_camera() {
  Camera camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 500;
  camera.cx = 319.5;
  camera.cy = 239.5;
  return camera;
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

  // The i-th image, 0.1 s and `step` after the one before; the noise is the same in every call.
  FeatureFrame frame(int i, double step = 0.1) const {
    const Camera camera = synthetic_camera();
    test::Random noise(static_cast<std::uint64_t>(i) + 1000);
    FeatureFrame frame;
    frame.time_us = 1'000'000 + 100'000 * i;
    frame.publisher = 7;
    frame.seq = i;
    frame.camera = "cam0";
    frame.calibration_id = camera.id();
    frame.width = camera.width;
    frame.height = camera.height;
    for (std::size_t k = 0; k < points_.size(); ++k) {
      const Eigen::Vector3d x = points_[k] - Eigen::Vector3d(step * i, 0, 0);
      const Eigen::Vector2d pixel = camera.pixel_from_normalized(x.hnormalized());
      const auto u = static_cast<float>(pixel.x() + 0.3 * noise.normal());
      const auto v = static_cast<float>(pixel.y() + 0.3 * noise.normal());
      if (u < 0 || v < 0 || u > 639 || v > 479) continue;
      const float response = 1.0f / static_cast<float>(k + 1);  // so that they are sorted
      frame.keypoints.push_back(
          {u, v, 0.3f, 2.0f, 0.0f, response, static_cast<std::int8_t>(k % 2 == 0 ? 1 : -1)});
      const auto begin = descriptors_.begin() + static_cast<long>(k) * kDescriptorSize;
      frame.descriptors.insert(frame.descriptors.end(), begin, begin + kDescriptorSize);
    }
    return frame;
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<std::int8_t> descriptors_;
};

}  // namespace eifmap
