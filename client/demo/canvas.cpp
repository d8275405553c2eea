#include "client/demo/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace eifmap {
namespace {

cv::Scalar scalar(const Colour& c) {
  return cv::Scalar(c.blue, c.green, c.red);
}

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

// Hershey capitals are 21 units high at scale 1.
double font_scale(double pixels) {
  return pixels / 21.0;
}

int stroke(double pixels, bool bold) {
  return std::max(1, static_cast<int>(std::lround(pixels * (bold ? 0.16 : 0.1))));
}

}  // namespace

Colour blend(const Colour& a, const Colour& b, double share) {
  const auto mix = [share](int x, int y) {
    return static_cast<int>(std::lround(x + share * (y - x)));
  };
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue)};
}

Colour height_colour(double level) {
  static constexpr std::array<Colour, 5> kStops{
      {{72, 82, 190}, {42, 130, 190}, {46, 178, 152}, {140, 212, 96}, {250, 226, 110}}};
  const double at = std::clamp(level, 0.0, 1.0) * (kStops.size() - 1);
  const auto k = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  return blend(kStops[k], kStops[k + 1], at - static_cast<double>(k));
}

Canvas::Canvas(int width, int height, const Colour& background)
    : image_(kScale * height, kScale * width, CV_8UC3, scalar(background)),
      before_(image_.clone()) {}

cv::Point Canvas::fixed(const Eigen::Vector2d& p) const {
  // The middle of the finished picture's top-left pixel is (0, 0).
  const Eigen::Vector2d q = ((p.array() + 0.5) * kScale - 0.5).matrix() * (1 << kShift);
  return {static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y()))};
}

void Canvas::line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width,
                  const Colour& colour) {
  const int thickness = std::max(1, static_cast<int>(std::lround(kScale * width)));
  cv::line(image_, fixed(a), fixed(b), scalar(colour), thickness, cv::LINE_AA, kShift);
}

void Canvas::polyline(std::span<const Eigen::Vector2d> points, double width, const Colour& colour) {
  for (std::size_t i = 1; i < points.size(); ++i) line(points[i - 1], points[i], width, colour);
}

void Canvas::dashed(std::span<const Eigen::Vector2d> points, double width, double dash,
                    const Colour& colour) {
  double travelled = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d step = points[i] - points[i - 1];
    const double length = step.norm();
    for (double done = 0; done < length;) {
      const double phase = std::fmod(travelled + done, 2 * dash);
      const double until = std::min(length, done + (phase < dash ? dash : 2 * dash) - phase + 1e-6);
      if (phase < dash)
        line(points[i - 1] + step * (done / length), points[i - 1] + step * (until / length), width,
             colour);
      done = until;
    }
    travelled += length;
  }
}

void Canvas::disc(const Eigen::Vector2d& centre, double radius, const Colour& colour) {
  const int r = std::max(1, static_cast<int>(std::lround(kScale * radius * (1 << kShift))));
  cv::circle(image_, fixed(centre), r, scalar(colour), cv::FILLED, cv::LINE_AA, kShift);
}

void Canvas::polygon(std::span<const Eigen::Vector2d> corners, const Colour& colour) {
  std::vector<cv::Point> points;
  for (const Eigen::Vector2d& corner : corners) points.push_back(fixed(corner));
  cv::fillConvexPoly(image_, points, scalar(colour), cv::LINE_AA, kShift);
}

void Canvas::text(const std::string& text, const Eigen::Vector2d& at, double size,
                  const Colour& colour, bool bold) {
  const double pixels = kScale * size;
  const cv::Point origin(static_cast<int>(std::lround(kScale * at.x())),
                         static_cast<int>(std::lround(kScale * at.y())));
  cv::putText(image_, text, origin, kFont, font_scale(pixels), scalar(colour), stroke(pixels, bold),
              cv::LINE_AA);
}

double Canvas::text_width(const std::string& text, double size, bool bold) const {
  const double pixels = kScale * size;
  int base_line = 0;
  return cv::getTextSize(text, kFont, font_scale(pixels), stroke(pixels, bold), &base_line).width /
         static_cast<double>(kScale);
}

void Canvas::flatten(double opacity) {
  cv::addWeighted(image_, opacity, before_, 1 - opacity, 0, image_);
  image_.copyTo(before_);
}

cv::Mat Canvas::finished() const {
  cv::Mat small;
  cv::resize(image_, small, {}, 1.0 / kScale, 1.0 / kScale, cv::INTER_AREA);
  return small;
}

}  // namespace eifmap
