#include "sequence/recorded_sequence.h"

#include <stdexcept>

#include "sequence/camera_choice.h"
#include "sequence/layout.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

std::string unknown_layout(const fs::path& folder) {
  std::error_code error;
  if (fs::is_empty(folder, error))
    return folder.string() + ": is empty; wanted a folder that holds " + known_layouts();
  return folder.string() + ": holds no images in a known layout; wanted " + known_layouts();
}

}  // namespace

RecordedSequence::Opened RecordedSequence::open(const fs::path& folder,
                                                const SequenceOptions& options) {
  if (const std::string problem = options.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return {std::nullopt,
            folder.string() + ": is no folder; wanted one that holds " + known_layouts()};
  const Layout* layout = find_layout(folder);
  if (!layout) return {std::nullopt, unknown_layout(folder)};
  Recording recording = layout->read(folder, options);
  if (!recording.problem.empty()) return {std::nullopt, recording.problem};
  // Only the calibration depends on the first image; what is wrong with it is said when its turn
  // comes, as with the others.
  const cv::Size first = read_gray(recording.images.front()).image.size();
  CameraChoice choice =
      choose_camera(options, folder.string(), recording.camera, recording.calibration, first);
  if (!choice.problem.empty()) return {std::nullopt, choice.problem};
  RecordedSequence sequence;
  sequence.folder_ = folder;
  sequence.layout_ = layout->name;
  sequence.calibration_ = choice.from;
  sequence.camera_ = choice.camera;
  sequence.images_ = std::move(recording.images);
  sequence.times_us_ = std::move(recording.times_us);
  sequence.ground_truth_ = std::move(recording.ground_truth);
  sequence.notes_ = std::move(recording.notes);
  if (!choice.note.empty()) sequence.notes_.push_back(choice.note);
  return {std::move(sequence), ""};
}

FileBytes RecordedSequence::load_bytes(int i) const {
  return read_bytes(image_file(i));
}

GrayImage RecordedSequence::load_gray(int i) const {
  GrayImage gray = read_gray(image_file(i));
  if (!gray.problem.empty()) return gray;
  const cv::Mat& image = gray.image;
  if (image.cols == camera_.width && image.rows == camera_.height) return gray;
  return {{},
          image_file(i).string() + ": is " + std::to_string(image.cols) + "x" +
              std::to_string(image.rows) + ", but " + calibration_ + " says " +
              std::to_string(camera_.width) + "x" + std::to_string(camera_.height) +
              "; all images must have the calibration's size",
          Reason::kBadImageSize};
}

}  // namespace eifmap
