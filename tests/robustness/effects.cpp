#include "robustness/effects.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace eifmap::test {

std::vector<std::uint8_t> as_jpeg(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return bytes;
}

cv::Mat half_size(const cv::Mat& image) {
  const cv::Size half(image.cols / 2, image.rows / 2);
  cv::Mat result;
  cv::resize(image(cv::Rect(cv::Point(), half * 2)), result, half, 0, 0, cv::INTER_AREA);
  return result;
}

Camera half_size(Camera camera) {
  camera.width /= 2;
  camera.height /= 2;
  camera.fx /= 2;
  camera.fy /= 2;
  camera.cx = (camera.cx + 0.5) / 2 - 0.5;
  camera.cy = (camera.cy + 0.5) / 2 - 0.5;
  return camera;
}

cv::Mat with_gain(const cv::Mat& image, double gain) {
  cv::Mat result;
  image.convertTo(result, CV_8U, gain);
  return result;
}

cv::Mat with_noise(const cv::Mat& image, double sigma, cv::RNG& random) {
  cv::Mat noise(image.size(), CV_16S), result;
  random.fill(noise, cv::RNG::NORMAL, 0, sigma);
  cv::add(image, noise, result, cv::noArray(), CV_8U);
  return result;
}

cv::Mat nothing_but_noise(cv::Size size, cv::RNG& random) {
  cv::Mat image(size, CV_8U);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

cv::Mat shifted(const cv::Mat& image, cv::Point by) {
  cv::Mat result = cv::Mat::zeros(image.size(), image.type());
  const cv::Rect all(cv::Point(), image.size()), seen = all & (all + by);
  if (!seen.empty()) image(seen - by).copyTo(result(seen));
  return result;
}

cv::Mat half_covered(const cv::Mat& image, Half half, int gray) {
  const int w = image.cols, h = image.rows;
  cv::Rect covered(0, 0, w, h);
  if (half == Half::kLeft || half == Half::kRight)
    covered.width = w / 2;
  else
    covered.height = h / 2;
  if (half == Half::kRight) covered.x = w - w / 2;
  if (half == Half::kBottom) covered.y = h - h / 2;
  cv::Mat result = image.clone();
  result(covered).setTo(gray);
  return result;
}

}  // namespace eifmap::test
