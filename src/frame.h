// The values handed from step to step. All that the mapper ever sees of an image is a FeatureFrame;
// its numbers are exactly those of the wire (float32, int8), so that a map made from images and a
// map made from the features extracted elsewhere are the same map.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace eifmap {

// Bytes of a descriptor: a unit 64-vector, each entry round(254 x), |x| <= 0.5 by construction of
// the clamp in the extractor.
inline constexpr int kDescriptorSize = 64;

// The wire's values; descriptors of different extractors or versions never match.
enum class Extractor : std::int16_t { kSurfUpright = 1, kSurfOriented = 2, kSift = 3 };

// One blob in an image.
struct Keypoint {
  float u = 0, v = 0;  // px, raw (distorted); the centre of the top-left pixel is (0, 0)
  float sigma_px = 1;  // px, standard deviation of (u, v), each axis
  float scale = 1;     // px, sigma of the blob
  // rad, +u towards +v: of the frame that the descriptor is made in. kSurfUpright: one for the
  // whole image, 0 while the camera is level.
  float angle = 0;
  float response = 0;  // how sure: SURF determinant of the Hessian, normalized by scale; SIFT |DoG|
  std::int8_t laplacian_sign = 0;  // sign of Lxx + Lyy: -1 bright blob on dark, +1 dark on bright
};

// An image as the mapper sees it.
struct FeatureFrame {
  std::int64_t time_us = 0;    // capture, publisher's clock, since the Unix epoch
  std::int64_t publisher = 0;  // random per start of a publisher; 0 unknown
  std::int64_t seq = -1;       // +1 per captured image; -1 unknown
  std::string camera;
  std::int64_t calibration_id = 0;
  int width = 0, height = 0;  // px
  Extractor extractor = Extractor::kSurfUpright;
  std::int16_t extractor_version = 1;
  std::vector<Keypoint> keypoints;       // sorted by response falling, then v, then u
  std::vector<std::int8_t> descriptors;  // kDescriptorSize bytes per keypoint, row-major
};

}  // namespace eifmap
