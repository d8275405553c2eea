// write_simulation FOLDER FRAMES: the first images of the simulated courtyard as a recorded folder,
// with their true poses.
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "simulation/simulated_world.h"
#include "support/own_folder.h"

int main(int argc, char** argv) {
  using namespace eifmap;
  if (argc != 3) {
    std::cerr << "write_simulation FOLDER FRAMES\n";
    return 2;
  }
  try {
    const SimulatedWorld world;
    std::filesystem::remove_all(argv[1]);
    test::OwnFolder folder(argv[1]);
    std::vector<TimedPose> truth;
    const int frames = std::min(std::stoi(argv[2]), world.num_frames());
    for (int i = 0; i < frames; ++i) {
      folder.add(world.time_us(i), world.render(i));
      truth.push_back({world.time_us(i), world.world_from_camera(i)});
    }
    folder.finish(world.camera(), truth);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
