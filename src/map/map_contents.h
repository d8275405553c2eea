// What a map is made of, without what follows from it: what a file keeps.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "map/map.h"

namespace eifmap {

struct MapContents {
  struct OfKeyframe {
    std::shared_ptr<const ObservedFrame> frame;  // null of a removed one
    Rigid3 pose;
    // Of a removed one; and of all, the time of the image, us, and the map's sign.
    int carrier = -1;
    Rigid3 carrier_from_this;
    std::int64_t time_us = 0;
  };
  struct OfTrack {
    int number = 0;
    std::vector<Sight> sights;  // as Track's
    bool is_landmark = false;
    Eigen::Vector3d position = Eigen::Vector3d::Zero();  // of a landmark
  };
  struct OfEdge {
    int i = 0, j = 0;
    RelativePoseMeasurement measurement;
  };

  MapSign map_sign = MapSign::kMinus;
  std::vector<OfKeyframe> keyframes;
  int num_tracks = 0;                // removed ones too
  std::vector<OfTrack> tracks;       // those that are left, by number ascending
  std::vector<OfEdge> filter_edges;  // that the filter holds
  std::vector<MapEdge> edges;        // that have used measurements
  FilterBooks filter;
  // Landmarks are those of tracks, -1 or the track, here.
  std::vector<AbsoluteObservation> absolutes;
  NoiseBooks noise;
  MapScale scale;
  int num_bends = 0;
  PlaceBooks places;
};

// "" or what is wrong with it, which of what: numbers that do not fit each other, or are none.
std::string problem_of(const MapContents& contents);

// The map as it was: poses and positions to the bit, covariances those of measurements that are all
// linearized there. Null where problem_of() has something to say or the filter cannot be had.
std::shared_ptr<Map> restore_map(MapContents contents, const Camera& camera,
                                 const MapperOptions& options);

}  // namespace eifmap
