#include "server/step_timer.h"

#include <algorithm>
#include <numeric>

namespace eifmap {
namespace {

constexpr std::string_view kWholeFrame = "frame";

// Nearest rank; `sorted` is not empty.
double quantile(const std::vector<float>& sorted, double q) {
  const auto rank = static_cast<std::size_t>(q * static_cast<double>(sorted.size()));
  return sorted[std::min(rank, sorted.size() - 1)];
}

}  // namespace

void StepTimer::begin_frame() {
  observe(kWholeFrame, true);
}

void StepTimer::observe(std::string_view name, bool begins) {
  auto found = steps_.find(name);
  if (found == steps_.end()) found = steps_.emplace(std::string(name), Step{}).first;
  Step& step = found->second;
  const Clock::time_point now = Clock::now();
  if (begins) {
    step.begin = now;
    step.ran = true;
  } else {
    step.frame_ms += std::chrono::duration<double, std::milli>(now - step.begin).count();
  }
}

void StepTimer::add(std::string_view step, double ms) {
  if (!(ms > 0)) return;
  Step& timed = steps_.try_emplace(std::string(step)).first->second;
  timed.ran = true;
  timed.frame_ms += ms;
}

void StepTimer::end_frame(bool keep) {
  observe(kWholeFrame, false);
  for (auto& [name, step] : steps_) {
    if (step.ran && keep) step.frames_ms.push_back(static_cast<float>(step.frame_ms));
    step.ran = false;
    step.frame_ms = 0;
  }
}

std::map<std::string, StepTime> StepTimer::summary() const {
  std::map<std::string, StepTime> summary;
  for (const auto& [name, step] : steps_) {
    if (step.frames_ms.empty()) continue;
    std::vector<float> sorted = step.frames_ms;
    std::sort(sorted.begin(), sorted.end());
    const double total_ms = std::accumulate(sorted.begin(), sorted.end(), 0.0);
    summary[name] = {static_cast<int>(sorted.size()), quantile(sorted, 0.5), quantile(sorted, 0.99),
                     total_ms / 1000};
  }
  return summary;
}

}  // namespace eifmap
