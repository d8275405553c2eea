// A whole file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace eifmap {

// Its bytes; nothing where it cannot be read, as a folder cannot.
std::optional<std::string> file_text(const std::filesystem::path& file);

}  // namespace eifmap
