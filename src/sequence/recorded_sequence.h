// A recorded folder, in any of the known layouts (layout.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "sequence/image_file.h"
#include "sequence/sequence_options.h"
#include "sequence/tum.h"

namespace eifmap {

class RecordedSequence {
 public:
  struct Opened;

  // Reads everything but the images, of which only the first, for its size. Bad data is no
  // exception: it comes back as a sentence that says which file and line, which value, and what to
  // do. Throws std::invalid_argument with options.problem().
  static Opened open(const std::filesystem::path& folder, const SequenceOptions& options = {});

  int size() const { return static_cast<int>(images_.size()); }
  const std::filesystem::path& folder() const { return folder_; }
  const Camera& camera() const { return camera_; }
  const std::vector<TumPose>& ground_truth() const { return ground_truth_; }  // may be empty
  const std::string& layout() const { return layout_; }                       // its name
  const std::vector<std::string>& notes() const { return notes_; }  // what had to be assumed

  // Of image i in [0, size()); another i throws std::out_of_range.
  std::int64_t time_us(int i) const { return times_us_.at(i); }  // rounded to the microsecond
  const std::filesystem::path& image_file(int i) const { return images_.at(i); }
  GrayImage load_gray(int i) const;   // a size other than the camera's is a problem, too
  FileBytes load_bytes(int i) const;  // e.g. a JPEG to publish without decoding it

 private:
  std::filesystem::path folder_;
  std::string layout_, calibration_;  // calibration_: what camera_ was read from
  Camera camera_;
  std::vector<std::filesystem::path> images_;
  std::vector<std::int64_t> times_us_;
  std::vector<TumPose> ground_truth_;
  std::vector<std::string> notes_;
};

struct RecordedSequence::Opened {
  std::optional<RecordedSequence> sequence;
  std::string problem;  // "" when there is a sequence
};

}  // namespace eifmap
