#include "simulation/scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/utility.hpp>

#include "simulation/value_noise.h"

namespace eifmap::simulation {
namespace {

const Eigen::Vector3d kDown(0, 1, 0);
constexpr float kCircle = 2 * std::numbers::pi_v<float>;

// What a light ray needs to know of a quad.
struct Blocker {
  Eigen::Vector3f origin, normal, s_axis, t_axis, cut;  // s = s_axis . (x - origin), in [0, 1]
  Eigen::Vector3f centre;
  float radius;  // of the sphere around it

  explicit Blocker(const Quad& quad)
      : origin(quad.origin.cast<float>()),
        normal(quad.normal().cast<float>()),
        s_axis((quad.u / quad.u.squaredNorm()).cast<float>()),
        t_axis((quad.v / quad.v.squaredNorm()).cast<float>()),
        cut(quad.cut.cast<float>()),
        centre((quad.origin + 0.5 * (quad.u + quad.v)).cast<float>()),
        radius(static_cast<float>(0.5 * (quad.u + quad.v).norm())) {}

  bool hit(const Eigen::Vector3f& from, const Eigen::Vector3f& direction, float reach) const {
    const float along = normal.dot(direction);
    if (std::abs(along) < 1e-6f) return false;
    const float distance = normal.dot(origin - from) / along;
    if (distance <= 1e-3f || distance >= reach) return false;
    const Eigen::Vector3f x = from + distance * direction - origin;
    const float s = s_axis.dot(x), t = t_axis.dot(x);
    return s >= 0 && s <= 1 && t >= 0 && t <= 1 && cut.x() + cut.y() * s + cut.z() * t >= 0;
  }
};
using Blockers = std::vector<Blocker>;

bool any_hit(const Blockers& blockers, const Eigen::Vector3f& from,
             const Eigen::Vector3f& direction, float reach) {
  return std::any_of(blockers.begin(), blockers.end(),
                     [&](const Blocker& b) { return b.hit(from, direction, reach); });
}

// Directions over the half space around `normal`, cosine-weighted (the mean of what they see is the
// light of an even sky), turned by a random angle.
constexpr int kSkyRays = 16, kSunRays = 4;
constexpr float kSkyReach = 4, kSunReach = 60;  // m
constexpr float kSunRadius = 0.012f;            // rad; wide, for soft shadows
Eigen::Vector3f sky_ray(const Eigen::Vector3f& normal, int i, float turn) {
  const float radius = std::sqrt((static_cast<float>(i) + 0.5f) / kSkyRays);
  const float angle = 2.39996323f * static_cast<float>(i) + turn;
  const Eigen::Vector3f a = normal.unitOrthogonal(), b = normal.cross(a);
  return radius * (std::cos(angle) * a + std::sin(angle) * b) +
         std::sqrt(1 - radius * radius) * normal;
}

// The light on a quad, computed every 1/8 m and interpolated.
class LightMap {
 public:
  static constexpr double kPerMetre = 8;
  static constexpr int kTile = 8;  // texels that share the blockers to be asked

  LightMap(const Quad& quad, const Blockers& blockers, const Sunlight& light, std::uint32_t seed)
      : columns_(std::max(2, static_cast<int>(std::ceil(quad.u.norm() * kPerMetre)))),
        rows_(std::max(2, static_cast<int>(std::ceil(quad.v.norm() * kPerMetre)))),
        values_(static_cast<std::size_t>(columns_) * rows_),
        light_(light),
        sun_(light.towards_sun.normalized().cast<float>()),
        normal_(quad.normal().cast<float>()) {
    for (int y = 0; y < rows_; y += kTile)
      for (int x = 0; x < columns_; x += kTile) light_tile(quad, blockers, x, y, seed);
  }

