#include "sequence/file_text.h"

#include <fstream>
#include <sstream>
#include <utility>

namespace eifmap {

std::optional<std::string> file_text(const std::filesystem::path& file) {
  // A folder opens, too, and throws when it is read.
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) return {};
  std::ifstream in(file, std::ios::binary);
  if (!in) return {};
  std::ostringstream text;  // block by block; byte by byte takes a tenth of a PNG's time
  text << in.rdbuf();
  if (in.bad()) return {};
  return std::move(text).str();
}

}  // namespace eifmap
