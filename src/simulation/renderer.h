// Ray casting of painted surfaces into a calibrated camera: a depth buffer of inverse depths first
// (linear over a plane, so no division), then one filtered texture sample a pixel; only pixels
// where surfaces meet are sampled more finely.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "simulation/scene.h"

namespace eifmap::simulation {

struct Rendering {
  cv::Mat gray;           // CV_32FC1, 0-255, before noise and rounding
  cv::Mat inverse_depth;  // CV_32FC1, 1/m along the optical axis; 0 where nothing is
};

class Renderer {
 public:
  // `surfaces` must outlive it and stay where they are.
  Renderer(const Camera& camera, const std::vector<Surface>& surfaces);

  Rendering render(const Rigid3& world_from_camera) const;

 private:
  struct Step;    // how far a step of one pixel moves the ray
  struct View;    // a surface as the camera sees it
  struct Buffer;  // who is in front at each pixel

  void cast(const View& view, int index, Buffer& buffer) const;
  float shade(const View& view, int index, float x, float y, const Step& step) const;
  float shade_edge(const std::vector<View>& views, const Buffer& buffer, int column, int row) const;

  Camera camera_;
  const std::vector<Surface>& surfaces_;
  cv::Mat ray_x_, ray_y_;  // CV_32FC1: normalized coordinates of each pixel; NaN: no ray
  cv::Mat ray_step_;       // CV_32FC4: Step of each pixel
  // Bounds of the rays of each column (x) and row (y), to skip what a surface cannot reach.
  std::vector<float> column_low_, column_high_, row_low_, row_high_;
};

}  // namespace eifmap::simulation
