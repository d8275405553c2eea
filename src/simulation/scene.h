// A world of textured rectangles. World: x east, y down, z north; the ground is y = 0; metres.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "simulation/texture.h"

namespace eifmap::simulation {

// How bright a surface is by itself (albedo, 0-1) at (x right, y down) metres from its top-left
// corner; must be defined a little beyond the borders, too.
using Painter = std::function<float(float x, float y)>;

// A one-sided rectangle. Seen from its front: origin at the top left, u to the right, v down; so
// the front's normal is v x u.
struct Quad {
  Eigen::Vector3d origin, u, v;  // u, v: edges, perpendicular, m
  Painter painter;
  double texels_per_m = 100;
  // The part with cut . (1, s, t) >= 0 is there, s and t in [0, 1] along u and v: half a gable.
  Eigen::Vector3d cut{1, 0, 0};
  bool lit = true;  // false: the painter gives the final brightness (the sky)

  Eigen::Vector3d normal() const { return v.cross(u).normalized(); }
};

// A quad, painted and lit.
struct Surface {
  Quad quad;
  Texture texture;
};

struct Sunlight {
  Eigen::Vector3d towards_sun{0.45, -0.75, -0.5};
  double sun = 0.9, sky = 0.62;  // brightness of a white surface in full sun is their sum
};

// Paints every quad, with shadows of the sun and the sky's light baked in. Deterministic; uses
// OpenCV's threads.
std::vector<Surface> paint(const std::vector<Quad>& quads, const Sunlight& light);

// The vertical sides and the top of a box that stands on `base` m above the ground.
struct Box {
  Eigen::Vector3d centre;  // of its foot
  double yaw = 0;          // rad, about the vertical
  Eigen::Vector3d size;    // along its x, height, along its z; m
  double texels_per_m = 100;
};
// `side(i)` for i = 0..3 (facing -z, +x, +z, -x at yaw 0) and i = 4, the top.
void add_box(std::vector<Quad>& quads, const Box& box, const std::function<Painter(int)>& side);

// An upright prism with eight sides (a pillar): `radius` to the middle of a side.
void add_pillar(std::vector<Quad>& quads, const Eigen::Vector3d& foot, double radius, double height,
                const std::function<Painter(int)>& side);

// A wall seen from the side its `facing` points to; `foot` is the middle of its lower edge.
Quad wall(const Eigen::Vector3d& foot, const Eigen::Vector3d& facing, double width, double height,
          Painter painter);

}  // namespace eifmap::simulation
