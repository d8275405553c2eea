// Absolute measurements made from the truth, with noise of a known size.
#pragma once

#include <cstdint>
#include <vector>

#include "absolute_measurement.h"
#include "consistency/frame_source.h"

namespace eifmap::test {

struct MeasurementSource {
  double gps_sigma = 0;       // m, each axis; 0: no positions
  int gps_every = 3;          // frames
  double distance_sigma = 0;  // of the distance; 0: none
  // Which distance: between the places of these shares of the frames.
  double distance_from = 0.05, distance_to = 0.3;
};

// Where the truth's world lies for the positions: anywhere, turned anyhow.
Rigid3 earth_from_world(int seed);

// By time. Frames without a true pose have none.
std::vector<AbsoluteMeasurement> make_measurements(const FrameSource& source,
                                                   const MeasurementSource& options, int seed);

}  // namespace eifmap::test
