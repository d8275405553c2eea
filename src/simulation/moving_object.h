// Something that moves through a rendered world: drawn by itself, and put over what is farther
// away.
#pragma once

#include <vector>

#include "geometry/camera.h"
#include "simulation/motion.h"
#include "simulation/renderer.h"

namespace eifmap::simulation {

class MovingObject {
 public:
  // `quads` in the object's own frame, lit by themselves; `world_from_object` by the time.
  MovingObject(const Camera& camera, const std::vector<Quad>& quads, const Sunlight& light,
               Motion world_from_object);

  // Into a picture of the world that the same camera has taken from there, `seconds` on the way.
  void draw_into(Rendering& rendering, const Rigid3& world_from_camera, double seconds) const;

 private:
  std::vector<Surface> surfaces_;
  Renderer renderer_;
  Motion world_from_object_;

  MovingObject(const MovingObject&) = delete;  // renderer_ refers to surfaces_
  MovingObject& operator=(const MovingObject&) = delete;
};

}  // namespace eifmap::simulation
