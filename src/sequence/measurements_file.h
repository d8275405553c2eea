// Absolute measurements as text, a JSON object a line:
//   {"kind": "position", "utime": US, "position": [X, Y, Z], "sigma": M}
//   {"kind": "distance", "utime": US, "utime2": US, "length": M, "sigma": M}
//   {"kind": "odometry", "utime": US, "utime2": US, "length": M, "sigma": M}
//   {"kind": "gravity", "utime": US, "down": [X, Y, Z], "sigma": RAD}
//   {"kind": "landmarks", "utime": US, "map": ID, "a": ID, "b": ID, "length": M, "sigma": M}
// A position may have a "covariance" of nine numbers, by rows, in the place of "sigma", and a
// "lever" [X, Y, Z]: where on the camera it is, in its frame. "down" is in the camera's frame, of
// any length but 0. Landmarks have the ids of map updates, and are in the map by the time. What a
// server and a log write has its name, too, "publisher" and "seq"; without, publisher is 0 and seq
// counts the lines from 0.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "absolute_measurement.h"

namespace eifmap {

// Without the line's end: what is read back is the same to the bit.
std::string line_of(const AbsoluteMeasurement& measurement);

struct MeasurementsFile {
  // By the time from which they can be used: the later one where there are two.
  std::vector<AbsoluteMeasurement> measurements;
  std::string problem;  // "" or what is wrong, with file and line
};
MeasurementsFile read_measurements(const std::filesystem::path& file);

}  // namespace eifmap
