// A recording written in eifmap's own layout: images/, times.txt, calib.json, groundtruth.tum.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "sequence/tum.h"

namespace eifmap::test {

class OwnFolder {
 public:
  // Throws std::runtime_error when there is something in it already: it might be a recording.
  explicit OwnFolder(const std::filesystem::path& folder) : folder_(folder) {
    std::filesystem::create_directories(folder / "images");
    if (!std::filesystem::is_empty(folder / "images"))
      throw std::runtime_error(folder.string() + ": holds images already; give an empty folder");
    times_.open(folder / "times.txt", std::ios::binary);
  }

  // In the order of time. A PNG, which has the very pixels; compressed little, which is fast.
  void add(std::int64_t time_us, const cv::Mat& image) {
    const auto file = next(time_us, ".png");
    if (!cv::imwrite(file.string(), image, {cv::IMWRITE_PNG_COMPRESSION, 1}))
      throw std::runtime_error(file.string() + ": cannot be written");
  }
  void add_jpeg(std::int64_t time_us, const std::vector<std::uint8_t>& bytes) {
    const auto file = next(time_us, ".jpg");
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
    if (!out.flush()) throw std::runtime_error(file.string() + ": cannot be written");
  }
  // The file itself, of the same bytes.
  void add_link(std::int64_t time_us, const std::filesystem::path& image) {
    std::filesystem::create_symlink(std::filesystem::canonical(image),
                                    next(time_us, image.extension().string()));
  }

  // The rest. No file of the truth where there is none.
  void finish(const Camera& camera, std::span<const TimedPose> truth) {
    std::ofstream calibration(folder_ / "calib.json", std::ios::binary);
    calibration << json(camera).dump(1) << '\n';
    std::string problem = truth.empty() ? "" : write_tum(folder_ / "groundtruth.tum", truth);
    if (!times_.flush() || !calibration.flush()) problem = folder_.string() + ": cannot be written";
    if (!problem.empty()) throw std::runtime_error(problem);
  }

 private:
  std::filesystem::path next(std::int64_t time_us, const std::string& extension) {
    times_ << std::fixed << std::setprecision(6) << 1e-6 * static_cast<double>(time_us) << '\n';
    std::ostringstream name;
    name << std::setw(6) << std::setfill('0') << count_++ << extension;
    return folder_ / "images" / name.str();
  }

  static nlohmann::ordered_json json(const Camera& camera) {
    const bool fisheye = camera.model == CameraModel::kFisheye;
    const char* model = fisheye                                 ? "fisheye"
                        : camera.model == CameraModel::kPinhole ? "pinhole"
                                                                : "radial_tangential";
    const std::vector<double> distortion(camera.distortion.begin(),
                                         camera.distortion.end() - (fisheye ? 1 : 0));
    return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
            {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy},
            {"model", model},        {"distortion", distortion}};
  }

  std::filesystem::path folder_;
  std::ofstream times_;
  int count_ = 0;
};

// A truth as it is read, to be written: to the microsecond, as the images' times are.
inline std::vector<TimedPose> timed(std::span<const TumPose> poses) {
  std::vector<TimedPose> result;
  for (const TumPose& pose : poses)
    result.push_back({std::llround(1e6 * pose.time_s), pose.world_from_camera});
  return result;
}

}  // namespace eifmap::test
