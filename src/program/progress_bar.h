// How far a long run is, on a terminal as a bar, else as a line each tenth.
#pragma once

#include <chrono>
#include <ostream>

namespace eifmap {

class ProgressBar {
 public:
  ProgressBar(std::ostream& out, bool terminal) : out_(out), terminal_(terminal) {}
  ~ProgressBar();  // ends a line that was left open
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // `total` < 0: nobody knows; then a count, on a terminal once a second, else once a minute.
  void show(int done, int total);

 private:
  using Clock = std::chrono::steady_clock;
  void show_count(int done);

  std::ostream& out_;
  bool terminal_;
  bool line_open_ = false;  // on a terminal
  int shown_ = -1;          // tenths, or hundredths on a terminal
  Clock::time_point begin_ = Clock::now(), next_ = begin_;
};

}  // namespace eifmap
