// How far a long run is, on a terminal as a bar, else as a line each tenth.
#pragma once

#include <chrono>
#include <ostream>

namespace eifmap {

class ProgressBar {
 public:
  ProgressBar(std::ostream& out, bool terminal) : out_(out), terminal_(terminal) {}
  void show(int done, int total);

 private:
  std::ostream& out_;
  bool terminal_;
  int shown_ = -1;  // tenths, or hundredths on a terminal
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace eifmap
