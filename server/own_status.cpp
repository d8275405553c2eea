#include "server/own_status.h"

#include <algorithm>
#include <utility>

#include "convert/status_message.h"

namespace eifmap {
namespace {

// News are told at most this often: who makes up names of cameras must not flood the network.
constexpr std::chrono::milliseconds kNewsPeriod(200);

// Of cameras refused; of more it is only counted what comes.
constexpr std::size_t kMostNames = 64;

}  // namespace

OwnStatus::OwnStatus(double period_s, Bus& bus, std::int64_t server_epoch, OnChange on_change)
    : period_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(period_s))),
      bus_(bus),
      on_change_(std::move(on_change)),
      board_(server_epoch),
      thread_(&OwnStatus::run, this) {}

OwnStatus::~OwnStatus() {
  begin_stop();
  end();
}

void OwnStatus::note_bad_channel() {
  const std::lock_guard lock(mutex_);
  ++counts_.bad_channels;
}

void OwnStatus::note_commands(const CommandDesk::Counts& counts) {
  const std::lock_guard lock(mutex_);
  counts_.commands = counts;
}

void OwnStatus::note_camera() {
  const std::lock_guard lock(mutex_);
  ++mapped_;
}

void OwnStatus::refuse(const std::string& camera, bool is_frame, Reason reason,
                       const std::string& detail) {
  const std::lock_guard lock(mutex_);
  counts_.foreign_frames += is_frame ? 1 : 0;
  if (refused_.size() >= kMostNames || !refused_.insert(camera).second) return;
  board_.note_reason(reason, "camera " + camera + ": " + detail);
  has_news_ = true;
  changed_.notify_all();
}

void OwnStatus::note_lost_measurement() {
  const std::lock_guard lock(mutex_);
  ++lost_measurements_;
}

bool OwnStatus::has_something_to_say() const {
  return mapped_ == 0 || !refused_.empty() || counts_.bad_channels > 0 ||
         !counts_.commands.refused.empty();
}

void OwnStatus::run() {
  std::unique_lock lock(mutex_);
  Clock::time_point next = Clock::now();
  while (!stopping_) {
    const bool is_due = Clock::now() >= next, is_news = std::exchange(has_news_, false);
    if (is_due) next = Clock::now() + period_;
    if ((is_due || is_news) && has_something_to_say()) publish(lock, is_due, is_news);
    changed_.wait_for(lock, std::min<Clock::duration>(kNewsPeriod, period_),
                      [this] { return stopping_; });
    changed_.wait_until(lock, next, [this] { return stopping_ || has_news_; });
  }
  board_.note_stopping();
  if (has_something_to_say()) publish(lock, true, true);
}

status_t OwnStatus::make_status(bool new_period) {
  status_t status = board_.make("", counts_, {}, {}, Clock::now(), new_period);
  const auto say = [&status](const char* key, std::int64_t value) {
    diagnostic_t entry;
    entry.key = key;
    entry.value = std::to_string(value);
    status.diagnostics.push_back(std::move(entry));
  };
  say("cameras.mapped", mapped_);
  say("cameras.refused", static_cast<std::int64_t>(refused_.size()));
  say("cameras.lost_measurements", lost_measurements_);
  status.num_diagnostics = static_cast<std::int32_t>(status.diagnostics.size());
  return status;
}

// The lock is released while others are told: they may take their time.
void OwnStatus::publish(std::unique_lock<std::mutex>& lock, bool new_period, bool is_news) {
  const status_t status = make_status(new_period);
  lock.unlock();
  bool sent = false;
  std::string fault;
  try {
    sent = bus_.publish(channel_name(kNoCamera, ChannelKind::kStatus), encode(status));
  } catch (const std::exception&) {
    // Lost, as on a network.
  }
  try {
    if (is_news && on_change_) on_change_(status);
  } catch (const std::exception& error) {
    fault = error.what();
  }
  lock.lock();
  if (!sent) board_.note_send_failure();
  if (!fault.empty()) board_.note_fault(fault);
}

status_t OwnStatus::now() {
  const std::lock_guard lock(mutex_);
  return make_status(false);
}

void OwnStatus::begin_stop() {
  const std::lock_guard lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
}

void OwnStatus::end() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace eifmap
