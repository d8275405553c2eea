// Our features beside OpenCV's on the same pairs of views of known homography.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "features/pair_figures.h"

namespace eifmap::testing {

enum class Method { kSurfUpright, kSurfOriented, kSift, kOpenCvAkaze, kOpenCvSift };

inline constexpr std::array kMethods{Method::kSurfUpright, Method::kSurfOriented, Method::kSift,
                                     Method::kOpenCvAkaze, Method::kOpenCvSift};

std::string name(Method method);

// What makes the second view differ from the first.
struct Change {
  std::string name;
  double turn_deg = 0, zoom = 1;
  double tilt = 0;     // of the perspective, 1/px
  double blur_px = 0;  // sigma
  double gain = 1;     // contrast around mid grey
  double noise = 1.5;  // grey values, of both views
};

std::vector<Change> changes();

struct Row {
  Change change;
  std::array<PairFigures, kMethods.size()> of;  // summed over pairs
  std::array<int, kMethods.size()> features;    // in the first views, per view
};

// One row per change, over `pairs` textures. A pure function of them.
std::vector<Row> measure_quality(int pairs);

}  // namespace eifmap::testing
