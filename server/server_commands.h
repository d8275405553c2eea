// Commands to a server as a whole, on eifmap.server.command: each is done to all that it maps, and
// answered when all have done it. In a thread of its own, so that neither the receiving thread nor
// a camera waits for another camera.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bus/bus.h"
#include "server/command_desk.h"

namespace eifmap {

class ServerCommands : private CommandTarget {
 public:
  using Action = std::function<CommandOutcome(CommandTarget&)>;
  // One that is mapped. `command` has the action done in its mapping thread, between two frames.
  struct Camera {
    std::string name;
    std::function<std::future<CommandOutcome>(Action)> command;
  };
  using Cameras = std::function<std::vector<Camera>()>;

  // More than so many never wait; who is not answered sends again.
  static constexpr std::size_t kMostWaiting = 100;
  // For one camera. It will have done it later then.
  static constexpr auto kPatience = std::chrono::seconds(30);
  // A server goes on so long after shutdown, to answer who did not get the reply.
  static constexpr auto kLinger = std::chrono::seconds(1);

  // Told of what was commanded so far, after each command.
  using OnCounts = std::function<void(const CommandDesk::Counts&)>;

  // Both are called in its thread. The bus must outlive it.
  ServerCommands(CommandAccess access, Bus& bus, Cameras cameras, OnCounts on_counts = {});
  ~ServerCommands() override;

  // Of one message. From any thread.
  void receive(Bytes bytes);

  // Whether shutdown was commanded, and the time to answer who asks again is over.
  bool told_to_stop() const;

  // What waits is not done.
  void stop();

 private:
  using Clock = std::chrono::steady_clock;

  void run();
  void answer(const std::vector<std::uint8_t>& bytes);
  bool wait(const std::future<CommandOutcome>& outcome, Clock::time_point deadline);
  CommandOutcome do_to_all(const char* what, const Action& action);

  Place place() const override { return {}; }
  CommandOutcome ping() override;
  CommandOutcome pause() override;
  CommandOutcome resume() override;
  CommandOutcome reset() override;
  CommandOutcome maps() override;
  CommandOutcome snapshot() override;
  CommandOutcome set_scale(double metres_per_unit, double sigma) override;
  CommandOutcome shutdown() override;
  CommandOutcome save(const std::string& name) override;
  CommandOutcome load(const std::string& name) override;
  CommandOutcome checkpoint() override;
  CommandOutcome undo() override;
  CommandOutcome localize_only(bool on) override;

  Bus& bus_;
  const Cameras cameras_;
  const OnCounts on_counts_;
  const std::string reply_channel_;
  mutable std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::deque<std::vector<std::uint8_t>> waiting_;
  bool stopping_ = false;
  std::atomic<Clock::rep> stop_at_ = 0;  // 0: it was not told to
  CommandDesk desk_;                     // in its thread alone
  std::thread thread_;
};

}  // namespace eifmap
