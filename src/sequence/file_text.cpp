#include "sequence/file_text.h"

#include <fstream>
#include <iterator>

namespace eifmap {

std::optional<std::string> file_text(const std::filesystem::path& file) {
  // A folder opens, too, and throws when it is read.
  std::error_code error;
  if (std::filesystem::is_directory(file, error)) return {};
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in) return {};
  return text;
}

}  // namespace eifmap
