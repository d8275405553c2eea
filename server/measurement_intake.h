// Absolute measurements on their way from the network to the mapper, which is given them right
// before the next frame.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absolute_measurement.h"
#include "convert/measurement_message.h"
#include "server/stream_book.h"
#include "server/taken.h"
#include "wire/bytes.h"

namespace eifmap {

class MeasurementIntake {
 public:
  // More than `max_waiting` never wait.
  explicit MeasurementIntake(int max_waiting) : max_waiting_(max_waiting) {}

  // A message of a camera's measurement channel. Refused besides what decode_measurement() refuses:
  // another camera's (kMalformedMessage), one that has come already (kMeasurementRepeated), too
  // many (kTooManyMeasurements).
  Taken take(const std::string& camera, Bytes bytes);

  // The server's own, by its own id as a publisher. When they come from the network, too, where
  // they are sent for who logs, nothing is taken, counted or said.
  Taken take_own(const NamedMeasurement& measurement);

  // Those of this camera, in the order of their arrival; of others none are kept.
  std::vector<AbsoluteMeasurement> give(const std::string& camera);

  struct Counts {
    std::int64_t arrived = 0;
    std::int64_t missing = 0;   // by the numbers of their publishers
    MeasurementCounts refused;  // here; one that is malformed has no kind
  };
  Counts counts() const;

 private:
  // Several publish at a time: a receiver of GPS, an odometer.
  static constexpr std::size_t kMaxPublishers = 16;
  bool is_new(const AbsoluteMeasurement& measurement);

  Taken take(NamedMeasurement measurement);

  int max_waiting_;
  std::int64_t own_publisher_ = 0;
  std::vector<NamedMeasurement> waiting_;
  std::vector<std::pair<std::int64_t, StreamBook>> books_;  // by publisher, the last heard first
  std::int64_t forgotten_missing_ = 0;
  Counts counts_;
};

}  // namespace eifmap
