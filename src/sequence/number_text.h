// Numbers in text files, independent of the locale.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace eifmap {

// Words between blanks, tabs, commas and line ends, up to a '#'.
std::vector<std::string> split_words(std::string_view line);

// The whole of `text` as a number ("nan" and "inf" are numbers), else nothing.
std::optional<double> parse_number(std::string_view text);

// The fewest digits that read back as the very same double.
std::string exact_text(double value);

}  // namespace eifmap
