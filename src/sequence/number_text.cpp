#include "sequence/number_text.h"

#include <charconv>

namespace eifmap {

std::vector<std::string> split_words(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r\n,";
  line = line.substr(0, line.find('#'));
  std::vector<std::string> words;
  for (std::size_t start = 0;;) {
    start = line.find_first_not_of(kBlanks, start);
    if (start == std::string_view::npos) return words;
    const std::size_t end = std::min(line.find_first_of(kBlanks, start), line.size());
    words.emplace_back(line.substr(start, end - start));
    start = end;
  }
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string exact_text(double value) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof(buffer), value).ptr;
  return {buffer, end};
}

}  // namespace eifmap
