#include "server/replay.h"

#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"

namespace eifmap {

std::string Replay::open(const std::filesystem::path& decisions,
                         const std::filesystem::path& measurements) {
  DecisionsFile read = read_decisions(decisions);
  if (!read.problem.empty()) return read.problem;
  file_ = decisions;
  std::size_t named = 0;
  for (const Decision& decision : read.decisions) {
    decisions_[decision.time_us] = decision;
    at_once_ = at_once_ || decision.adopted_job == kAdoptedAtOnce;
    named += decision.measurements.size();
  }
  if (measurements.empty())
    return named == 0 ? ""
                      : decisions.string() + ": " + std::to_string(named) +
                            " absolute measurements had a part in that run; give its "
                            "measurements.jsonl by --measurements";
  const MeasurementsFile given = read_measurements(measurements);
  if (!given.problem.empty()) return given.problem;
  measurements_file_ = measurements;
  for (const AbsoluteMeasurement& m : given.measurements) measurements_.emplace(m.id, m);
  return "";
}

Handover Replay::handover() const {
  Handover handover;
  if (at_once_) return handover;
  handover.when = Handover::When::kAsRecorded;
  handover.recorded = [this](const FeatureFrame& frame) {
    const auto found = decisions_.find(frame.time_us);
    return found != decisions_.end() && found->second.adopted_job != 0;
  };
  return handover;
}

void Replay::restore(FeatureFrame& frame) const {
  const Decision& recorded = decisions_.at(frame.time_us);
  frame.publisher = recorded.publisher;
  frame.seq = recorded.seq;
}

std::vector<AbsoluteMeasurement> Replay::measurements_before(std::int64_t time_us) {
  std::vector<AbsoluteMeasurement> before;
  for (const MeasurementId& id : decisions_.at(time_us).measurements) {
    const auto found = measurements_.find(id);
    if (found != measurements_.end())
      before.push_back(found->second);
    else
      ++missing_;
    ++measured_;
  }
  return before;
}

void Replay::compare(const FrameResult& result) {
  ++compared_;
  if (!departure_.empty()) return;
  const Decision& recorded = decisions_.at(result.time_us);
  if (!result.rejected && decision_of(result).state_digest == recorded.state_digest) return;
  departure_ = "the replay departs from " + file_.string() + " at the image of " +
               std::to_string(result.time_us) +
               " us: give the images, the calibration and the settings of that run, and the same "
               "program on the same type of CPU";
}

// An image or a measurement that is missing is why the next ones come out otherwise.
std::string Replay::departure() const {
  const auto all = static_cast<std::int64_t>(decisions_.size());
  if (missing_ > 0)
    return measurements_file_.string() + ": " + std::to_string(missing_) + " of the " +
           std::to_string(measured_) +
           " measurements that had a part in the run are not in it: give those that were recorded";
  if (compared_ == all) return departure_;
  return file_.string() + ": " + std::to_string(all - compared_) + " of its " +
         std::to_string(all) + " images are not in the sequence: give the one that was recorded";
}

}  // namespace eifmap
