#include "server/stream_book.h"

#include <algorithm>

#include "wire/limits.h"

namespace eifmap {

void StreamBook::begin_numbers() {
  if (!counts_.empty()) ++restarts_;
  first_ = highest_ = -1;
  seen_.reset();
}

void StreamBook::begin(std::int64_t publisher) {
  begin_numbers();
  const auto known = std::find_if(counts_.begin(), counts_.end(), [publisher](const auto& counts) {
    return counts.publisher == publisher;
  });
  if (known != counts_.end()) {
    std::rotate(counts_.begin(), known, known + 1);
    return;
  }
  counts_.insert(counts_.begin(), StreamCounts{.publisher = publisher});
  if (counts_.size() <= kMaxStreams) return;
  forgotten_missing_ = std::min(kMaxSeq, forgotten_missing_ + counts_.back().missing);
  counts_.pop_back();
}

bool StreamBook::count(const FrameArrival& arrival, std::int64_t dropped_before,
                       StreamCounts& counts) {
  const std::int64_t seq = arrival.seq;
  // A lower number of a newer image: the same publisher, that counts anew.
  if (seq < highest_ && arrival.time_us > highest_time_us_) begin_numbers();
  if (highest_ < 0 || seq > highest_) {
    if (highest_ < 0) first_ = seq;
    highest_time_us_ = arrival.time_us;
    const std::int64_t step = highest_ < 0 ? 1 : seq - highest_;
    counts.missing =
        std::min(kMaxSeq, counts.missing + std::max<std::int64_t>(0, step - 1 - dropped_before));
    seen_ = step < static_cast<std::int64_t>(kWindow) ? seen_ << static_cast<std::size_t>(step)
                                                      : std::bitset<kWindow>();
    seen_.set(0);
    highest_ = seq;
    return true;
  }
  const std::int64_t back = highest_ - seq;
  if (back < static_cast<std::int64_t>(kWindow) && !seen_[static_cast<std::size_t>(back)]) {
    seen_.set(static_cast<std::size_t>(back));
    ++counts.reordered;
    // What came before the first was never counted as missing.
    if (seq > first_) counts.missing = std::max<std::int64_t>(0, counts.missing - 1);
    return true;
  }
  // So far back that nobody knows: nothing is that late, but a publisher may send again.
  ++counts.duplicates;
  return false;
}

bool StreamBook::note(const FrameArrival& arrival, std::int64_t dropped_before) {
  if (counts_.empty() || counts_.front().publisher != arrival.publisher) begin(arrival.publisher);
  StreamCounts& counts = counts_.front();
  ++counts.frames;
  if (arrival.received_us > 0) {
    const std::int64_t offset = arrival.received_us - arrival.time_us;
    counts.clock_offset_us = std::min(counts.clock_offset_us.value_or(offset), offset);
  }
  return arrival.seq < 0 || count(arrival, dropped_before, counts);
}

std::int64_t StreamBook::missing() const {
  std::int64_t sum = forgotten_missing_;
  for (const StreamCounts& counts : counts_) sum += counts.missing;
  return sum;
}

}  // namespace eifmap
