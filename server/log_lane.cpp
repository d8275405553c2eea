#include "server/log_lane.h"

#include <algorithm>
#include <optional>

#include "convert/feature_message.h"
#include "convert/image_message.h"

namespace eifmap {
namespace {

std::optional<FrameName> name_of_frame(ChannelKind kind, Bytes bytes) {
  if (kind == ChannelKind::kImage) {
    const Decoded<ImageMessage> image = decode_image(bytes);
    if (!image.ok()) return {};
    return FrameName{image.value.time_us, image.value.publisher, image.value.seq};
  }
  const Decoded<FeatureFrame> frame = decode_features(bytes);
  if (!frame.ok()) return {};
  return FrameName{frame.value.time_us, frame.value.publisher, frame.value.seq};
}

// The first few of them.
std::string named(const std::vector<FrameName>& names) {
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, names.size()); ++i)
    text += (i > 0 ? ", " : "") + in_words(names[i]);
  return names.size() > kNamed ? text + ", ..." : text;
}

const LogContents::Run& run_of(const LogContents::Camera& contents, std::int64_t epoch,
                               const LogContents::Run& none) {
  const auto found = contents.runs.find(epoch);
  return found == contents.runs.end() ? none : found->second;
}

}  // namespace

const LogContents::Run LogLane::kNoRun;

LogLane::LogLane(const ServerConfig& config, const LogContents::Camera& contents,
                 std::int64_t epoch, bool obeys)
    : camera_(config.camera),
      obeys_(obeys),
      contents_(contents),
      run_(run_of(contents, epoch, kNoRun)),
      mapper_(config, handover(config)) {
  for (const Decision& decision : run_.decisions) open_[name_of(decision)].push_back(&decision);
}

Handover LogLane::handover(const ServerConfig& config) const {
  if (!obeys_) return config.recorded_handover();
  Handover handover;
  const auto at_once = [](const Decision& d) { return d.adopted_job == kAdoptedAtOnce; };
  if (std::any_of(run_.decisions.begin(), run_.decisions.end(), at_once)) return handover;
  handover.when = Handover::When::kAsRecorded;
  handover.recorded = [this](const FeatureFrame&) {
    return current_ && current_->adopted_job != 0;
  };
  return handover;
}

void LogLane::take_measurement(Bytes bytes) {
  if (!obeys_) mapper_.take_measurement(camera_, bytes);
}

// Nothing on a frame that the server passed over, or refused.
const Decision* LogLane::decision_on(ChannelKind kind, Bytes bytes) {
  const std::optional<FrameName> name = name_of_frame(kind, bytes);
  const auto found = name ? open_.find(*name) : open_.end();
  if (found == open_.end()) return nullptr;
  const Decision* decision = found->second.front();
  found->second.pop_front();
  if (found->second.empty()) open_.erase(found);
  return decision;
}

void LogLane::take_frame(ChannelKind kind, Bytes bytes) {
  if (!obeys_) {
    mapper_.take_frame({camera_, kind}, bytes);
    ++mapped_;
  } else if (const Decision* decision = decision_on(kind, bytes)) {
    obey(*decision, kind, bytes);
    ++mapped_;
  }
}

void LogLane::give_measurements(const Decision& decision) {
  for (const MeasurementId& id : decision.measurements) {
    const auto found = contents_.measurements.find(id);
    if (found != contents_.measurements.end())
      mapper_.take_measurement(camera_, found->second);
    else
      ++measurements_missing_;
  }
}

void LogLane::obey(const Decision& decision, ChannelKind kind, Bytes bytes) {
  current_ = &decision;
  give_measurements(decision);
  CameraMapper::Mapped mapped = mapper_.take_frame({camera_, kind}, bytes);
  // The server took it although it is older than the one before: because it had refused enough of
  // such, of which there are no decisions, that it believed the new times. So does this one.
  for (int i = 0; i < Mapper::kPatience && mapped.result.reason == Reason::kTimeNotIncreasing; ++i)
    mapped = mapper_.take_frame({camera_, kind}, bytes);
  current_ = nullptr;
  compare(decision, mapped.result);
}

void LogLane::compare(const Decision& decision, const FrameResult& result) {
  const std::int64_t digest = decision_of(result).state_digest;
  if (!first_other_.empty() || (!result.rejected && digest == decision.state_digest)) return;
  first_other_ = in_words(name_of(decision)) + " is the first that comes out otherwise: digest " +
                 std::to_string(digest) + ", recorded " + std::to_string(decision.state_digest);
  if (result.rejected)
    first_other_ +=
        std::string(" (refused now: ") + describe(result.reason).name + ", " + result.detail + ")";
}

void LogLane::finish() {
  mapper_.adopt_keyframe(true);
}

// What the logger lost.
std::string LogLane::what_is_missing() const {
  std::vector<FrameName> frames, decisions;
  for (const auto& [name, open] : open_) frames.insert(frames.end(), open.size(), name);
  std::set<FrameName> decided;
  for (const Decision& decision : run_.decisions) decided.insert(name_of(decision));
  std::set_difference(run_.posed.begin(), run_.posed.end(), decided.begin(), decided.end(),
                      std::back_inserter(decisions));
  std::string text;
  if (!frames.empty())
    text += std::to_string(frames.size()) + " of the " + std::to_string(run_.decisions.size()) +
            " frames that were mapped are not in the log: " + named(frames);
  if (!decisions.empty())
    text += (text.empty() ? "" : "; ") + std::to_string(decisions.size()) +
            " decisions on frames that have a pose are not in the log: " + named(decisions);
  if (measurements_missing_ > 0)
    text += (text.empty() ? "" : "; ") + std::to_string(measurements_missing_) +
            " absolute measurements that had a part in the run are not in the log";
  return text;
}

std::vector<std::string> LogLane::departures() const {
  std::vector<std::string> departures;
  if (!obeys_) return departures;
  const std::string missing = what_is_missing();
  if (!missing.empty()) departures.push_back("camera " + camera_ + ": " + missing);
  if (!first_other_.empty())
    departures.push_back("camera " + camera_ + ": " + first_other_ +
                         (missing.empty()
                              ? "; the log must begin before the run does, and the settings, the "
                                "program and the type of CPU be those of that run"
                              : ""));
  return departures;
}

}  // namespace eifmap
