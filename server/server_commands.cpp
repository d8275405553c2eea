#include "server/server_commands.h"

#include <utility>

#include "wire/channel.h"

namespace eifmap {
namespace {

std::string listed(const std::vector<ServerCommands::Camera>& cameras) {
  std::string names;
  for (const auto& camera : cameras) names += (names.empty() ? "" : " ") + camera.name;
  return names;
}

// Of several, by camera; of one as it is.
void append(CommandOutcome& all, CommandOutcome one, const std::string& camera, bool several) {
  for (auto& [key, value] : one.values)
    all.values.emplace_back(several ? camera + "." + key : key, std::move(value));
  const bool is_first = all.message.empty();
  all.message += (is_first ? "" : "; ") + (several ? camera + ": " : "") + one.message;
  // The first that was not simply done says what became of it.
  if (all.reason != Reason::kNone || one.result == reply_t::RESULT_OK) return;
  all.result = one.result;
  all.reason = one.reason;
}

}  // namespace

ServerCommands::ServerCommands(CommandAccess access, Bus& bus, Cameras cameras, OnCounts on_counts)
    : bus_(bus),
      cameras_(std::move(cameras)),
      on_counts_(std::move(on_counts)),
      reply_channel_(channel_name(kNoCamera, ChannelKind::kReply)),
      desk_(std::string(kNoCamera), std::move(access), *this),
      thread_(&ServerCommands::run, this) {}

ServerCommands::~ServerCommands() {
  stop();
}

void ServerCommands::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void ServerCommands::receive(Bytes bytes) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() == kMostWaiting) return;
    waiting_.emplace_back(bytes.begin(), bytes.end());
  }
  changed_.notify_all();
}

bool ServerCommands::told_to_stop() const {
  const Clock::rep at = stop_at_;
  return at != 0 && Clock::now().time_since_epoch().count() >= at;
}

void ServerCommands::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !waiting_.empty(); });
    if (stopping_) return;
    const std::vector<std::uint8_t> bytes = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    try {
      answer(bytes);
    } catch (const std::exception&) {
      // Memory alone: not answered, and so sent again.
    }
    lock.lock();
  }
}

void ServerCommands::answer(const std::vector<std::uint8_t>& bytes) {
  const auto reply = desk_.answer(bytes, Clock::now());
  if (on_counts_) on_counts_(desk_.counts());
  if (reply) bus_.publish(reply_channel_, *reply);
}

// Not while it is stopped.
bool ServerCommands::wait(const std::future<CommandOutcome>& outcome, Clock::time_point deadline) {
  constexpr std::chrono::milliseconds kSlice(20);
  while (outcome.wait_for(kSlice) != std::future_status::ready) {
    const std::lock_guard lock(mutex_);
    if (stopping_ || Clock::now() >= deadline) return false;
  }
  return true;
}

CommandOutcome ServerCommands::do_to_all(const char* what, const Action& action) {
  const std::vector<Camera> cameras = cameras_();
  if (cameras.empty())
    return CommandOutcome::refuse(Reason::kNoMap,
                                  std::string(what) + " needs a camera that is mapped");
  std::vector<std::future<CommandOutcome>> outcomes;
  for (const Camera& camera : cameras) outcomes.push_back(camera.command(action));
  CommandOutcome all;
  const auto deadline = Clock::now() + kPatience;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    CommandOutcome one;
    if (!wait(outcomes[i], deadline))
      one = {reply_t::RESULT_BUSY, Reason::kNone, "it is busy, and will do it later"};
    else
      one = outcomes[i].get();
    append(all, std::move(one), cameras[i].name, cameras.size() > 1);
  }
  return all;
}

// Without asking any of them: they may be busy.
CommandOutcome ServerCommands::ping() {
  return {reply_t::RESULT_OK, Reason::kNone, "here", {{"cameras", listed(cameras_())}}};
}

CommandOutcome ServerCommands::pause() {
  return do_to_all("pause", [](CommandTarget& camera) { return camera.pause(); });
}

CommandOutcome ServerCommands::resume() {
  return do_to_all("resume", [](CommandTarget& camera) { return camera.resume(); });
}

CommandOutcome ServerCommands::reset() {
  return do_to_all("reset", [](CommandTarget& camera) { return camera.reset(); });
}

CommandOutcome ServerCommands::maps() {
  return do_to_all("map", [](CommandTarget& camera) { return camera.maps(); });
}

CommandOutcome ServerCommands::snapshot() {
  return do_to_all("snapshot", [](CommandTarget& camera) { return camera.snapshot(); });
}

CommandOutcome ServerCommands::set_scale(double metres_per_unit, double sigma) {
  const std::vector<Camera> cameras = cameras_();
  if (cameras.size() > 1)
    return CommandOutcome::refuse(Reason::kBadArguments,
                                  "every map has a scale of its own: name one "
                                  "of " +
                                      listed(cameras) + " by --camera");
  return do_to_all("set-scale",
                   [=](CommandTarget& camera) { return camera.set_scale(metres_per_unit, sigma); });
}

CommandOutcome ServerCommands::shutdown() {
  stop_at_ = (Clock::now() + kLinger).time_since_epoch().count();
  return {reply_t::RESULT_OK, Reason::kNone, "the server ends"};
}

CommandOutcome ServerCommands::save(const std::string& name) {
  return do_to_all("save", [name](CommandTarget& camera) { return camera.save(name); });
}

CommandOutcome ServerCommands::load(const std::string& name) {
  return do_to_all("load", [name](CommandTarget& camera) { return camera.load(name); });
}

CommandOutcome ServerCommands::checkpoint() {
  return do_to_all("checkpoint", [](CommandTarget& camera) { return camera.checkpoint(); });
}

CommandOutcome ServerCommands::undo() {
  return do_to_all("undo", [](CommandTarget& camera) { return camera.undo(); });
}

CommandOutcome ServerCommands::localize_only(bool on) {
  return do_to_all("localize-only",
                   [on](CommandTarget& camera) { return camera.localize_only(on); });
}

}  // namespace eifmap
