#include "server/log_run.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <utility>

#include "server/log_lane.h"
#include "server/part_collector.h"
#include "server/run_record.h"

namespace eifmap {
namespace {

// What is not in a clock's range says nothing.
PartCollector::Clock::time_point time_of(const EventLog& log) {
  constexpr std::int64_t kLastUs = std::int64_t{1} << 52;
  return PartCollector::Clock::time_point{
      std::chrono::microseconds(std::clamp<std::int64_t>(log.time_us(), 0, kLastUs))};
}

class LogRun {
 public:
  LogRun(const LogRunOptions& options, const Progress& progress, const Note& note)
      : options_(options), progress_(progress), note_(note) {}

  LogRunResult run() {
    if (std::string problem = output_problem(options_.output); !problem.empty())
      return {problem, ""};
    contents_ = read_contents(EventLog(options_.log), options_.config.image_channel,
                              options_.config.camera);
    for (const auto& step : {&LogRun::choose_run, &LogRun::make_lanes})
      if (std::string problem = (this->*step)(); !problem.empty()) return {problem, ""};
    map();
    return finish();
  }

 private:
  using Clock = PartCollector::Clock;

  std::string choose_run();
  std::string choose_among(const std::map<std::int64_t, std::int64_t>& epochs);
  std::string make_lanes();
  void map();
  void take(EventLog& log, const Channel& channel);
  LogRunResult finish();
  void warn(const std::string& text) const {
    if (note_) note_(text);
  }