  // s, t in [0, 1] along the quad's edges.
  float at(float s, float t) const {
    const float x = std::clamp(s * static_cast<float>(columns_) - 0.5f, 0.0f, columns_ - 1.001f);
    const float y = std::clamp(t * static_cast<float>(rows_) - 0.5f, 0.0f, rows_ - 1.001f);
    const int ix = static_cast<int>(x), iy = static_cast<int>(y);
    const float* p = &values_[static_cast<std::size_t>(iy) * columns_ + ix];
    const float u = x - static_cast<float>(ix), v = y - static_cast<float>(iy);
    return mix(mix(p[0], p[1], u), mix(p[columns_], p[columns_ + 1], u), v);
  }

 private:
  void light_tile(const Quad& quad, const Blockers& blockers, int x0, int y0, std::uint32_t seed) {
    const auto point = [&](double x, double y) -> Eigen::Vector3f {
      return (quad.origin + x / columns_ * quad.u + y / rows_ * quad.v + 1e-3 * quad.normal())
          .cast<float>();
    };
    const Eigen::Vector3f middle = point(x0 + kTile / 2, y0 + kTile / 2);
    const float radius = (point(x0, y0) - middle).norm();
    Blockers near, sunward;
    for (const Blocker& b : blockers) {
      const Eigen::Vector3f to_blocker = b.centre - middle;
      const float reach = b.radius + radius, along = to_blocker.dot(sun_);
      if (to_blocker.norm() < reach + kSkyReach) near.push_back(b);
      const float aside = (to_blocker - along * sun_).norm();
      if (along > -reach && aside < reach + 2 * kSunRadius * kSunReach) sunward.push_back(b);
    }
    for (int y = y0; y < std::min(y0 + kTile, rows_); ++y)
      for (int x = x0; x < std::min(x0 + kTile, columns_); ++x)
        values_[static_cast<std::size_t>(y) * columns_ + x] =
            light_at(point(x + 0.5, y + 0.5), near, sunward, hash_cell(x, y, seed));
  }

  float light_at(const Eigen::Vector3f& point, const Blockers& near, const Blockers& sunward,
                 std::uint32_t random) const {
    const float facing = std::max(0.0f, normal_.dot(sun_));
    const Eigen::Vector3f a = sun_.unitOrthogonal(), b = sun_.cross(a);
    int sun_seen = 0, sky_seen = 0;
    for (int i = 0; facing > 0 && i < kSunRays; ++i) {
      const float turn =
          kCircle * (static_cast<float>(i) + random_of_cell(i, 0, random)) / kSunRays;
      const Eigen::Vector3f ray = sun_ + kSunRadius * (std::cos(turn) * a + std::sin(turn) * b);
      sun_seen += !any_hit(sunward, point, ray.normalized(), kSunReach);
    }
    const float turn = kCircle * random_of_cell(1, 1, random);
    for (int i = 0; i < kSkyRays; ++i)
      sky_seen += !any_hit(near, point, sky_ray(normal_, i, turn), kSkyReach);
    const float openness = 0.75f - 0.25f * normal_.y();  // what looks down sees little sky
    return static_cast<float>(light_.sun) * facing * static_cast<float>(sun_seen) / kSunRays +
           static_cast<float>(light_.sky) * openness * static_cast<float>(sky_seen) / kSkyRays;
  }

