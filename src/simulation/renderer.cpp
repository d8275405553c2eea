#include "simulation/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace eifmap::simulation {
namespace {

constexpr float kBackground = 226;  // the sky where the world ends
constexpr double kNear = 0.05;      // m

// A function of the ray (x, y, 1), linear in x and y.
struct Linear {
  float x = 0, y = 0, one = 0;

  Linear() = default;
  explicit Linear(const Eigen::Vector3d& v)
      : x(static_cast<float>(v.x())),
        y(static_cast<float>(v.y())),
        one(static_cast<float>(v.z())) {}
  float operator()(float rx, float ry) const { return x * rx + y * ry + one; }
};

// The corners in front of the camera, the polygon cut at the near plane.
std::vector<Eigen::Vector3d> clipped_corners(const std::array<Eigen::Vector3d, 4>& corners) {
  std::vector<Eigen::Vector3d> kept;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d &a = corners[i], &b = corners[(i + 1) % 4];
    if (a.z() >= kNear) kept.push_back(a);
    if ((a.z() >= kNear) != (b.z() >= kNear))
      kept.push_back(a + (kNear - a.z()) / (b.z() - a.z()) * (b - a));
  }
  return kept;
}

}  // namespace

// With X = z ray on the plane normal . X = distance, 1/z = normal . ray / distance, and s / z and
// t / z (texels) are linear in the ray as well.
struct Renderer::View {
  bool visible = false;
  Linear inverse_depth, s, t, cut;
  float width = 0, height = 0;                         // texels
  float x_low = 0, x_high = 0, y_low = 0, y_high = 0;  // bounds, normalized coordinates

  View(const Quad& quad, const Rigid3& camera_from_world) {
    const Eigen::Vector3d origin = camera_from_world * quad.origin;
    const Eigen::Vector3d u = camera_from_world.rotation * quad.u;
    const Eigen::Vector3d v = camera_from_world.rotation * quad.v;
    const Eigen::Vector3d normal = v.cross(u).normalized();
    const double distance = normal.dot(origin);
    if (distance > -1e-3) return;  // seen from behind, or edge-on
    const auto corners = clipped_corners({origin, origin + u, origin + u + v, origin + v});
    if (corners.empty()) return;
    visible = true;
    x_low = y_low = std::numeric_limits<float>::max();
    x_high = y_high = std::numeric_limits<float>::lowest();
    for (const Eigen::Vector3d& corner : corners) {
      const auto x = static_cast<float>(corner.x() / corner.z());
      const auto y = static_cast<float>(corner.y() / corner.z());
      x_low = std::min(x_low, x), x_high = std::max(x_high, x);
      y_low = std::min(y_low, y), y_high = std::max(y_high, y);
    }
    const double scale = quad.texels_per_m;
    const Eigen::Vector3d n = normal / distance;
    const auto coordinate = [&](const Eigen::Vector3d& edge) -> Eigen::Vector3d {
      const Eigen::Vector3d axis = scale * edge.normalized();
      return axis - axis.dot(origin) * n;
    };
    const Eigen::Vector3d s_of = coordinate(u), t_of = coordinate(v);
    width = static_cast<float>(scale * u.norm());
    height = static_cast<float>(scale * v.norm());
    inverse_depth = Linear(n);
    s = Linear(s_of);
    t = Linear(t_of);
    cut = Linear(quad.cut[0] * n + quad.cut[1] / width * s_of + quad.cut[2] / height * t_of);
  }

  // 1/z where the ray meets the surface in front of the camera, else 0.
  float hit(float x, float y) const {
    const float iz = inverse_depth(x, y), s_iz = s(x, y), t_iz = t(x, y);
    const bool inside =
        s_iz >= 0 && s_iz <= width * iz && t_iz >= 0 && t_iz <= height * iz && cut(x, y) >= 0;
    return inside ? iz : 0.0f;
  }
};

// In units of 1/fx and 1/fy, so that a pinhole's are exactly 1 0 0 1.
struct Renderer::Step {
  float x_right, y_right, x_down, y_down;
};

