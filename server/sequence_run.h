// The mapper over recorded images, without a network.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "features/extractor.h"
#include "options.h"
#include "sequence/sequence_options.h"
#include "server/keyframe_worker.h"

namespace eifmap {

struct SequenceRunOptions {
  std::string sequence;  // open_source(); no live camera
  std::filesystem::path output;
  int every = 1;           // take every n-th image
  int first_frame = 0;     // image to begin with
  int max_frames = 0;      // of those taken; 0: all
  double jitter_px = 0;    // noise added to the keypoints
  std::uint64_t seed = 1;  // of the noise
  FeatureOptions features;
  MapperOptions mapper;
  Handover handover = {};  // kAtOnce or kAfterFrames
  // Of a live run: only its frames are taken, and what it decided by timing is decided alike.
  std::filesystem::path decisions = {};
  // Absolute measurements (sequence/measurements_file.h); with `decisions`, those of that run.
  std::filesystem::path measurements = {};
  // A map (storage/map_file.h) to begin with, and where to leave the one there is in the end.
  std::filesystem::path load_map = {}, save_map = {};
  SequenceOptions images = {};  // what is added to the images
};

// Called before each frame and at the end (done == total; of a video, total is what its head says
// until then, < 0 for unknown); false stops the run early, and what
// there is by then is written.
using Progress = std::function<bool(int done, int total)>;

// What had to be assumed about the images: a sentence for the user.
using Note = std::function<void(const std::string&)>;

// As fast as it can, in the caller's thread; the same input gives the same files, timings apart.
// Returns "" or what went wrong, also when not one image could be used or a replay of decisions
// came out otherwise. Throws std::invalid_argument on options out of range.
std::string run_sequence(const SequenceRunOptions& options, const Progress& progress,
                         const Note& note = {});

}  // namespace eifmap
