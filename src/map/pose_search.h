// The search for one frame's pose: [WD10] Algorithm 1, steps 3-6, and what is left to try where it
// cannot give one.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "map/tracking.h"
#include "motion/triangulated_scale.h"

namespace eifmap {

// [WD10] Algorithm 1, step 4: matches whose keypoint in the keyframe is a landmark.
std::vector<LandmarkSight> landmarks_among(const Map& map, int keyframe,
                                           const std::vector<Match>& matches_m,
                                           const std::vector<Match>& matches_p = {});

// Within which landmarks are looked for, normalized image coordinates.
double search_radius(const Map& map, const MapperOptions& options);

// Two places explain the frame: `tracking` has one of them, and gives it up.
void refuse_as_ambiguous(const Tracking& other, Tracking& tracking);

// Where the camera may be, and how well that is known: of (w, dc), given the map.
struct Guess {
  Rigid3 world_from_camera;
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
};

// One frame's search for its pose: ways to a start, each of which the local map must confirm. What
// a way finds is in the Tracking that it is given.
class PoseSearch {
 public:
  PoseSearch(const Map& map, const ObservedFrame& observed, const LastMotion& last,
             const MapperOptions& options)
      : map_(map), observed_(observed), last_(last), options_(options) {}

  // [WD10] Algorithm 1 against one keyframe, then what is left to try with its matches.
  bool against(int reference, Tracking& tracking) const;
  bool by_pnp(const std::vector<LandmarkSight>& sights, PoseSource source,
              Tracking& tracking) const;
  // What was found far from where the camera was last must not be a copy of a place near it.
  void compare_with_nearer(Tracking& tracking) const;

 private:
  bool by_relative_pose(const std::vector<LandmarkSight>& sights, Tracking& tracking) const;
  bool along_line(const std::vector<LandmarkSight>& sights, Tracking& tracking) const;
  bool against_older(Tracking& tracking) const;
  bool by_map_alone(const std::vector<LandmarkSight>& sights, Tracking& tracking) const;

  Rigid3 guess_along_line(const Tracking& tracking) const;
  std::optional<Rigid3> place_along_line(PoseStart way, const std::vector<LandmarkSight>& sights,
                                         const Tracking& tracking) const;
  std::vector<SeenTwice> seen_twice(const std::vector<LandmarkSight>& sights, int keyframe) const;
  void relate_to(int keyframe, Tracking& tracking) const;
  bool from(const Rigid3& start, const std::vector<LandmarkSight>& sights, PoseSource source,
            Tracking& tracking) const;
  bool search_around(const Guess& guess, const std::vector<int>& landmarks,
                     Tracking& tracking) const;
  bool confirm(const Guess& guess, PoseSource source, Tracking& tracking) const;
  double share_found(const std::vector<int>& landmarks, const Rigid3& pose,
                     const std::vector<LandmarkSight>& sights) const;
  bool search_wider(const Guess& guess, const std::vector<int>& keyframes,
                    const std::vector<int>& local, Tracking& tracking) const;
  void take(const AbsolutePose& judged, const std::vector<LandmarkSight>& found,
            Tracking& tracking) const;

  const Map& map_;
  const ObservedFrame& observed_;
  const LastMotion& last_;
  const MapperOptions& options_;
};

}  // namespace eifmap