  int columns_, rows_;
  std::vector<float> values_;
  Sunlight light_;
  Eigen::Vector3f sun_, normal_;
};

// As a camera's picture: shadows lifted, highlights bent towards white instead of being cut off.
std::uint8_t film_response(float brightness) {
  const float x = std::pow(brightness, 0.7f);
  const float y = x < 0.7f ? x : 0.7f + 0.28f * (1 - std::exp(-(x - 0.7f) / 0.28f));
  return static_cast<std::uint8_t>(std::min(255.0f, 255 * y + 0.5f));
}

std::uint8_t film(float brightness) {
  constexpr int kSteps = 4096;  // of 1/1024
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> values;
    for (int i = 0; i < kSteps; ++i) values.push_back(film_response(static_cast<float>(i) / 1024));
    return values;
  }();
  return table[std::clamp(static_cast<int>(brightness * 1024 + 0.5f), 0, kSteps - 1)];
}

void paint_surface(Surface& surface, const LightMap* light) {
  const Quad& quad = surface.quad;
  const auto metres = static_cast<float>(1 / quad.texels_per_m);
  const auto width = static_cast<float>(quad.u.norm()), height = static_cast<float>(quad.v.norm());
  for (int y = 0; y < surface.texture.height(); ++y) {
    std::uint8_t* row = surface.texture.row(y);
    const float ym = (static_cast<float>(y) + 0.5f) * metres;
    for (int x = 0; x < surface.texture.width(); ++x) {
      const float xm = (static_cast<float>(x) + 0.5f) * metres;
      row[x] = film(quad.painter(xm, ym) * (light ? light->at(xm / width, ym / height) : 1.0f));
    }
  }
  surface.texture.build_levels();
}

}  // namespace

std::vector<Surface> paint(const std::vector<Quad>& quads, const Sunlight& light) {
  Blockers blockers;
  std::vector<Surface> surfaces;
  for (const Quad& quad : quads) {
    if (quad.lit) blockers.emplace_back(quad);
    const auto texels = [&quad](double m) {
      return static_cast<int>(std::ceil(m * quad.texels_per_m));
    };
    surfaces.push_back({quad, Texture(texels(quad.u.norm()), texels(quad.v.norm()))});
  }
  const auto count = static_cast<int>(surfaces.size());
  cv::parallel_for_(
      cv::Range(0, count),
      [&](const cv::Range& range) {
        for (int i = range.start; i < range.end; ++i) {
          if (!quads[i].lit) {
            paint_surface(surfaces[i], nullptr);
            continue;
          }
          const LightMap map(quads[i], blockers, light, static_cast<std::uint32_t>(i));
          paint_surface(surfaces[i], &map);
        }
      },
      count);
  return surfaces;
}

Quad wall(const Eigen::Vector3d& foot, const Eigen::Vector3d& facing, double width, double height,
          Painter painter) {
  // The viewer looks along -facing with y down: x right = y down x z forward.
  const Eigen::Vector3d right = kDown.cross(-facing).normalized();
  Quad quad;
  quad.origin = foot - 0.5 * width * right - height * kDown;
  quad.u = width * right;
  quad.v = height * kDown;
  quad.painter = std::move(painter);
  return quad;
}

void add_box(std::vector<Quad>& quads, const Box& box, const std::function<Painter(int)>& side) {
  const Eigen::Vector3d x(std::cos(box.yaw), 0, std::sin(box.yaw)), z(-x.z(), 0, x.x());
  const double sx = box.size.x(), h = box.size.y(), sz = box.size.z();
  const Eigen::Vector3d facing[4] = {-z, x, z, -x};
  for (int i = 0; i < 4; ++i) {
    const double depth = i % 2 == 0 ? sz : sx, width = i % 2 == 0 ? sx : sz;
    quads.push_back(wall(box.centre + 0.5 * depth * facing[i], facing[i], width, h, side(i)));
    quads.back().texels_per_m = box.texels_per_m;
  }
  Quad top;
  top.u = sx * x;
  top.v = -sz * z;
  top.origin = box.centre - h * kDown - 0.5 * (top.u + top.v);
  top.painter = side(4);
  top.texels_per_m = box.texels_per_m;
  quads.push_back(top);
}

void add_pillar(std::vector<Quad>& quads, const Eigen::Vector3d& foot, double radius, double height,
                const std::function<Painter(int)>& side) {
  constexpr int kSides = 8;
  const double width = 2 * radius * std::tan(std::numbers::pi / kSides);
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSides;
    const Eigen::Vector3d facing(std::cos(angle), 0, std::sin(angle));
    quads.push_back(wall(foot + radius * facing, facing, width, height, side(i)));
  }
}

}  // namespace eifmap::simulation
