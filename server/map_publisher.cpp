#include "server/map_publisher.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "published/map_part.h"

namespace eifmap {

MapPublisher::Sent MapPublisher::encoded(const map_part_t& update) const {
  Sent sent;
  sent.seq = update.seq;
  sent.whole = update.base_seq == -1;
  for (const map_part_t& part : split(update, options_.max_part_bytes)) {
    auto message = std::make_shared<OutgoingMessage>();
    message->channel = channel_;
    message->bytes = encode(part);
    sent.bytes += message->bytes.size();
    sent.parts.push_back(std::move(message));
  }
  return sent;
}

void MapPublisher::publish(map_part_t update, const std::string& channel) {
  const bool whole = update.base_seq == -1;
  const bool is_next =
      map_.seq() > 0 && update.base_seq == map_.seq() && update.seq == update.base_seq + 1;
  if (whole ? update.seq <= map_.seq() : !is_next)
    throw std::invalid_argument("map update from " + std::to_string(update.base_seq) + " to " +
                                std::to_string(update.seq) + " does not follow on from " +
                                std::to_string(map_.seq()));
  channel_ = channel;
  map_.apply(update);
  update.digest = map_.digest();
  if (whole) {
    counts_.parts_dropped += outbox_.drop_all();
    updates_.clear();
  }
  updates_.push_back(encoded(update));
  if (whole) whole_ = updates_.back();
  for (const auto& part : updates_.back().parts) outbox_.push(part);
  forget_old();
}

std::size_t MapPublisher::bytes_after(std::int64_t seq) const {
  return std::accumulate(
      updates_.begin(), updates_.end(), std::size_t{0},
      [seq](std::size_t sum, const Sent& s) { return sum + (s.seq > seq ? s.bytes : 0); });
}

void MapPublisher::forget_old() {
  std::size_t bytes = bytes_after(-1);
  const std::size_t useful =
      std::min(options_.max_kept_bytes, std::max(options_.small_map_bytes, 2 * map_.whole_bytes()));
  while (updates_.size() > 1 && bytes > useful) {
    bytes -= updates_.front().bytes;
    updates_.pop_front();
  }
  if (whole_ && whole_->seq + 1 < updates_.front().seq) whole_.reset();
}

const MapPublisher::Sent* MapPublisher::sent(std::int64_t seq, bool whole) const {
  if (whole && whole_ && whole_->seq == seq) return &*whole_;
  if (updates_.empty() || seq < updates_.front().seq || seq > updates_.back().seq) return nullptr;
  const Sent& found = updates_[static_cast<std::size_t>(seq - updates_.front().seq)];
  return whole && !found.whole ? nullptr : &found;
}

// False where it is there no more.
bool MapPublisher::add_missing(const missing_part_t& missing,
                               std::vector<std::shared_ptr<OutgoingMessage>>& wanted) const {
  if (missing.seq > map_.seq()) return true;
  const Sent* const found = sent(missing.seq, missing.whole != 0);
  if (!found || missing.part >= static_cast<std::int32_t>(found->parts.size())) return false;
  if (missing.part == kAllParts)
    wanted.insert(wanted.end(), found->parts.begin(), found->parts.end());
  else
    wanted.push_back(found->parts[static_cast<std::size_t>(missing.part)]);
  return true;
}

// False where the whole map is the answer.
bool MapPublisher::find_wanted(const map_request_t& request,
                               std::vector<std::shared_ptr<OutgoingMessage>>& wanted) const {
  const bool of_this_run = request.server_epoch == map_.server_epoch();
  if (request.missing.empty()) {
    if (!of_this_run || request.have_seq < 0 || request.have_seq > map_.seq()) return false;
    for (std::int64_t seq = request.have_seq + 1; seq <= map_.seq(); ++seq)
      if (missing_part_t all{seq, kAllParts, 0}; !add_missing(all, wanted)) return false;
    return true;
  }
  if (!of_this_run && request.have_seq >= 0) return false;
  for (const missing_part_t& missing : request.missing)
    if (!add_missing(missing, wanted)) return false;
  return true;
}

// The last one that was made serves until what came after it is more than another would be.
void MapPublisher::add_whole(std::vector<std::shared_ptr<OutgoingMessage>>& wanted) {
  if (!whole_ || bytes_after(whole_->seq) > whole_->bytes) {
    whole_ = encoded(map_.whole());
    ++counts_.whole_maps;
  }
  wanted = whole_->parts;
  for (const Sent& update : updates_)
    if (update.seq > whole_->seq)
      wanted.insert(wanted.end(), update.parts.begin(), update.parts.end());
}

void MapPublisher::answer(const map_request_t& request, TimePoint now) {
  if (map_.seq() == 0) return;
  ++counts_.requests;
  std::vector<std::shared_ptr<OutgoingMessage>> wanted;
  if (!find_wanted(request, wanted)) add_whole(wanted);
  for (const auto& message : wanted) {
    const bool is_under_way = message->waits || now < message->sent_at + kRepeat;
    if (is_under_way) continue;
    outbox_.push(message);
    ++counts_.parts_again;
  }
}

}  // namespace eifmap
