// A recorded folder: images/ in name order, times.txt (seconds, a line an image), calib.json, and
// groundtruth.tum when there is one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "sequence/tum.h"

namespace eifmap {

// A decoded image, or what is wrong with the file.
struct GrayImage {
  cv::Mat image;        // CV_8UC1; empty when there is a problem
  std::string problem;  // "" or a sentence
};

// A file's bytes as they are, or why they cannot be read.
struct FileBytes {
  std::vector<std::uint8_t> bytes;
  std::string problem;
};

// calib.json: width, height, fx, fy, cx, cy (px), model ("pinhole", "radial_tangential", "fisheye";
// none: by the distortion) and distortion (k1 k2 p1 p2 k3, of a fisheye k1 k2 k3 k4, OpenCV's
// orders; all zero, or none: a pinhole). Keys that are not known are passed over.
struct CameraFile {
  Camera camera;
  std::string problem;
};
CameraFile read_camera(const std::filesystem::path& file);

class RecordedSequence {
 public:
  struct Opened;

  // Reads everything but the images. Bad data is no exception: it comes back as a sentence that
  // says which file, which value, and what to do.
  static Opened open(const std::filesystem::path& folder);

  int size() const { return static_cast<int>(images_.size()); }
  const std::filesystem::path& folder() const { return folder_; }
  const Camera& camera() const { return camera_; }
  const std::vector<TumPose>& ground_truth() const { return ground_truth_; }  // may be empty

  // Of image i in [0, size()); another i throws std::out_of_range.
  std::int64_t time_us(int i) const { return times_us_.at(i); }  // rounded to the microsecond
  const std::filesystem::path& image_file(int i) const { return images_.at(i); }
  GrayImage load_gray(int i) const;   // a size other than the camera's is a problem, too
  FileBytes load_bytes(int i) const;  // e.g. a JPEG to publish without decoding it

 private:
  std::filesystem::path folder_;
  Camera camera_;
  std::vector<std::filesystem::path> images_;
  std::vector<std::int64_t> times_us_;
  std::vector<TumPose> ground_truth_;
};

struct RecordedSequence::Opened {
  std::optional<RecordedSequence> sequence;
  std::string problem;  // "" when there is a sequence
};

}  // namespace eifmap
