// Recorded folders as others lay them out. A layout is known by its files; one source file each.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "sequence/sequence_options.h"
#include "sequence/tum.h"

namespace eifmap {

// What a folder's files say. The images themselves are opened later.
struct Recording {
  std::vector<std::filesystem::path> images;
  std::vector<std::int64_t> times_us;  // of each image, increasing
  std::optional<Camera> camera;        // none: the folder has no calibration
  std::string calibration;             // what `camera` was read from
  std::vector<TumPose> ground_truth;   // of the camera, by time; may be empty
  std::vector<std::string> notes;      // sentences: what had to be assumed
  std::string problem;  // "" or which file and line, which value, and what to do; then the rest is
                        // not valid
};

struct Layout {
  const char* name;
  const char* files;  // what such a folder holds, for people
  // By names alone.
  bool (*recognizes)(const std::filesystem::path& folder);
  // The calibration is left alone where the options bring another.
  Recording (*read)(const std::filesystem::path& folder, const SequenceOptions& options);
};

extern const Layout kOwnLayout, kEurocLayout, kTumLayout, kKittiLayout, kImagesLayout;

// The one that a folder has, or nullptr.
const Layout* find_layout(const std::filesystem::path& folder);

// "images/, times.txt and calib.json (eifmap); ...": every layout there is.
std::string known_layouts();

// For layouts: the times of images that come without, at options.rate_hz or 10 Hz, with a note.
void assume_times(Recording& recording, const SequenceOptions& options);

// For layouts: times.txt, seconds, a line an image. Returns "" or what is wrong.
std::string read_times(const std::filesystem::path& file, Recording& recording);

// For layouts: calib.json where the folder has one.
void read_own_calibration(const std::filesystem::path& folder, Recording& recording);

// For layouts: a line an image, time and name, the name's folder being `folder`. Returns "" or what
// is wrong.
using AddTime = std::string (&)(const std::string& word, std::vector<std::int64_t>& times_us);
std::string read_image_list(const std::filesystem::path& list, const std::filesystem::path& folder,
                            AddTime add_time, Recording& recording);

}  // namespace eifmap
