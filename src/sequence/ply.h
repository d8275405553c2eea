// Point clouds as PLY, which MeshLab, CloudCompare and Blender read.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "map_view.h"

namespace eifmap {

enum class PlyColour {
  kSign,    // orange: bright blobs on dark; blue: dark blobs on bright
  kHeight,  // along the world's y axis, from low (blue) over green to high (red)
};

// Binary, little endian: x y z (float), red green blue (uchar), observations (int). Returns "" or
// what went wrong.
std::string write_ply(const std::filesystem::path& file, std::span<const MapPoint> points,
                      PlyColour colour = PlyColour::kSign);

}  // namespace eifmap
