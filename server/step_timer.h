// Wall time per step and frame. The mapper reads no clock: it is told when a step begins and ends.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace eifmap {

struct StepTime {
  int frames = 0;  // in which the step ran
  double median_ms = 0, p99_ms = 0;
  double total_s = 0;
};

class StepTimer {
 public:
  void begin_frame();
  // Steps may nest and may run several times in a frame: their times add up. Fits
  // Mapper::set_step_observer.
  void observe(std::string_view step, bool begins);
  // A step of the current frame that another clock has timed.
  void add(std::string_view step, double ms);
  // `keep`: for summary().
  void end_frame(bool keep = true);

  bool is_empty() const { return steps_.empty(); }  // nothing was ever told to it

  // Of the whole run, in alphabetical order of the steps.
  std::map<std::string, StepTime> summary() const;

 private:
  using Clock = std::chrono::steady_clock;

  struct Step {
    Clock::time_point begin;
    bool ran = false;
    double frame_ms = 0;           // in the current frame
    std::vector<float> frames_ms;  // of the frames in which it ran
  };

  std::map<std::string, Step, std::less<>> steps_;
};

// Tells a timer the begin and end of a step of the caller's own.
class TimedStep {
 public:
  TimedStep(StepTimer& timer, std::string_view step) : timer_(timer), step_(step) {
    timer_.observe(step_, true);
  }
  ~TimedStep() { timer_.observe(step_, false); }
  TimedStep(const TimedStep&) = delete;
  TimedStep& operator=(const TimedStep&) = delete;

 private:
  StepTimer& timer_;
  std::string_view step_;
};

}  // namespace eifmap
