// One run of the mapper on a rendered case: what it said of every image, and every map that it
// published, next to the truth.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "degenerate/cases.h"
#include "map_view.h"
#include "sequence/tum.h"
#include "simulation/simulated_world.h"

namespace eifmap::test {

// A map as its users have it: the poses as published at the time, and its landmarks at last.
struct PublishedMap {
  std::int64_t id = 0;
  std::vector<TumPose> poses;
  std::map<std::int64_t, KeyframeView> keyframes;
  std::map<std::int64_t, LandmarkView> landmarks;
};

struct CaseRun {
  Camera camera;                                   // as the mapper was told
  std::vector<FrameResult> results;                // of all images
  std::vector<std::int64_t> keyframes, landmarks;  // in the map, after each image
  std::vector<PublishedMap> maps;                  // by id
  std::vector<TumPose> truth;
};

CaseRun run_case(const Case& which, const SimulatedWorld& world);

// How far a map is from the truth.
struct MapError {
  int poses = 0;
  double path = 0;   // m, true, from first to last pose
  double rmse = 0;   // m, of the poses after a similarity transform; 0: too few
  double scale = 0;  // true metres of a unit of the map; 0: too few poses
  int points = 0;    // landmarks that are on a surface in their anchor's image
  // Of the landmarks' depths in their anchors, next to the truth in their median's unit: the median
  // of the relative errors, and the share of those above 30 %.
  double depth_error = 0, wrong_points = 0;
};

MapError map_error(const PublishedMap& map, const SimulatedWorld& world, const CaseRun& run);

}  // namespace eifmap::test
