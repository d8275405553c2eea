// A feature frame in parts that fit one datagram each, for links where a message of many datagrams
// would hardly ever arrive whole. A part that is lost costs its features and not the frame.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "convert/feature_message.h"

namespace eifmap {

// Part p of n has the features p, p + n, p + 2 n, ...: what is lost is weak and strong ones, all
// over the image. Each message is at most `max_bytes` long, or has one feature. Throws
// std::invalid_argument as to_message() does.
std::vector<feature_frame_t> split_features(const FeatureFrame& frame, std::size_t max_bytes);

// Puts the parts of one camera's frames together again, in the order of capture.
class FeatureAssembler {
 public:
  struct Counts {
    std::int64_t whole = 0, incomplete = 0;  // frames
    std::int64_t missing_parts = 0;          // of those incomplete
    std::int64_t late_parts = 0;             // of frames given up before, or come twice
  };

  // What the part finishes: its own frame when it was the last one missing; before it the frame in
  // work, with what of it has come, when the part belongs to a newer one.
  std::vector<FeatureFrame> add(FeaturePart part);

  // The frame in work as far as it has come; nothing when there is none.
  std::optional<FeatureFrame> give_up();

  const Counts& counts() const { return counts_; }

 private:
  struct InWork {
    FeatureFrame header;  // without features
    int num_parts = 0;
    std::map<int, FeatureFrame> parts;  // that came
    std::int64_t missing() const { return num_parts - static_cast<std::int64_t>(parts.size()); }
  };

  bool is_late(const FeaturePart& part) const;
  bool belongs(const FeaturePart& part) const;
  void begin(const FeaturePart& part);

  std::optional<InWork> in_work_;
  // The frame given out last.
  std::int64_t last_publisher_ = 0, last_seq_ = -1, last_time_us_ = -1;
  Counts counts_;
};

}  // namespace eifmap
