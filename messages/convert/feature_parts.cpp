#include "convert/feature_parts.h"

#include <algorithm>
#include <utility>

namespace eifmap {
namespace {

// Numbers this far back are a publisher that counts anew, not a part that took so long.
constexpr std::int64_t kLateWindow = 64;

FeatureFrame without_features(const FeatureFrame& frame) {
  FeatureFrame header = frame;
  header.keypoints.clear();
  header.descriptors.clear();
  return header;
}

void append_feature(const FeatureFrame& from, std::size_t feature, FeatureFrame& to) {
  to.keypoints.push_back(from.keypoints[feature]);
  const auto begin =
      from.descriptors.begin() + static_cast<std::ptrdiff_t>(feature * kDescriptorSize);
  to.descriptors.insert(to.descriptors.end(), begin, begin + kDescriptorSize);
}

std::size_t parts_needed(const FeatureFrame& frame, std::size_t max_bytes) {
  FeatureFrame some = without_features(frame);
  const auto encoded = [&some] {
    return static_cast<std::size_t>(to_message(some).getEncodedSize());
  };
  const std::size_t empty = encoded();
  some.keypoints.resize(1);
  some.descriptors.resize(kDescriptorSize);
  const std::size_t each = encoded() - empty;
  const std::size_t in_a_part = max_bytes > empty + each ? (max_bytes - empty) / each : 1;
  const std::size_t n = frame.keypoints.size();
  return std::max<std::size_t>(1, (n + in_a_part - 1) / in_a_part);
}

}  // namespace

std::vector<feature_frame_t> split_features(const FeatureFrame& frame, std::size_t max_bytes) {
  const feature_frame_t whole = to_message(frame);
  if (static_cast<std::size_t>(whole.getEncodedSize()) <= max_bytes) return {whole};
  const std::size_t n = parts_needed(frame, max_bytes);
  std::vector<feature_frame_t> messages;
  for (std::size_t p = 0; p < n; ++p) {
    FeatureFrame part = without_features(frame);
    for (std::size_t i = p; i < frame.keypoints.size(); i += n) append_feature(frame, i, part);
    messages.push_back(to_message(part));
    messages.back().part = static_cast<std::int16_t>(p);
    messages.back().num_parts = static_cast<std::int16_t>(n);
  }
  return messages;
}

bool FeatureAssembler::belongs(const FeaturePart& part) const {
  const FeatureFrame& header = in_work_->header;
  return header.publisher == part.frame.publisher && header.seq == part.frame.seq &&
         header.time_us == part.frame.time_us && in_work_->num_parts == part.num_parts;
}

bool FeatureAssembler::is_late(const FeaturePart& part) const {
  const FeatureFrame& frame = part.frame;
  const auto behind = [&frame](std::int64_t publisher, std::int64_t seq, std::int64_t time_us) {
    if (publisher != frame.publisher) return false;
    if (seq < 0 || frame.seq < 0) return frame.time_us == time_us;
    return frame.seq <= seq && frame.seq > seq - kLateWindow && frame.time_us <= time_us;
  };
  if (in_work_) {
    const FeatureFrame& header = in_work_->header;
    if (!belongs(part) && behind(header.publisher, header.seq, header.time_us)) return true;
  }
  return behind(last_publisher_, last_seq_, last_time_us_);
}

void FeatureAssembler::begin(const FeaturePart& part) {
  in_work_.emplace(InWork{without_features(part.frame), part.num_parts, {}});
}

std::optional<FeatureFrame> FeatureAssembler::give_up() {
  if (!in_work_) return {};
  InWork done = std::move(*in_work_);
  in_work_.reset();
  ++(done.missing() == 0 ? counts_.whole : counts_.incomplete);
  counts_.missing_parts += done.missing();
  last_publisher_ = done.header.publisher;
  last_seq_ = done.header.seq;
  last_time_us_ = done.header.time_us;
  FeatureFrame frame = std::move(done.header);
  // Row by row as they were dealt out; a lost part leaves the others' order as it was.
  for (std::size_t row = 0;; ++row) {
    bool any = false;
    for (const auto& [number, part] : done.parts) {
      if (row >= part.keypoints.size()) continue;
      append_feature(part, row, frame);
      any = true;
    }
    if (!any) return frame;
  }
}

std::vector<FeatureFrame> FeatureAssembler::add(FeaturePart part) {
  std::vector<FeatureFrame> finished;
  if (is_late(part)) {
    ++counts_.late_parts;
    return finished;
  }
  if (in_work_ && !belongs(part)) finished.push_back(*give_up());
  if (!in_work_) begin(part);
  if (!in_work_->parts.try_emplace(part.part, std::move(part.frame)).second) {
    ++counts_.late_parts;
    return finished;
  }
  if (in_work_->missing() == 0) finished.push_back(*give_up());
  return finished;
}

}  // namespace eifmap
