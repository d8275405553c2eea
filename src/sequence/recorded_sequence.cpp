#include "sequence/recorded_sequence.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "sequence/number_text.h"

namespace eifmap {
namespace fs = std::filesystem;
namespace {

std::string layout_hint() {
  return "a recorded folder holds images/, times.txt and calib.json";
}

bool is_image(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  for (const char* known : {".jpg", ".jpeg", ".png", ".pgm", ".ppm", ".bmp", ".tif", ".tiff"})
    if (extension == known) return true;
  return false;
}

std::string list_images(const fs::path& folder, std::vector<fs::path>& images) {
  std::error_code error;
  fs::directory_iterator entry(folder, error);
  if (error)
    return folder.string() + ": cannot be listed (" + error.message() + "); " + layout_hint();
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (error) return folder.string() + ": cannot be listed (" + error.message() + ")";
    if (is_image(entry->path())) images.push_back(entry->path());
  }
  std::sort(images.begin(), images.end());
  if (images.empty()) return folder.string() + ": holds no images (.jpg, .png, .pgm, ...)";
  return "";
}

std::string read_times(const fs::path& file, std::vector<std::int64_t>& times_us) {
  std::ifstream in(file);
  if (!in) return file.string() + ": cannot be read; " + layout_hint();
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    const std::string where = file.string() + " line " + std::to_string(line) + ": ";
    const auto words = split_words(text);
    if (words.empty()) continue;
    const auto seconds = parse_number(words[0]);
    if (!seconds || !(std::abs(*seconds) < 9e12))
      return where + "'" + text + "' is no time; wanted seconds, one number a line";
    const std::int64_t time_us = std::llround(*seconds * 1e6);
    if (!times_us.empty() && time_us <= times_us.back())
      return where + words[0] + " s is not after the time before it; times must increase";
    times_us.push_back(time_us);
  }
  return "";
}

// Takes json[key] as a finite number; the first problem stays in `problem`.
double number_at(const nlohmann::json& json, const char* key, std::string& problem) {
  if (!problem.empty()) return 0;
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number()) {
    problem = std::string("'") + key + "' is missing or no number; wanted pixels";
    return 0;
  }
  return found->get<double>();
}

int size_at(const nlohmann::json& json, const char* key, std::string& problem) {
  const double value = number_at(json, key, problem);
  if (problem.empty() && !(value >= 1 && value <= 65536 && value == std::floor(value)))
    problem =
        std::string("'") + key + "' is " + json[key].dump() + "; wanted a whole number of pixels";
  return problem.empty() ? static_cast<int>(value) : 0;
}

void read_distortion(const nlohmann::json& json, Camera& camera, std::string& problem) {
  const auto found = json.find("distortion");
  if (!problem.empty() || found == json.end()) return;
  const bool numbers = found->is_array() && found->size() <= camera.distortion.size() &&
                       std::all_of(found->begin(), found->end(),
                                   [](const nlohmann::json& k) { return k.is_number(); });
  if (!numbers) {
    problem = "'distortion' is " + found->dump() +
              "; wanted up to 5 numbers: k1 k2 p1 p2 k3, of a fisheye k1 k2 k3 k4";
    return;
  }
  for (std::size_t i = 0; i < found->size(); ++i) camera.distortion[i] = (*found)[i].get<double>();
}

// Without a name, coefficients make a radial-tangential lens.
void read_model(const nlohmann::json& json, Camera& camera, std::string& problem) {
  if (!problem.empty()) return;
  const bool bent = std::any_of(camera.distortion.begin(), camera.distortion.end(),
                                [](double k) { return k != 0; });
  if (bent) camera.model = CameraModel::kRadialTangential;
  const auto found = json.find("model");
  if (found == json.end() || *found == "radial_tangential") return;
  if (*found == "fisheye")
    camera.model = CameraModel::kFisheye;
  else if (*found != "pinhole")
    problem = "'model' is " + found->dump() + "; wanted pinhole, radial_tangential or fisheye";
  else if (bent)
    problem = "'model' is pinhole, but 'distortion' is not zero";
}

}  // namespace

CameraFile read_camera(const fs::path& file) {
  CameraFile result;
  std::ifstream in(file);
  if (!in) return {{}, file.string() + ": cannot be read; " + layout_hint()};
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (!json.is_object()) return {{}, file.string() + ": is no JSON object"};
  Camera& camera = result.camera;
  camera.width = size_at(json, "width", result.problem);
  camera.height = size_at(json, "height", result.problem);
  camera.fx = number_at(json, "fx", result.problem);
  camera.fy = number_at(json, "fy", result.problem);
  camera.cx = number_at(json, "cx", result.problem);
  camera.cy = number_at(json, "cy", result.problem);
  read_distortion(json, camera, result.problem);
  read_model(json, camera, result.problem);
  if (result.problem.empty()) result.problem = camera.problem();
  if (!result.problem.empty()) result.problem = file.string() + ": " + result.problem;
  return result;
}

RecordedSequence::Opened RecordedSequence::open(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return {std::nullopt, folder.string() + ": is no folder; " + layout_hint()};
  RecordedSequence sequence;
  sequence.folder_ = folder;
  auto problem = list_images(folder / "images", sequence.images_);
  if (problem.empty()) problem = read_times(folder / "times.txt", sequence.times_us_);
  if (!problem.empty()) return {std::nullopt, problem};
  if (sequence.times_us_.size() != sequence.images_.size())
    return {std::nullopt, (folder / "times.txt").string() + ": has " +
                              std::to_string(sequence.times_us_.size()) + " times for " +
                              std::to_string(sequence.images_.size()) + " images; wanted one each"};
  auto camera = read_camera(folder / "calib.json");
  if (!camera.problem.empty()) return {std::nullopt, camera.problem};
  sequence.camera_ = camera.camera;
  const fs::path truth = folder / "groundtruth.tum";
  if (fs::exists(truth, error)) {
    auto trajectory = read_tum(truth);
    if (!trajectory.problem.empty()) return {std::nullopt, trajectory.problem};
    sequence.ground_truth_ = std::move(trajectory.poses);
  }
  return {std::move(sequence), ""};
}

FileBytes RecordedSequence::load_bytes(int i) const {
  const fs::path& file = image_file(i);
  std::ifstream in(file, std::ios::binary);
  FileBytes result;
  result.bytes.assign(std::istreambuf_iterator<char>(in), {});
  if (!in || result.bytes.empty()) result.problem = file.string() + ": cannot be read, or is empty";
  return result;
}

GrayImage RecordedSequence::load_gray(int i) const {
  const FileBytes file = load_bytes(i);
  if (!file.problem.empty()) return {{}, file.problem};
  const std::string name = image_file(i).string();
  cv::Mat image;
  try {
    // The calibration is of the pixels as stored: a rotation tag must not turn them.
    image = cv::imdecode(file.bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& e) {
    return {{}, name + ": cannot be decoded (" + e.err + ")"};
  }
  if (image.empty()) return {{}, name + ": cannot be decoded as an image"};
  if (image.cols != camera_.width || image.rows != camera_.height)
    return {{},
            name + ": is " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                ", but calib.json says " + std::to_string(camera_.width) + "x" +
                std::to_string(camera_.height)};
  return {image, ""};
}

}  // namespace eifmap
