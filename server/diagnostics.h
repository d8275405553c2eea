// The figures of a status that have no field of their own, by name: status_t's diagnostics.
#pragma once

#include <cstdint>
#include <eifmap/status_t.hpp>
#include <map>
#include <string>

#include "convert/feature_parts.h"
#include "map_view.h"
#include "reason.h"
#include "server/command_desk.h"
#include "server/map_publisher.h"
#include "server/measurement_intake.h"
#include "server/stream_book.h"

namespace eifmap {

class Diagnostics {
 public:
  // Appends to those of `status`, which must outlive this.
  explicit Diagnostics(status_t& status) : status_(status) {}

  void add(const std::string& key, std::string value);
  void add(const std::string& key, std::int64_t value);
  void add(const std::string& key, double value);  // to three digits
  // One for each reason: `prefix` and the reason's name.
  void add(const std::string& prefix, const std::map<Reason, std::int64_t>& counts);

 private:
  status_t& status_;
};

// Each adds what it has to say, which may be nothing.
void describe_mapping(const MapperStatistics& statistics, Diagnostics& out);
// As the network has them, `dropped` of them on their way to the mapper, and as that made use of
// them.
void describe_measurements(const MeasurementIntake::Counts& intake, std::int64_t dropped,
                           const MapperStatistics& statistics, Diagnostics& out);
void describe_streams(const StreamBook& streams, Diagnostics& out);
void describe_parts(const FeatureAssembler::Counts& parts, Diagnostics& out);
void describe_requests(const MapPublisher::Counts& maps, Diagnostics& out);
void describe_commands(const CommandDesk::Counts& commands, Diagnostics& out);

}  // namespace eifmap
