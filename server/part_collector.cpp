#include "server/part_collector.h"

#include <utility>

namespace eifmap {

std::vector<std::vector<std::uint8_t>> PartCollector::add(const std::string& camera,
                                                          Bytes message) {
  Decoded<FeaturePart> part = decode_feature_part(message);
  if (!part.ok()) return {{message.begin(), message.end()}};
  const std::lock_guard lock(mutex_);
  if (!assemblers_.contains(camera) && assemblers_.size() >= kMaxCameras) return {};
  std::vector<std::vector<std::uint8_t>> frames;
  for (const FeatureFrame& frame : assemblers_[camera].add(std::move(part.value)))
    frames.push_back(encode(to_message(frame)));
  return frames;
}

FeatureAssembler::Counts PartCollector::counts() const {
  const std::lock_guard lock(mutex_);
  FeatureAssembler::Counts sum;
  for (const auto& [camera, assembler] : assemblers_) {
    const FeatureAssembler::Counts& counts = assembler.counts();
    sum.whole += counts.whole;
    sum.incomplete += counts.incomplete;
    sum.missing_parts += counts.missing_parts;
    sum.late_parts += counts.late_parts;
  }
  return sum;
}

}  // namespace eifmap
