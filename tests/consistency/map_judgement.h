// The map at the end of a run against the truth: its landmarks, its keyframes to each other, its
// scale.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "consistency/frame_source.h"
#include "map_view.h"
#include "mapper.h"

namespace eifmap::test {

// What a landmark is a picture of: the point that most of its sights are of. Some are of others.
class LandmarkPoints {
 public:
  void add(const FrameSource& source, const MapUpdate& update);
  std::optional<Eigen::Vector3d> operator()(const FrameSource& source, std::int64_t landmark) const;

 private:
  std::map<std::int64_t, std::int64_t> times_;         // us, by keyframe
  std::map<std::int64_t, std::map<int, int>> counts_;  // by landmark and point
};

// The truth in the frame and the unit of what is judged.
using TruePose = std::function<std::optional<Rigid3>(std::int64_t time_us)>;
using TruePoint = std::function<std::optional<Eigen::Vector3d>(std::int64_t landmark)>;

// Normalized errors squared: 3 each on average.
std::vector<double> judge_landmarks(const Mapper& mapper, const TruePoint& truth);
std::vector<double> judge_landmarks(const EarthView& view, const TruePoint& truth);

// Of keyframes to the one `apart` before them, and in earth: 6 each. Not of the first two to each
// other, whose distance is the unit.
std::vector<double> judge_relative(const Mapper& mapper, const TruePose& truth, std::size_t apart);
std::vector<double> judge_keyframes(const EarthView& view, const TruePose& truth);

// What the logarithm of the scale is off by, as the latest `count` keyframes show it (0: all).
std::optional<double> log_scale_error(const std::vector<KeyframeView>& keyframes,
                                      const TruePose& truth, std::size_t count);

}  // namespace eifmap::test