struct Renderer::Buffer {
  cv::Mat inverse_depth, index;  // CV_32FC1; CV_32SC1, -1: nothing

  explicit Buffer(const Camera& camera)
      : inverse_depth(camera.height, camera.width, CV_32FC1, cv::Scalar(0)),
        index(camera.height, camera.width, CV_32SC1, cv::Scalar(-1)) {}
};

Renderer::Renderer(const Camera& camera, const std::vector<Surface>& surfaces)
    : camera_(camera),
      surfaces_(surfaces),
      ray_x_(camera.height, camera.width, CV_32FC1),
      ray_y_(camera.height, camera.width, CV_32FC1),
      ray_step_(camera.height, camera.width, CV_32FC4),
      column_low_(camera.width, std::numeric_limits<float>::max()),
      column_high_(camera.width, std::numeric_limits<float>::lowest()),
      row_low_(camera.height, std::numeric_limits<float>::max()),
      row_high_(camera.height, std::numeric_limits<float>::lowest()) {
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector2d exact_ray = camera.normalized_from_pixel({column, row});
      const Eigen::Vector2f ray = exact_ray.cast<float>();
      const Eigen::Matrix2d step = camera.normalized_jacobian(exact_ray) *
                                   Eigen::Vector2d(camera.fx, camera.fy).asDiagonal();
      const Eigen::Matrix2f rounded = step.cast<float>();
      ray_step_.ptr<Step>(row)[column] = {rounded(0, 0), rounded(1, 0), rounded(0, 1),
                                          rounded(1, 1)};
      ray_x_.at<float>(row, column) = ray.x();
      ray_y_.at<float>(row, column) = ray.y();
      column_low_[column] = std::min(column_low_[column], ray.x());
      column_high_[column] = std::max(column_high_[column], ray.x());
      row_low_[row] = std::min(row_low_[row], ray.y());
      row_high_[row] = std::max(row_high_[row], ray.y());
    }
  }
}

void Renderer::cast(const View& view, int index, Buffer& buffer) const {
  int first = 0, end = camera_.width;
  while (first < end && column_high_[first] < view.x_low) ++first;
  while (end > first && column_low_[end - 1] > view.x_high) --end;
  const Linear &iz = view.inverse_depth, &s = view.s, &t = view.t, &cut = view.cut;
  for (int row = 0; row < camera_.height; ++row) {
    if (row_high_[row] < view.y_low || row_low_[row] > view.y_high) continue;
    const float *x = ray_x_.ptr<float>(row), *y = ray_y_.ptr<float>(row);
    float* nearest = buffer.inverse_depth.ptr<float>(row);
    int* who = buffer.index.ptr<int>(row);
    for (int c = first; c < end; ++c) {  // no branches: the compiler makes vectors of it
      const float inverse = iz(x[c], y[c]), s_iz = s(x[c], y[c]), t_iz = t(x[c], y[c]);
      const bool seen = (inverse > nearest[c]) & (s_iz >= 0) & (s_iz <= view.width * inverse) &
                        (t_iz >= 0) & (t_iz <= view.height * inverse) & (cut(x[c], y[c]) >= 0);
      nearest[c] = seen ? inverse : nearest[c];
      who[c] = seen ? index : who[c];
    }
  }
}

float Renderer::shade(const View& view, int index, float x, float y, const Step& step) const {
  const float z = 1 / view.inverse_depth(x, y);
  const float s = view.s(x, y) * z, t = view.t(x, y) * z;
  // d(s/1)/dx of s = (s . ray) / (n . ray), for one pixel's step of the ray.
  const float dx = z / static_cast<float>(camera_.fx), dy = z / static_cast<float>(camera_.fy);
  const float s_x = view.s.x - s * view.inverse_depth.x, t_x = view.t.x - t * view.inverse_depth.x;
  const float s_y = view.s.y - s * view.inverse_depth.y, t_y = view.t.y - t * view.inverse_depth.y;
  const Texture::Footprint footprint{(s_x * step.x_right + s_y * step.y_right) * dx,
                                     (t_x * step.x_right + t_y * step.y_right) * dx,
                                     (s_x * step.x_down + s_y * step.y_down) * dy,
                                     (t_x * step.x_down + t_y * step.y_down) * dy};
  return surfaces_[index].texture.sample(s, t, footprint);
}

