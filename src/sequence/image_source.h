// Where images come from, one after the other: a recorded folder, a video, a camera, or a simulated
// world.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sequence/recorded_sequence.h"

namespace eifmap {

// Images are asked for in the order of their numbers, and may be passed over. Going back makes a
// video start again and is not possible with a camera. Not for several threads at a time.
class ImageSource {
 public:
  static constexpr int kNoEnd = -1;

  virtual ~ImageSource() = default;

  virtual std::string name() const = 0;
  virtual std::string kind() const = 0;  // for people: "KITTI odometry", "video", ...
  // Images there are; of a video as its head says, which may be off; kNoEnd of a live camera.
  virtual int size() const = 0;
  virtual bool live() const { return false; }  // images come when the camera takes them
  virtual const Camera& camera() const = 0;
  virtual std::vector<TumPose> ground_truth() { return {}; }     // may be empty
  virtual std::vector<std::string> notes() const { return {}; }  // what had to be assumed

  // Whether there is an image i >= 0. Of a camera: waits for it.
  virtual bool has(int i) = 0;
  // Why has() gave no more images: "" at the end of the recording.
  virtual std::string problem() const { return ""; }

  // Of an image i that has(i).
  virtual std::int64_t time_us(int i) = 0;
  virtual GrayImage gray(int i) = 0;
  // The image as a JPEG file, where it is one already.
  virtual std::optional<FileBytes> jpeg(int) { return std::nullopt; }
};

std::unique_ptr<ImageSource> make_source(RecordedSequence sequence);

// The last part of a path that may end in '/' or '.'.
std::string last_name(const std::filesystem::path& path);

}  // namespace eifmap
