#include "server/measurement_intake.h"

#include <algorithm>

#include "wire/channel.h"

namespace eifmap {

bool MeasurementIntake::is_new(const AbsoluteMeasurement& measurement) {
  const std::int64_t publisher = measurement.id.publisher;
  auto book = std::find_if(books_.begin(), books_.end(),
                           [publisher](const auto& entry) { return entry.first == publisher; });
  if (book == books_.end()) {
    if (books_.size() == kMaxPublishers) {
      forgotten_missing_ += books_.back().second.missing();
      books_.pop_back();
    }
    book = books_.emplace(books_.end(), publisher, StreamBook());
  }
  std::rotate(books_.begin(), book, book + 1);
  // Without its time, by which a book allows a publisher to count anew.
  return books_.front().second.note({publisher, measurement.id.seq}, 0);
}

Taken MeasurementIntake::take_own(const NamedMeasurement& measurement) {
  own_publisher_ = measurement.measurement.id.publisher;
  ++counts_.arrived;
  return take(measurement);
}

Taken MeasurementIntake::take(const std::string& camera, Bytes bytes) {
  Decoded<NamedMeasurement> decoded = decode_measurement(bytes);
  if (decoded.ok() && own_publisher_ != 0 &&
      decoded.value.measurement.id.publisher == own_publisher_)
    return {};
  ++counts_.arrived;
  Taken taken{decoded.reason, std::move(decoded.detail)};
  if (std::string problem = decoded.ok() ? camera_problem(decoded.value.camera, camera) : "";
      !problem.empty())
    taken = {Reason::kMalformedMessage, std::move(problem)};
  if (taken.reason != Reason::kNone) {
    ++counts_.refused.refusals[taken.reason];
    return taken;
  }
  return take(std::move(decoded.value));
}

Taken MeasurementIntake::take(NamedMeasurement named) {
  const AbsoluteMeasurement& m = named.measurement;
  Taken taken;
  if (!is_new(m))
    taken = {Reason::kMeasurementRepeated,
             "publisher " + std::to_string(m.id.publisher) + ", seq " + std::to_string(m.id.seq)};
  else if (static_cast<int>(waiting_.size()) >= max_waiting_)
    taken = {Reason::kTooManyMeasurements, std::to_string(max_waiting_) + " wait for a frame"};
  if (taken.reason == Reason::kNone)
    waiting_.push_back(std::move(named));
  else
    counts_.refused.add(m.kind, taken.reason);
  return taken;
}

std::vector<AbsoluteMeasurement> MeasurementIntake::give(const std::string& camera) {
  std::vector<AbsoluteMeasurement> given;
  for (NamedMeasurement& named : std::exchange(waiting_, {}))
    if (named.camera == camera) given.push_back(named.measurement);
  return given;
}

MeasurementIntake::Counts MeasurementIntake::counts() const {
  Counts counts = counts_;
  counts.missing = forgotten_missing_;
  for (const auto& [publisher, book] : books_) counts.missing += book.missing();
  return counts;
}

}  // namespace eifmap