// Where surfaces meet, eight samples say how much of the pixel each covers; each is then shaded
// once, in the middle of its part.
float Renderer::shade_edge(const std::vector<View>& views, const Buffer& buffer, int column,
                           int row) const {
  constexpr int kSamples = 8;
  constexpr float kOffset[kSamples][2] = {
      {-0.4375f, -0.0625f}, {-0.3125f, 0.3125f}, {-0.1875f, -0.3125f}, {-0.0625f, 0.0625f},
      {0.0625f, 0.4375f},   {0.1875f, -0.4375f}, {0.3125f, 0.1875f},   {0.4375f, -0.1875f}};
  std::array<int, 9> candidates;
  int count = 0;
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, camera_.height - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, camera_.width - 1); ++c) {
      const int index = buffer.index.at<int>(r, c);
      const auto end = candidates.begin() + count;
      if (index >= 0 && std::find(candidates.begin(), end, index) == end)
        candidates[count++] = index;
    }
  }
  struct Part {
    float x = 0, y = 0;
    int samples = 0;
  };
  std::array<Part, 9> parts{};
  const float ray_x = ray_x_.at<float>(row, column), ray_y = ray_y_.at<float>(row, column);
  const Step step = ray_step_.ptr<Step>(row)[column];
  for (const auto& offset : kOffset) {
    const float right = offset[0] / static_cast<float>(camera_.fx);
    const float down = offset[1] / static_cast<float>(camera_.fy);
    const float x = ray_x + (step.x_right * right + step.x_down * down);
    const float y = ray_y + (step.y_right * right + step.y_down * down);
    int front = -1;
    float nearest = 0;
    for (int k = 0; k < count; ++k) {
      const float inverse = views[candidates[k]].hit(x, y);
      if (inverse > nearest) nearest = inverse, front = k;
    }
    if (front < 0) continue;
    parts[front].x += x, parts[front].y += y, ++parts[front].samples;
  }
  float sum = 0;
  int covered = 0;
  for (int k = 0; k < count; ++k) {
    if (parts[k].samples == 0) continue;
    const auto n = static_cast<float>(parts[k].samples);
    sum += n * shade(views[candidates[k]], candidates[k], parts[k].x / n, parts[k].y / n, step);
    covered += parts[k].samples;
  }
  return (sum + static_cast<float>(kSamples - covered) * kBackground) / kSamples;
}

Rendering Renderer::render(const Rigid3& world_from_camera) const {
  const Rigid3 camera_from_world = world_from_camera.inverse();
  std::vector<View> views;
  views.reserve(surfaces_.size());
  Buffer buffer(camera_);
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    views.emplace_back(surfaces_[i].quad, camera_from_world);
    if (views[i].visible) cast(views[i], static_cast<int>(i), buffer);
  }
  Rendering rendering{cv::Mat(camera_.height, camera_.width, CV_32FC1), buffer.inverse_depth};
  for (int row = 0; row < camera_.height; ++row) {
    const int* who = buffer.index.ptr<int>(row);
    const int* above = buffer.index.ptr<int>(std::max(row - 1, 0));
    const int* below = buffer.index.ptr<int>(std::min(row + 1, camera_.height - 1));
    const float *x = ray_x_.ptr<float>(row), *y = ray_y_.ptr<float>(row);
    const Step* step = ray_step_.ptr<Step>(row);
    float* gray = rendering.gray.ptr<float>(row);
    for (int c = 0; c < camera_.width; ++c) {
      const int left = who[std::max(c - 1, 0)], right = who[std::min(c + 1, camera_.width - 1)];
      if (who[c] != left || who[c] != right || who[c] != above[c] || who[c] != below[c])
        gray[c] = shade_edge(views, buffer, c, row);
      else
        gray[c] = who[c] < 0 ? kBackground : shade(views[who[c]], who[c], x[c], y[c], step[c]);
    }
  }
  return rendering;
}

}  // namespace eifmap::simulation
