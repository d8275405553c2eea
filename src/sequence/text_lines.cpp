#include "sequence/text_lines.h"

#include <charconv>
#include <cmath>
#include <fstream>

#include "sequence/number_text.h"

namespace eifmap {
namespace {

std::string add_time(std::int64_t time_us, const std::string& text,
                     std::vector<std::int64_t>& times_us) {
  if (!times_us.empty() && time_us <= times_us.back())
    return text + " is not after the time before it; times must increase by a microsecond or more";
  times_us.push_back(time_us);
  return "";
}

}  // namespace

std::string for_each_text(const std::filesystem::path& file,
                          const std::function<std::string(const std::string& line)>& take) {
  std::ifstream in(file);
  std::string text;
  std::error_code error;
  // A folder opens, too, and gives no line.
  if (!in || std::filesystem::is_directory(file, error)) return file.string() + ": cannot be read";
  for (int line = 1; std::getline(in, text); ++line) {
    if (text.empty()) continue;
    if (const std::string problem = take(text); !problem.empty())
      return file.string() + " line " + std::to_string(line) + ": " + problem;
  }
  return "";
}

std::string for_each_line(
    const std::filesystem::path& file,
    const std::function<std::string(const std::vector<std::string>& words)>& take) {
  return for_each_text(file, [&take](const std::string& line) {
    const auto words = split_words(line);
    return words.empty() ? std::string() : take(words);
  });
}

std::string add_seconds(const std::string& word, std::vector<std::int64_t>& times_us) {
  const auto seconds = parse_number(word);
  if (!seconds || !(std::abs(*seconds) < 9e12)) return "'" + word + "' is no time; wanted seconds";
  return add_time(std::llround(*seconds * 1e6), word + " s", times_us);
}

std::string add_nanoseconds(const std::string& word, std::vector<std::int64_t>& times_us) {
  std::int64_t time_ns = 0;
  const char* end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, time_ns);
  if (parsed.ec != std::errc() || parsed.ptr != end || time_ns < 0)
    return "'" + word + "' is no time; wanted whole nanoseconds";
  return add_time(time_ns / 1000 + (time_ns % 1000 >= 500 ? 1 : 0), word + " ns", times_us);
}

std::string read_numbers(const std::vector<std::string>& words, std::size_t first,
                         std::size_t count, double* numbers) {
  if (words.size() < first + count)
    return "has " + std::to_string(words.size()) + " words; wanted " +
           std::to_string(first + count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto number = parse_number(words[first + i]);
    if (!number || !std::isfinite(*number)) return "'" + words[first + i] + "' is no finite number";
    numbers[i] = *number;
  }
  return "";
}

}  // namespace eifmap
