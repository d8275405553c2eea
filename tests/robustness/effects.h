// What may be wrong with an image. All of them 8-bit gray.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "geometry/camera.h"

namespace eifmap::test {

// As a JPEG file's bytes; quality in percent, as libjpeg counts.
std::vector<std::uint8_t> as_jpeg(const cv::Mat& image, int quality);

// Each pixel the mean of four; an odd last row or column is left out. And the camera that takes
// such images: pixel centres are at whole numbers, so that (cx + 0.5) is what is halved.
cv::Mat half_size(const cv::Mat& image);
Camera half_size(Camera camera);

// A brighter or darker exposure, white where it is beyond 255.
cv::Mat with_gain(const cv::Mat& image, double gain);

// Gaussian noise of each pixel's own, in gray levels, cut off at black and white.
cv::Mat with_noise(const cv::Mat& image, double sigma, cv::RNG& random);

// Pixels of any gray, each its own.
cv::Mat nothing_but_noise(cv::Size size, cv::RNG& random);

// Its pixels so far to the right and down, black where none are left.
cv::Mat shifted(const cv::Mat& image, cv::Point by);

enum class Half { kLeft, kRight, kTop, kBottom };

// That half of one gray.
cv::Mat half_covered(const cv::Mat& image, Half half, int gray);

}  // namespace eifmap::test
