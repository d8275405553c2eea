// Images with true poses: of the rendered courtyard, or a recorded folder.
#pragma once

#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.h"
#include "sequence/tum.h"
#include "simulation/simulated_world.h"

namespace eifmap::test {

struct Recording {
  std::string name;
  Camera camera;
  std::vector<std::int64_t> times_us;  // of the images
  std::vector<TumPose> truth;          // by time
  // Not measured but made: a pose for every image, which its covariance can be judged by.
  bool truth_is_exact = false;
  std::function<cv::Mat(int)> image;  // gray; throws std::runtime_error when it cannot be read

  int size() const { return static_cast<int>(times_us.size()); }
  // Nothing where no true pose belongs to the image.
  std::optional<Rigid3> world_from_camera(int i) const;
};

// The courtyard. `cache`: a folder that keeps the images as files, to be emptied by hand when the
// simulation changes; empty: rendered each time.
Recording rendered(const SimulationOptions& options, const std::filesystem::path& cache = {});

// At most `max_frames` images, 0: all. Throws std::runtime_error on a folder that cannot be read.
Recording recorded(const std::filesystem::path& folder, int max_frames);

}  // namespace eifmap::test
