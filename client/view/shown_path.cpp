#include "client/view/shown_path.h"

namespace eifmap {

void ShownPath::add(const Eigen::Vector3d& position) {
  if (steps_.size() == kMaxSteps) thin();
  steps_.push_back({position.cast<float>(), joined_});
  joined_ = true;
  changed_ = true;
}

void ShownPath::scale_by(double factor) {
  for (Step& step : steps_) step.position *= static_cast<float>(factor);
  sent_ = 0;
  changed_ = true;
}

void ShownPath::clear() {
  steps_.clear();
  sent_ = 0;
  joined_ = false;
  changed_ = true;
}

void ShownPath::mark_sent() {
  sent_ = steps_.size();
  changed_ = false;
}

// Of two steps the later one stays; it is joined when both were.
void ShownPath::thin() {
  std::size_t kept = 0;
  for (std::size_t i = 1; i < steps_.size(); i += 2, ++kept)
    steps_[kept] = {steps_[i].position, steps_[i].joined && steps_[i - 1].joined};
  steps_.resize(kept);
  sent_ = 0;
}

}  // namespace eifmap
