// Text files of a line a record, with errors that name the line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace eifmap {

// Calls take(line) for each line that is not empty until it returns a problem. Returns "", or that
// problem with the file's name and the line's number, or that the file cannot be read.
std::string for_each_text(const std::filesystem::path& file,
                          const std::function<std::string(const std::string& line)>& take);

// The same with the words of each line that has any (number_text.h).
std::string for_each_line(
    const std::filesystem::path& file,
    const std::function<std::string(const std::vector<std::string>& words)>& take);

// Adds a time to `times_us`, which must increase. Returns "" or what is wrong with the word.
std::string add_seconds(const std::string& word, std::vector<std::int64_t>& times_us);
std::string add_nanoseconds(const std::string& word, std::vector<std::int64_t>& times_us);

// `count` numbers of a line, from its word `first` on. Returns "" or which word is no finite
// number.
std::string read_numbers(const std::vector<std::string>& words, std::size_t first,
                         std::size_t count, double* numbers);

}  // namespace eifmap
