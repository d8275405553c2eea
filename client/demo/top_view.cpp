#include "client/demo/top_view.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "client/demo/canvas.h"

namespace eifmap {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kWidth = 1600, kHeight = 1160, kMargin = 60, kHeader = 170, kFooter = 90;  // px
constexpr Colour kBackground{15, 19, 28}, kGrid{28, 34, 46}, kInk{226, 230, 238},
    kPale{140, 150, 168}, kPath{255, 140, 66}, kTruth{245, 247, 250}, kKeyframe{255, 196, 140};

// A point as seen from above, and how high it is.
struct Spot {
  Vector2d x;
  double height = 0;
};

// The directions of the picture: the cameras' mean down is down, the path's longest extent is to
// the right.
struct Frame {
  Vector3d right, up, height;  // in the truth's frame; `height` points to the viewer

  explicit Frame(const std::vector<Rigid3>& poses) {
    Vector3d down = Vector3d::Zero(), mean = Vector3d::Zero();
    for (const Rigid3& pose : poses) {
      down += pose.rotation * Vector3d::UnitY();
      mean += pose.translation / static_cast<double>(poses.size());
    }
    if (down.norm() < 1e-9) down = Vector3d::UnitY();
    height = -down.normalized();
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Rigid3& pose : poses) {
      const Vector3d d = pose.translation - mean;
      const Vector3d flat = d - d.dot(height) * height;
      spread += flat * flat.transpose();
    }
    right = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
    right -= right.dot(height) * height;
    if (right.norm() < 1e-6) right = height.unitOrthogonal();
    right.normalize();
    up = height.cross(right);
  }

  Spot spot(const Vector3d& x) const { return {{right.dot(x), up.dot(x)}, height.dot(x)}; }
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  const auto k = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}

struct Box {
  Vector2d low{1e300, 1e300}, high{-1e300, -1e300};

  void add(const Vector2d& x) { low = low.cwiseMin(x), high = high.cwiseMax(x); }
  bool holds(const Vector2d& x) const {
    return (x.array() >= low.array()).all() && (x.array() <= high.array()).all();
  }
  Vector2d size() const { return high - low; }
};

// The path and most of the points; far points would make the path small.
Box bounds(const std::vector<Spot>& paths, const std::vector<Spot>& points) {
  Box box;
  for (const Spot& spot : paths) box.add(spot.x);
  const double reach = 0.45 * std::max(box.size().maxCoeff(), 1e-6);
  Box limit{box.low.array() - reach, box.high.array() + reach};
  std::vector<double> x, y;
  for (const Spot& spot : points)
    if (limit.holds(spot.x)) x.push_back(spot.x.x()), y.push_back(spot.x.y());
  if (!x.empty()) {
    box.add({quantile(x, 0.01), quantile(y, 0.01)});
    box.add({quantile(x, 0.99), quantile(y, 0.99)});
  }
  const double rim = 0.03 * box.size().maxCoeff() + 1e-9;
  return {box.low.array() - rim, box.high.array() + rim};
}

// Metres (or map units) to pixels, the same scale both ways, centred in the space for it.
class View {
 public:
  explicit View(const Box& box) {
    const Vector2d space(kWidth - 2 * kMargin, kHeight - kHeader - kFooter);
    scale_ = (space.array() / box.size().array()).minCoeff();
    const Vector2d middle = 0.5 * (box.low + box.high);
    const Vector2d centre(0.5 * kWidth, kHeader + 0.5 * space.y());
    offset_ = centre - scale_ * Vector2d(middle.x(), -middle.y());
  }
  Vector2d operator()(const Vector2d& x) const {
    return scale_ * Vector2d(x.x(), -x.y()) + offset_;
  }
  double pixels_per_unit() const { return scale_; }
  bool shows(const Vector2d& pixel) const {
    return pixel.x() > kMargin / 2 && pixel.x() < kWidth - kMargin / 2 &&
           pixel.y() > kHeader - 20 && pixel.y() < kHeight - kFooter + 10;
  }

 private:
  double scale_ = 1;
  Vector2d offset_;
};

// 1, 2 or 5 times a power of ten, not above `length`.
double round_length(double length) {
  const double power = std::pow(10, std::floor(std::log10(length)));
  for (double step : {5.0, 2.0})
    if (step * power <= length) return step * power;
  return power;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", value);
  return text;
}

void draw_grid(Canvas& canvas, const View& view) {
  const double step = round_length(160 / view.pixels_per_unit()) * view.pixels_per_unit();
  const Vector2d origin = view(Vector2d::Zero());
  const double top = kHeader - 20, bottom = kHeight - kFooter + 10;
  for (double x = std::fmod(origin.x(), step); x < kWidth - kMargin / 2; x += step)
    if (x > kMargin / 2) canvas.line({x, top}, {x, bottom}, 1, kGrid);
  for (double y = std::fmod(origin.y(), step); y < bottom; y += step)
    if (y > top) canvas.line({kMargin / 2, y}, {kWidth - kMargin / 2, y}, 1, kGrid);
  canvas.flatten(1);
}

