#include "server/part_collector.h"

#include <utility>

namespace eifmap {

void PartCollector::take(Bytes message, Clock::time_point now, bool may_wait) {
  const std::lock_guard lock(work_mutex_);
  if (!is_part_of_features(message)) {
    finish(may_wait);
    return deliver_(message, may_wait);
  }
  Decoded<FeaturePart> part = decode_feature_part(message);
  if (!part.ok()) return deliver_(message, may_wait);
  last_part_ = now;
  const std::vector<FeatureFrame> frames = assembler_.add(std::move(part.value));
  publish_counts();
  for (const FeatureFrame& frame : frames) deliver(frame, may_wait);
}

void PartCollector::give_up_silent(Clock::time_point now) {
  const std::unique_lock lock(work_mutex_, std::try_to_lock);
  if (lock && now - last_part_ >= kSilence) finish(false);
}

FeatureAssembler::Counts PartCollector::counts() const {
  const std::lock_guard lock(counts_mutex_);
  return counts_;
}

void PartCollector::deliver(const FeatureFrame& frame, bool may_wait) {
  deliver_(encode(to_message(frame)), may_wait);
}

void PartCollector::finish(bool may_wait) {
  const std::optional<FeatureFrame> frame = assembler_.give_up();
  publish_counts();
  if (frame) deliver(*frame, may_wait);
}

void PartCollector::publish_counts() {
  const std::lock_guard lock(counts_mutex_);
  counts_ = assembler_.counts();
}

}  // namespace eifmap
