// Drawing with soft edges: everything is drawn at twice the size and scaled down in the end.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <span>
#include <string>

namespace eifmap {

// Red, green, blue, 0-255.
struct Colour {
  int red = 0, green = 0, blue = 0;
};

Colour blend(const Colour& a, const Colour& b, double share_of_b);

// 0 dark blue, over teal and green, to 1 pale yellow.
Colour height_colour(double level);

class Canvas {
 public:
  Canvas(int width, int height, const Colour& background);

  // Positions and sizes in pixels of the finished picture, from its top left.
  void line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width, const Colour& colour);
  void polyline(std::span<const Eigen::Vector2d> points, double width, const Colour& colour);
  void dashed(std::span<const Eigen::Vector2d> points, double width, double dash,
              const Colour& colour);
  void disc(const Eigen::Vector2d& centre, double radius, const Colour& colour);
  void polygon(std::span<const Eigen::Vector2d> corners, const Colour& colour);
  // `at`: left end of the base line. `size`: height of a capital.
  void text(const std::string& text, const Eigen::Vector2d& at, double size, const Colour& colour,
            bool bold = false);
  double text_width(const std::string& text, double size, bool bold = false) const;

  // Mixes what was drawn since the last call (or the start) into what was there before.
  void flatten(double opacity);

  cv::Mat finished() const;  // CV_8UC3, blue green red

 private:
  static constexpr int kScale = 2, kShift = 4;  // 1/16 px

  cv::Point fixed(const Eigen::Vector2d& p) const;

  cv::Mat image_, before_;
};

}  // namespace eifmap
