#include "simulation/mishap.h"

#include "simulation/value_noise.h"

namespace eifmap::simulation {

constexpr float kDark = 8;

void black_out(cv::Mat& gray) {
  gray.setTo(kDark);
}

void cover_right_half(cv::Mat& gray) {
  const float middle = 0.5f * static_cast<float>(gray.cols), soft = 0.03f * middle;
  for (int x = 0; x < gray.cols; ++x) {
    const float covered = smooth_step(middle - soft, middle + soft, static_cast<float>(x));
    for (int y = 0; y < gray.rows; ++y) {
      float& value = gray.at<float>(y, x);
      value = mix(value, kDark, covered);
    }
  }
}

}  // namespace eifmap::simulation
