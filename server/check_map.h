// eifmap-server --check-map: what of a map's file is whole.
#pragma once

#include <filesystem>
#include <string>

namespace eifmap {

struct MapCheck {
  bool ok = false;   // there is a map in it, and its books are right
  std::string said;  // what was found, in words: for the user
};

// `repair`: cut off what follows the last whole record before any damage; what is cut off is kept
// beside the file, as FILE.damaged with all that there was.
MapCheck check_map(const std::filesystem::path& file, bool repair);

}  // namespace eifmap
