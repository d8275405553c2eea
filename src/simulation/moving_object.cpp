#include "simulation/moving_object.h"

#include <utility>

namespace eifmap::simulation {

MovingObject::MovingObject(const Camera& camera, const std::vector<Quad>& quads,
                           const Sunlight& light, Motion world_from_object)
    : surfaces_(paint(quads, light)),
      renderer_(camera, surfaces_),
      world_from_object_(std::move(world_from_object)) {}

void MovingObject::draw_into(Rendering& rendering, const Rigid3& world_from_camera,
                             double seconds) const {
  const Rendering object =
      renderer_.render(world_from_object_(seconds).inverse() * world_from_camera);
  const cv::Mat in_front = object.inverse_depth > rendering.inverse_depth;
  object.gray.copyTo(rendering.gray, in_front);
  object.inverse_depth.copyTo(rendering.inverse_depth, in_front);
}

}  // namespace eifmap::simulation
