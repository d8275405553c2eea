// What is fuzzed: something of ours that takes bytes which anybody may have made.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "wire/bytes.h"

namespace eifmap::fuzz {

using Wire = std::vector<std::uint8_t>;

struct Target {
  std::string name;                          // also of the folder corpus/NAME
  std::function<bool(Bytes)> run;            // whether they were taken, not refused
  std::function<std::vector<Wire>()> seeds;  // that are taken, to start from
};

// By what they need to be built with: each in a file of its own name.
std::vector<Target> message_targets();
std::vector<Target> file_targets();
std::vector<Target> server_targets();
std::vector<Target> storage_targets();
std::vector<Target> all_targets();  // add new files of targets here, in targets.cpp

// Ends the program, as a finding, where something that must hold does not.
void require(bool holds, const char* what);

inline Wire wire_of(const std::string& text) {
  return {text.begin(), text.end()};
}
inline std::string text_of(Bytes bytes) {
  return {bytes.begin(), bytes.end()};
}

// Takes numbers from the front of the bytes; zeros when there are none left.
class ByteReader {
 public:
  explicit ByteReader(Bytes bytes) : left_(bytes) {}
  bool empty() const { return left_.empty(); }
  std::uint8_t byte() {
    if (left_.empty()) return 0;
    const std::uint8_t first = left_.front();
    left_ = left_.subspan(1);
    return first;
  }
  int below(int end) { return byte() % end; }

 private:
  Bytes left_;
};

// A file in memory with these bytes, for readers that want a file.
class MemoryFile {
 public:
  explicit MemoryFile(Bytes bytes);
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace eifmap::fuzz
