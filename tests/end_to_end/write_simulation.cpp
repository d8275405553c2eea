// write_simulation FOLDER FRAMES: the first images of the simulated courtyard as a recorded folder,
// with their true poses.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "sequence/number_text.h"
#include "sequence/tum.h"
#include "simulation/simulated_world.h"

namespace {

using namespace eifmap;

void write_calibration(const Camera& camera, const std::filesystem::path& file) {
  std::ofstream out(file);
  out << "{\"width\": " << camera.width << ", \"height\": " << camera.height
      << ", \"fx\": " << exact_text(camera.fx) << ", \"fy\": " << exact_text(camera.fy)
      << ", \"cx\": " << exact_text(camera.cx) << ", \"cy\": " << exact_text(camera.cy)
      << ", \"distortion\": [";
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    out << (i > 0 ? ", " : "") << exact_text(camera.distortion[i]);
  out << "]}\n";
}

std::string write_truth(const SimulatedWorld& world, int frames,
                        const std::filesystem::path& file) {
  std::vector<TimedPose> poses;
  for (int i = 0; i < frames; ++i) poses.push_back({world.time_us(i), world.world_from_camera(i)});
  return write_tum(file, poses);
}

void write_images(const SimulatedWorld& world, int frames, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder / "images");
  std::ofstream times(folder / "times.txt");
  for (int i = 0; i < frames; ++i) {
    times << std::fixed << std::setprecision(6) << 1e-6 * static_cast<double>(world.time_us(i))
          << '\n';
    std::ostringstream name;
    name << std::setw(6) << std::setfill('0') << i << ".png";  // lossless: the very pixels
    cv::imwrite((folder / "images" / name.str()).string(), world.render(i));
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "write_simulation FOLDER FRAMES\n";
    return 2;
  }
  const SimulatedWorld world;
  const std::filesystem::path folder = argv[1];
  std::filesystem::remove_all(folder);
  const int frames = std::min(std::stoi(argv[2]), world.num_frames());
  write_images(world, frames, folder);
  write_calibration(world.camera(), folder / "calib.json");
  if (const std::string problem = write_truth(world, frames, folder / "groundtruth.tum");
      !problem.empty()) {
    std::cerr << problem << '\n';
    return 1;
  }
  return 0;
}