// Low ones first, so that walls stand over the ground.
void draw_points(Canvas& canvas, const View& view, std::vector<Spot> points) {
  std::sort(points.begin(), points.end(),
            [](const Spot& a, const Spot& b) { return a.height < b.height; });
  std::vector<double> heights;
  for (const Spot& spot : points)
    if (view.shows(view(spot.x))) heights.push_back(spot.height);
  const double low = quantile(heights, 0.03), high = quantile(heights, 0.97);
  for (const Spot& spot : points) {
    const Vector2d pixel = view(spot.x);
    if (view.shows(pixel))
      canvas.disc(pixel, 2.1, height_colour((spot.height - low) / std::max(high - low, 1e-9)));
  }
  canvas.flatten(0.85);
}

// An arrow from the camera's centre to where it looked.
void draw_keyframe(Canvas& canvas, const Vector2d& at, Vector2d ahead) {
  if (ahead.norm() < 1e-9) ahead = Vector2d::UnitX();
  ahead = 13 * ahead.normalized();
  const Vector2d aside(-0.4 * ahead.y(), 0.4 * ahead.x());
  const Vector2d corners[] = {at + ahead, at + aside, at - aside};
  canvas.polygon(corners, kKeyframe);
}

double draw_legend_entry(Canvas& canvas, double right, double y, const std::string& text,
                         int kind) {
  const double left = right - canvas.text_width(text, 14);
  canvas.text(text, {left, y}, 14, kInk);
  const Vector2d from(left - 50, y - 6), to(left - 12, y - 6), ends[] = {from, to};
  if (kind == 0) canvas.polyline(ends, 3, kPath);
  if (kind == 1) canvas.dashed(ends, 1.5, 6, kTruth);
  if (kind == 2) draw_keyframe(canvas, {left - 37, y - 6}, {1, 0});
  if (kind == 3)
    for (int i = 0; i < 36; ++i)
      canvas.line({left - 50 + i, y - 12}, {left - 50 + i, y}, 1, height_colour(i / 35.0));
  return left - 50;
}

void draw_words(Canvas& canvas, const TopViewData& data, const View& view) {
  canvas.text(data.title, {kMargin, 72}, 30, kInk, true);
  double y = 108;
  for (const std::string& note : data.notes) {
    canvas.text(note, {kMargin, y}, 14, kPale);
    y += 27;
  }
  const double right = kWidth - kMargin;
  draw_legend_entry(canvas, right, 50, "estimated path", 0);
  if (!data.truth.empty()) draw_legend_entry(canvas, right, 78, "true path", 1);
  draw_legend_entry(canvas, right, 106, "keyframes", 2);
  draw_legend_entry(canvas, right, 134, "points, low to high", 3);

  const double length = round_length(260 / view.pixels_per_unit());
  const double pixels = length * view.pixels_per_unit();
  const Vector2d left(kMargin, kHeight - 42), end = left + Vector2d(pixels, 0);
  canvas.line(left, end, 2, kInk);
  for (const Vector2d& tick : {left, end})
    canvas.line(tick - Vector2d(0, 7), tick + Vector2d(0, 7), 2, kInk);
  canvas.text(number(length) + (data.truth.empty() ? " map units" : " m"), end + Vector2d(14, 6),
              14, kInk);
  const std::string from = "seen from above";
  canvas.text(from, {right - canvas.text_width(from, 14), kHeight - 36}, 14, kPale);
}

}  // namespace

cv::Mat draw_top_view(const TopViewData& data) {
  std::vector<Rigid3> path, keyframes;
  const auto moved = [&data](const Rigid3& pose) -> Rigid3 {
    return {Eigen::Quaterniond(data.truth_from_map.rotation) * pose.rotation,
            data.truth_from_map * pose.translation};
  };
  for (const TumPose& pose : data.path) path.push_back(moved(pose.world_from_camera));
  for (const TumPose& pose : data.keyframes) keyframes.push_back(moved(pose.world_from_camera));
  std::vector<Rigid3> all = path;
  for (const TumPose& pose : data.truth) all.push_back(pose.world_from_camera);
  if (all.empty()) all.emplace_back();

  const Frame frame(all);
  std::vector<Spot> paths, points;
  for (const Rigid3& pose : all) paths.push_back(frame.spot(pose.translation));
  for (const MapPoint& point : data.points)
    points.push_back(frame.spot(data.truth_from_map * point.position));
  const View view(bounds(paths, points));
  const auto pixel = [&](const Vector3d& x) { return view(frame.spot(x).x); };
  std::vector<Vector2d> estimated, truth;
  for (const Rigid3& pose : path) estimated.push_back(pixel(pose.translation));
  for (const TumPose& pose : data.truth) truth.push_back(pixel(pose.world_from_camera.translation));

  Canvas canvas(kWidth, kHeight, kBackground);
  draw_grid(canvas, view);
  draw_points(canvas, view, std::move(points));
  for (const Rigid3& pose : keyframes) {
    const Vector3d ahead = pose.rotation * Vector3d::UnitZ();
    draw_keyframe(canvas, pixel(pose.translation), {frame.right.dot(ahead), -frame.up.dot(ahead)});
  }
  canvas.flatten(0.7);
  canvas.polyline(estimated, 3, kPath);
  canvas.dashed(truth, 1.5, 7, kTruth);
  if (!estimated.empty()) canvas.disc(estimated.front(), 6, kPath);
  draw_words(canvas, data, view);
  return canvas.finished();
}

}  // namespace eifmap