  const LogRunOptions& options_;
  const Progress& progress_;
  const Note& note_;
  LogContents contents_;
  std::int64_t epoch_ = 0, expected_ = 0;
  bool obeys_ = false, stopped_ = false;
  FeatureAssembler::Counts parts_;
  std::map<std::string, std::unique_ptr<LogLane>> lanes_;
};

// Of several the one that decided most.
std::string LogRun::choose_among(const std::map<std::int64_t, std::int64_t>& epochs) {
  if (!options_.epoch) {
    epoch_ = std::max_element(epochs.begin(), epochs.end(), [](const auto& a, const auto& b) {
               return a.second < b.second;
             })->first;
    if (epochs.size() == 1) return "";
  } else if (!epochs.contains(*options_.epoch)) {
    std::string text = options_.log.string() + ": has no decisions of the run " +
                       std::to_string(*options_.epoch) + "; --epoch may be";
    for (const auto& [epoch, decisions] : epochs) text.append(" ").append(std::to_string(epoch));
    return text;
  } else {
    epoch_ = *options_.epoch;
  }
  if (!options_.epoch)
    warn("the log has decisions of " + std::to_string(epochs.size()) +
         " runs of the server: that of server_epoch " + std::to_string(epoch_) +
         " is made again, which has the most (" + std::to_string(epochs.at(epoch_)) +
         "); another one by --epoch");
  return "";
}

std::string LogRun::choose_run() {
  if (contents_.cameras.empty() && !contents_.problem.empty()) return contents_.problem;
  if (contents_.unreadable > 0)
    warn(std::to_string(contents_.unreadable) +
         " decisions, poses or measurements of the log cannot be read, and are left out");
  const auto epochs = contents_.epochs();
  obeys_ = !epochs.empty();
  if (obeys_) return choose_among(epochs);
  if (options_.verify || options_.epoch)
    return options_.log.string() + ": has no decisions of a server to compare with; leave out " +
           (options_.verify ? "--verify" : "--epoch");
  warn("the log has no decisions of a server: every frame of it is mapped");
  return "";
}

std::string LogRun::make_lanes() {
  std::string named;
  for (const auto& [name, camera] : contents_.cameras) {
    const auto run = camera.runs.find(epoch_);
    const bool decided = run != camera.runs.end() && !run->second.decisions.empty();
    if (obeys_ ? !decided : camera.frames == 0) continue;
    named += " " + name;
    if (!options_.config.camera.empty() && name != options_.config.camera) continue;
    ServerConfig config = options_.config;
    config.camera = name;
    lanes_.emplace(name, std::make_unique<LogLane>(config, camera, epoch_, obeys_));
    expected_ += obeys_ ? static_cast<std::int64_t>(run->second.decisions.size()) : camera.frames;
  }
  if (!lanes_.empty()) return "";
  if (named.empty())
    return options_.log.string() + ": has no frames; record eifmap.* with lcm-logger";
  return options_.log.string() + ": has nothing of camera " + options_.config.camera + ", but of" +
         named;
}

void LogRun::take(EventLog& log, const Channel& channel) {
  const auto found = lanes_.find(channel.camera);
  if (found == lanes_.end()) return;
  if (channel.kind == ChannelKind::kCalibration)
    found->second->take_calibration(log.read_message());
  else if (channel.kind == ChannelKind::kMeasurement)
    found->second->take_measurement(log.read_message());
  else if (channel.kind == ChannelKind::kImage)
    found->second->take_frame(channel.kind, log.read_message());
}

// Parts of features are put together as the server did it, by the logger's clock.
void LogRun::map() {
  std::map<std::string, PartCollector> parts;  // by camera
  for (auto& [name, lane] : lanes_)
    parts.try_emplace(
        name, [&of = *lane](Bytes frame, bool) { of.take_frame(ChannelKind::kFeatures, frame); });
  const auto give_up_silent = [&parts](Clock::time_point now) {
    for (auto& [name, collector] : parts) collector.give_up_silent(now);
  };
  EventLog log(options_.log);
  const auto mapped = [this] {
    std::int64_t sum = 0;
    for (const auto& [name, lane] : lanes_) sum += lane->mapped();
    return static_cast<int>(sum);
  };
  while (log.next() && !stopped_) {
    stopped_ = !progress_(mapped(), static_cast<int>(std::max<std::int64_t>(expected_, mapped())));
    const Clock::time_point now = time_of(log);
    give_up_silent(now);
    const auto channel = channel_of(log, options_.config.image_channel, options_.config.camera);
    if (!channel) continue;
    const auto of = parts.find(channel->camera);
    if (channel->kind == ChannelKind::kFeatures && of != parts.end())
      of->second.take(log.read_message(), now);
    else
      take(log, *channel);
  }
  give_up_silent(Clock::time_point::max());
  for (const auto& [name, collector] : parts) {
    const FeatureAssembler::Counts counts = collector.counts();
    parts_.incomplete += counts.incomplete;
    parts_.missing_parts += counts.missing_parts;
  }
  for (const auto& [name, lane] : lanes_) lane->finish();
  if (!stopped_) progress_(mapped(), mapped());
}

LogRunResult LogRun::finish() {
  std::int64_t frames = 0;
  bool written = false;
  std::vector<std::string> departures;
  if (!contents_.problem.empty()) departures.push_back(contents_.problem);
  for (const auto& [name, lane] : lanes_) {
    frames += lane->mapped();
    for (std::string& departure : lane->departures()) departures.push_back(std::move(departure));
    if (!lane->has_results()) {
      warn("camera " + name + ": none of its frames is calibrated and good: nothing is written");
      continue;
    }
    const auto folder = lanes_.size() > 1 ? options_.output / name : options_.output;
    if (std::string problem = lane->write_results(folder); !problem.empty()) return {problem, ""};
    written = true;
  }
  // The server may have missed the same: then nothing departs.
  if (!departures.empty() && parts_.incomplete > 0)
    departures.push_back("of " + std::to_string(parts_.incomplete) + " frames of features " +
                         std::to_string(parts_.missing_parts) + " parts are not in the log");
  if (!written) return {options_.log.string() + ": no frame of it could be mapped", ""};
  if (stopped_) return {};
  std::string all;
  for (const std::string& departure : departures) {
    if (!all.empty()) all += '\n';
    all += departure;
  }
  if (options_.verify && !all.empty()) return {all, ""};
  if (!all.empty()) warn(all);
  const std::string count = std::to_string(frames) + " frames mapped";
  return {"", obeys_ && all.empty() ? count + ", all with the digests that were recorded" : count};
}

}  // namespace

LogRunResult run_log(const LogRunOptions& options, const Progress& progress, const Note& note) {
  return LogRun(options, progress, note).run();
}

}  // namespace eifmap
