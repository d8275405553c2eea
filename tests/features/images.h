// Images whose content is known exactly: blobs, noise and an endless texture.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <random>

namespace eifmap::testing {

// Mean of `intensity` (grey values, at continuous pixel coordinates) over each pixel.
inline cv::Mat render(int width, int height,
                      const std::function<double(double, double)>& intensity) {
  constexpr int kSamples = 3;  // per axis and pixel
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      double sum = 0;
      for (int j = 0; j < kSamples; ++j)
        for (int i = 0; i < kSamples; ++i)
          sum += intensity(x + (i + 0.5) / kSamples - 0.5, y + (j + 0.5) / kSamples - 0.5);
      image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(sum / (kSamples * kSamples));
    }
  return image;
}

inline cv::Mat random_image(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat image(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(random() >> 24);
  return image;
}

// Smooth noise of many sizes, a pure function of the place.
class Texture {
 public:
  explicit Texture(unsigned seed) : seed_(seed) {}

  double operator()(double x, double y) const {  // about 128 +- 50
    double sum = 0;
    for (const double size : {6.0, 11.0, 23.0, 47.0})
      sum += std::sqrt(size / 11.0) * octave(x / size, y / size, static_cast<unsigned>(size));
    return 128 + 45 * sum;
  }

 private:
  double octave(double x, double y, unsigned salt) const {
    const double left = std::floor(x), top = std::floor(y);
    const double s = smooth(x - left), t = smooth(y - top);
    const auto value = [&](int i, int j) {
      return lattice(static_cast<int>(left) + i, static_cast<int>(top) + j, salt);
    };
    const double upper = value(0, 0) + s * (value(1, 0) - value(0, 0));
    const double lower = value(0, 1) + s * (value(1, 1) - value(0, 1));
    return upper + t * (lower - upper);
  }

  static double smooth(double t) { return t * t * t * (t * (6 * t - 15) + 10); }

  double lattice(int x, int y, unsigned salt) const {  // in [-1, 1)
    std::uint32_t h = seed_ * 0x9E3779B9u + salt * 0x85EBCA6Bu;
    for (const int c : {x, y}) {
      h ^= static_cast<std::uint32_t>(c) * 0xC2B2AE35u;
      h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
      h = (h ^ (h >> 12)) * 0x297A2D39u;
      h ^= h >> 15;
    }
    return h / 2147483648.0 - 1;
  }

  unsigned seed_;
};

// Gaussian noise as a camera's; `sigma` in grey values.
inline cv::Mat with_noise(const cv::Mat& clean, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, sigma);
  cv::Mat noisy = clean.clone();
  for (int y = 0; y < noisy.rows; ++y)
    for (int x = 0; x < noisy.cols; ++x)
      noisy.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(clean.at<std::uint8_t>(y, x) + normal(random));
  return noisy;
}

// A view of a texture through a homography, with noise.
inline cv::Mat view(const Texture& texture, int width, int height,
                    const Eigen::Matrix3d& texture_from_image, double noise, unsigned seed) {
  const cv::Mat clean = render(width, height, [&](double x, double y) {
    const Eigen::Vector3d p = texture_from_image * Eigen::Vector3d(x, y, 1);
    return texture(p.x() / p.z(), p.y() / p.z());
  });
  return with_noise(clean, noise, seed);
}

}  // namespace eifmap::testing
