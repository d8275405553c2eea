// How large the errors of sights really are, against what their keypoints say.
#pragma once

#include "filter/information_filter.h"
#include "options.h"

namespace eifmap {

// A keypoint's sigma is that of its place in one image. What else moves a blob from where a map
// expects it, another side of it, a calibration that is a little off, a shutter that reads line by
// line, is in no single image, and differs from camera to camera: told too small a sigma, the
// filter throws out the sights that would hold its scale. On a hand-held recording that was a
// quarter of all, and in one run of three a part of the map came out at another scale.
//
// So one factor for all of a map's sights follows what each keyframe's show when it enters. It
// never falls below MapperOptions::sigma_factor: small residuals may also mean that a track's
// errors resemble each other (sight_correlation.h).
struct NoiseBooks {
  double factor = 1, estimate = 1;
  int keyframes = 0;
};

class SightNoise {
 public:
  explicit SightNoise(const MapperOptions& options);

  // For a map that is kept in a file.
  NoiseBooks books() const { return {factor_, estimate_, keyframes_}; }
  void restore(const NoiseBooks& books) {
    factor_ = books.factor;
    estimate_ = books.estimate;
    keyframes_ = books.keyframes;
  }

  // What sigmas of keypoints are to be multiplied by.
  double factor() const { return factor_; }

  // Of an update after a new keyframe. Returns what factor() is multiplied by: 1 mostly, for a
  // change has all sights looked at again.
  double follow(const FilterUpdate& update);

  // One of two maps that become one: the larger holds for both, since too small a sigma is what
  // costs a map. Returns what factor() is multiplied by.
  double include(const SightNoise& other);

 private:
  double least_, largest_;
  double factor_;
  double estimate_;  // of the factor
  int keyframes_ = 0;
};

}  // namespace eifmap
