// Trajectories as TUM text, what evo and others read: `time[s] tx ty tz qx qy qz qw` a line, the
// camera's pose in the world.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "map_view.h"

namespace eifmap {

// As read: the time stays a double, since files of others are finer than a microsecond.
struct TumPose {
  double time_s = 0;
  Rigid3 world_from_camera;
};

struct TumTrajectory {
  std::vector<TumPose> poses;  // sorted by time
  std::string problem;         // "" or which file and line, and why
};

// Blanks or commas between numbers, comments after '#'. Lines with fewer than 8 numbers (the last
// one of a writer that was killed) and lines with nan or inf are passed over; a word that is no
// number is a problem.
TumTrajectory read_tum(const std::filesystem::path& file);

// One line without its end. Exact: the time with 9 decimals (the last three are 0), every other
// number with the fewest digits that read back as the same double. The same text everywhere, so
// that trajectories can be compared byte by byte.
std::string tum_line(const TimedPose& pose);

// Returns "" or what went wrong.
std::string write_tum(const std::filesystem::path& file, std::span<const TimedPose> poses);

}  // namespace eifmap
