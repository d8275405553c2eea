#include "server/diagnostics.h"

#include <array>
#include <cstdio>
#include <utility>

#include "names.h"
#include "wire/limits.h"

namespace eifmap {
namespace {

// Of each kind of measurement, next to what chance may do to it.
void describe_nis(const MapperStatistics& statistics, Diagnostics& out) {
  for (const auto& [kind, nis] : statistics.nis) {
    if (nis.count == 0) continue;
    const std::string prefix = "nis." + std::string(name(kind));
    out.add(prefix + ".ratio", nis.ratio);
    out.add(prefix + ".sigma", nis.sigma);
    out.add(prefix + ".count", std::int64_t{nis.count});
    out.add(prefix + ".beyond", std::int64_t{nis.beyond});
  }
}

}  // namespace

void Diagnostics::add(const std::string& key, std::string value) {
  diagnostic_t entry;
  entry.key = key;
  entry.value = std::move(value);
  status_.diagnostics.push_back(std::move(entry));
  status_.num_diagnostics = static_cast<std::int32_t>(status_.diagnostics.size());
}

void Diagnostics::add(const std::string& key, std::int64_t value) {
  add(key, std::to_string(value));
}

void Diagnostics::add(const std::string& key, double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  add(key, std::string(text.data()));
}

void Diagnostics::add(const std::string& prefix, const std::map<Reason, std::int64_t>& counts) {
  for (const auto& [reason, count] : counts)
    add(prefix + std::string(describe(reason).name), count);
}

void describe_mapping(const MapperStatistics& statistics, Diagnostics& out) {
  for (const auto& [source, count] : statistics.sources)
    out.add("poses." + std::string(name(source)), count);
  out.add("frames.", statistics.reasons);
  describe_nis(statistics, out);
  out.add("bound.removed_keyframes", statistics.removed_keyframes);
  out.add("bound.removed_landmarks", statistics.removed_landmarks);
  out.add("loops.closed", statistics.loops.closed);
  out.add("loops.joined", statistics.loops.joined);
  out.add("loops.refused.", statistics.loops.refused);
  out.add("submaps.kept", statistics.submaps.kept);
  out.add("submaps.returned", statistics.submaps.returned);
  out.add("submaps.merged", statistics.submaps.merged);
  out.add("submaps.refused.", statistics.submaps.refused);
  out.add("moving.most", statistics.most_moving);
  out.add("moving.frames", statistics.frames_with_moving);
}

void describe_measurements(const MeasurementIntake::Counts& intake, std::int64_t dropped,
                           const MapperStatistics& statistics, Diagnostics& out) {
  if (intake.arrived + dropped == 0) return;
  MeasurementCounts counts = intake.refused;
  counts += statistics.measurements;
  out.add("measurements.arrived", intake.arrived);
  out.add("measurements.missing", intake.missing);
  out.add("measurements.dropped", dropped);
  out.add("measurements.waiting", statistics.measurements_waiting);
  for (const auto& [kind, count] : counts.kinds) {
    const std::string prefix = "measurements." + std::string(name(kind));
    out.add(prefix + ".used", count.used);
    out.add(prefix + ".refused", count.refused);
    out.add(prefix + ".dropped", count.dropped);
  }
  out.add("measurements.refused.", counts.refusals);
}

// The publisher of now as publisher.*, the few before it as publisher.before_1.* and so on. Of
// those forgotten, the missing frames stay in sequence_gaps.
void describe_streams(const StreamBook& streams, Diagnostics& out) {
  out.add("publisher_restarts", streams.restarts());
  for (std::size_t i = 0; i < streams.streams().size(); ++i) {
    const StreamCounts& counts = streams.streams()[i];
    const std::string prefix =
        i == 0 ? "publisher." : "publisher.before_" + std::to_string(i) + ".";
    out.add(prefix + "id", counts.publisher);
    out.add(prefix + "frames", counts.frames);
    out.add(prefix + "missing", counts.missing);
    out.add(prefix + "reordered", counts.reordered);
    out.add(prefix + "duplicates", counts.duplicates);
    if (counts.clock_offset_us) out.add(prefix + "clock_offset_us", *counts.clock_offset_us);
  }
}

void describe_parts(const FeatureAssembler::Counts& parts, Diagnostics& out) {
  if (parts.whole + parts.incomplete == 0) return;
  out.add("split_frames.whole", parts.whole);
  out.add("split_frames.incomplete", parts.incomplete);
  out.add("split_frames.missing_parts", parts.missing_parts);
  out.add("split_frames.late_parts", parts.late_parts);
}

void describe_requests(const MapPublisher::Counts& maps, Diagnostics& out) {
  out.add("map_requests", maps.requests);
  out.add("map_parts_again", maps.parts_again);
  out.add("map_whole_again", maps.whole_maps);
}

void describe_commands(const CommandDesk::Counts& commands, Diagnostics& out) {
  if (commands.done + commands.pings == 0 && commands.refused.empty()) return;
  out.add("commands.done", commands.done);
  out.add("commands.pings", commands.pings);
  out.add("commands.repeated", commands.repeated);
  out.add("commands.refused.", commands.refused);
  if (!commands.last.empty()) out.add("commands.last", clipped(commands.last));
}

}  // namespace eifmap
