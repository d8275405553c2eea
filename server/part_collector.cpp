#include "server/part_collector.h"

#include <algorithm>
#include <utility>

namespace eifmap {

void PartCollector::take(const std::string& name, Bytes message, Clock::time_point now) {
  const std::lock_guard lock(work_mutex_);
  if (is_foreign(name)) {
    if (!is_part_of_features(message) || is_first_part(message)) deliver_(name, message, true);
    return;
  }
  const auto known = cameras_.find(name);
  if (!is_part_of_features(message)) {
    if (known != cameras_.end()) finish(name, known->second, true);
    return deliver_(name, message, true);
  }
  Decoded<FeaturePart> part = decode_feature_part(message);
  if (!part.ok()) return deliver_(name, message, true);
  if (known == cameras_.end()) make_room();
  Camera& camera = cameras_[name];
  camera.last_part = now;
  const FeatureAssembler::Counts before = camera.assembler.counts();
  const std::vector<FeatureFrame> frames = camera.assembler.add(std::move(part.value));
  note(before, camera.assembler.counts());
  deliver(name, frames, true);
}

void PartCollector::give_up_silent(Clock::time_point now) {
  const std::unique_lock lock(work_mutex_, std::try_to_lock);
  if (!lock) return;
  for (auto& [name, camera] : cameras_)
    if (now - camera.last_part >= kSilence) finish(name, camera, false);
}

void PartCollector::select_camera(const std::string& camera) {
  const std::lock_guard lock(state_mutex_);
  selected_ = camera;
}

FeatureAssembler::Counts PartCollector::counts() const {
  const std::lock_guard lock(state_mutex_);
  return counts_;
}

bool PartCollector::is_foreign(const std::string& camera) const {
  const std::lock_guard lock(state_mutex_);
  return !selected_.empty() && camera != selected_;
}

void PartCollector::deliver(const std::string& camera, const std::vector<FeatureFrame>& frames,
                            bool may_wait) {
  for (const FeatureFrame& frame : frames) deliver_(camera, encode(to_message(frame)), may_wait);
}

void PartCollector::finish(const std::string& name, Camera& camera, bool may_wait) {
  const FeatureAssembler::Counts before = camera.assembler.counts();
  const std::optional<FeatureFrame> frame = camera.assembler.give_up();
  note(before, camera.assembler.counts());
  if (frame) deliver(name, {*frame}, may_wait);
}

void PartCollector::note(const FeatureAssembler::Counts& before,
                         const FeatureAssembler::Counts& after) {
  const std::lock_guard lock(state_mutex_);
  counts_.whole += after.whole - before.whole;
  counts_.incomplete += after.incomplete - before.incomplete;
  counts_.missing_parts += after.missing_parts - before.missing_parts;
  counts_.late_parts += after.late_parts - before.late_parts;
}

// The one that has been silent the longest goes.
void PartCollector::make_room() {
  if (cameras_.size() < kMaxCameras) return;
  const auto oldest = std::min_element(
      cameras_.begin(), cameras_.end(),
      [](const auto& a, const auto& b) { return a.second.last_part < b.second.last_part; });
  finish(oldest->first, oldest->second, true);
  cameras_.erase(oldest);
}

}  // namespace eifmap
