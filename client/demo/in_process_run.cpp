#include "client/demo/in_process_run.h"

#include <atomic>
#include <condition_variable>
#include <lcm/lcm-cpp.hpp>
#include <mutex>
#include <thread>

#include "bus/lcm_bus.h"
#include "client/logger.h"
#include "client/map_points.h"
#include "server/mapping_server.h"

namespace eifmap {
namespace {

using std::chrono::milliseconds;

// Keeps the publisher a few images ahead of the mapper, so that both have work and memory stays
// small.
class Window {
 public:
  static constexpr std::int64_t kAhead = 4;

  void set_done(std::int64_t done) {
    const std::lock_guard lock(mutex_);
    done_ = done;
    changed_.notify_all();
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  // Until image i may be made; false when the run was stopped.
  bool wait_for_turn(int i) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this, i] { return closed_ || i < done_ + kAhead; });
    return !closed_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t done_ = 0;
  bool closed_ = false;
};

// Images that the server has mapped or refused.
std::int64_t answered(const Logger& logger) {
  return logger.counts().poses + logger.last_status().frames_rejected;
}

std::string last_words(const status_t& status) {
  if (status.level == status_t::LEVEL_OK || status.message.empty()) return "";
  return status.message + (status.hint.empty() ? "" : ": " + status.hint);
}

// Publishes in a thread of its own.
class PublisherThread {
 public:
  PublisherThread(ImageSource& source, PublishAs as, Bus& bus, const std::string& camera)
      : thread_([this, &source, as, &bus, camera] {
          PublishOptions options;
          options.camera = camera;
          options.as = as;
          options.rate_hz = 0;
          try {
            result_ =
                publish(source, options, bus, [this](int i) { return window_.wait_for_turn(i); });
          } catch (const std::exception& error) {
            result_.problem = error.what();
          }
          finished_ = true;
        }) {}
  ~PublisherThread() { join(); }

  void set_done(std::int64_t done) { window_.set_done(done); }
  bool finished() const { return finished_; }
  const PublishResult& join() {
    window_.close();
    if (thread_.joinable()) thread_.join();
    return result_;
  }

 private:
  Window window_;
  PublishResult result_;
  std::atomic<bool> finished_ = false;
  std::thread thread_;  // last: it uses the others
};

// Until the server has answered every image that was published and its map is out. Returns "" or
// why it ended before.
std::string map_all(PublisherThread& publisher, const Logger& logger, MappingServer& server,
                    Bus& bus, const InProcessProgress& progress) {
  const auto done = [&] {
    return publisher.finished() && answered(logger) >= publisher.join().published &&
           server.wait_until_idle(milliseconds(1));
  };
  while (!done()) {
    if (!bus.receive(milliseconds(20))) return "the memq:// bus broke";
    publisher.set_done(answered(logger));
    if (!progress(static_cast<int>(answered(logger)))) return "stopped";
  }
  return publisher.join().problem;
}

}  // namespace

InProcessResult run_in_process(ImageSource& source, const InProcessOptions& options,
                               const InProcessProgress& progress) {
  const std::string camera = "demo";
  const auto lcm = std::make_shared<lcm::LCM>("memq://");
  LcmBus server_bus(lcm), client_bus(lcm), view_bus(lcm);
  ServerConfig config;
  config.camera = camera;
  config.input = InputMode::kLossless;
  const auto opened = Logger::open(options.output / "log", camera, client_bus);
  InProcessResult result;
  result.problem = opened.problem;
  if (!opened.logger) return result;
  Logger& logger = *opened.logger;
  std::optional<ViewFeed> feed;
  if (options.view) feed.emplace(camera, *options.view, view_bus);
  MappingServer server(config, server_bus);

  {
    PublisherThread publisher(source, options.as, client_bus, camera);
    result.problem = map_all(publisher, logger, server, client_bus, progress);
    result.published = publisher.join().published;
  }
  server.stop();
  for (int i = 0; i < 100 && !logger.server_stopped(); ++i) client_bus.receive(milliseconds(20));

  result.poses = logger.counts().poses;
  result.tracked = logger.counts().tracked;
  result.last_words = last_words(logger.last_status());
  for (const std::string& problem : {logger.finish(), server.write_results(options.output)})
    if (result.problem.empty()) result.problem = problem;
  result.points = points_of(logger.map().map());
  return result;
}

}  // namespace eifmap
