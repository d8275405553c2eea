// A picture of a run from above: points by height, the estimated path and its keyframes, the truth.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sequence/trajectory_error.h"

namespace eifmap {

struct TopViewData {
  std::string title;
  std::vector<std::string> notes;  // lines under the title
  std::vector<TumPose> path, keyframes;
  std::vector<MapPoint> points;
  std::vector<TumPose> truth;  // may be empty: then lengths are in units of the map
  Similarity truth_from_map;   // identity without a truth
};

cv::Mat draw_top_view(const TopViewData& data);  // CV_8UC3

}  // namespace eifmap
