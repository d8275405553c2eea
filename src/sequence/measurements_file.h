// Absolute measurements as text, a JSON object a line:
//   {"kind": "position", "utime": US, "position": [X, Y, Z], "sigma": M}
//   {"kind": "distance", "utime": US, "utime2": US, "length": M, "sigma": M}
//   {"kind": "odometry", "utime": US, "utime2": US, "length": M, "sigma": M}
// A position may have a "covariance" of nine numbers, by rows, in the place of "sigma", and a
// "lever" [X, Y, Z]: where on the camera it is, in its frame.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absolute_measurement.h"

namespace eifmap {

struct MeasurementsFile {
  // By the time from which they can be used: a position's, the later of the two of a length.
  std::vector<AbsoluteMeasurement> measurements;
  std::string problem;  // "" or what is wrong, with file and line
};
MeasurementsFile read_measurements(const std::filesystem::path& file);

// When it can be used, as above.
std::int64_t usable_from_us(const AbsoluteMeasurement& measurement);

}  // namespace eifmap
