// The mapper over a recorded folder, without a network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "features/extractor.h"
#include "options.h"

namespace eifmap {

struct SequenceRunOptions {
  std::filesystem::path sequence;  // images/, times.txt, calib.json
  std::filesystem::path output;
  int every = 1;           // take every n-th image
  int max_frames = 0;      // of those taken; 0: all
  double jitter_px = 0;    // noise added to the keypoints
  std::uint64_t seed = 1;  // of the noise
  FeatureOptions features;
  MapperOptions mapper;
};

// Called before each frame and at the end (done == total); false stops the run early, and what
// there is by then is written.
using Progress = std::function<bool(int done, int total)>;

// As fast as it can, in the caller's thread; the same input gives the same files, timings apart.
// Returns "" or what went wrong. Throws std::invalid_argument on options out of range.
std::string run_sequence(const SequenceRunOptions& options, const Progress& progress);

}  // namespace eifmap
