// The files of the page, inside the program; made from web/ by embed.cmake.
#pragma once

#include <span>
#include <string_view>

namespace eifmap {

struct PageFile {
  std::string_view path;  // as asked for: "/view.js"; the page itself is "/"
  std::string_view type;  // of its content, as HTTP names it
  std::string_view body;
};

std::span<const PageFile> page_files();

}  // namespace eifmap
