#include "server/metrics_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

namespace eifmap {
namespace {

constexpr double kMicro = 1e-6, kMilli = 1e-3;

enum class Of { kCamera, kServer };

// A field of status_t.
struct FieldMetric {
  std::string_view name, type, help;
  double (*value)(const status_t&);
  Of of = Of::kCamera;
  std::string_view label = "", label_value = "";
};

// A figure by name: where the key ends with '*', that part of it is the label's value; with a '*'
// within, what is there.
struct DiagnosticMetric {
  std::string_view key, name, type, help;
  std::string_view label = "";
  double scale = 1;
  Of of = Of::kCamera;
};

constexpr FieldMetric kFields[] = {
    {"eifmap_start_time_seconds", "gauge", "When the server started, since the Unix epoch.",
     [](const status_t& s) { return kMicro * static_cast<double>(s.start_utime); }, Of::kServer},
    {"eifmap_resident_memory_bytes", "gauge", "Of the server's process.",
     [](const status_t& s) { return static_cast<double>(s.rss_bytes); }, Of::kServer},
    {"eifmap_refused_camera_frames_total", "counter",
     "Frames of cameras that are not mapped, since there are too many.",
     [](const status_t& s) { return static_cast<double>(s.frames_rejected); }, Of::kServer},
    {"eifmap_bad_channels_total", "counter", "Messages on channels that name no camera.",
     [](const status_t& s) { return static_cast<double>(s.bad_messages); }, Of::kServer},
    {"eifmap_status_time_seconds", "gauge", "When the figures are of, since the Unix epoch.",
     [](const status_t& s) { return kMicro * static_cast<double>(s.utime); }},
    {"eifmap_state", "gauge", "0 waiting, 1 starting, 2 tracking, 3 lost, 5 stopping.",
     [](const status_t& s) { return static_cast<double>(s.state); }},
    {"eifmap_level", "gauge", "0 fine, 1 warning, 2 error.",
     [](const status_t& s) { return static_cast<double>(s.level); }},
    {"eifmap_reason", "gauge", "Code of the last refusal or loss, 0 none; see src/reasons.md.",
     [](const status_t& s) { return static_cast<double>(s.reason); }},
    {"eifmap_map_is_safe", "gauge", "1: all that is published of the map is on the disk.",
     [](const status_t& s) { return static_cast<double>(s.map_is_safe); }},
    {"eifmap_frames_received_total", "counter", "Frames that arrived.",
     [](const status_t& s) { return static_cast<double>(s.frames_received); }},
    {"eifmap_frames_processed_total", "counter", "Frames that the mapper took.",
     [](const status_t& s) { return static_cast<double>(s.frames_processed); }},
    {"eifmap_frames_dropped_total", "counter",
     "Frames replaced by a newer one before the mapper was free, or without room.",
     [](const status_t& s) { return static_cast<double>(s.frames_dropped); }},
    {"eifmap_frames_missing_total", "counter", "Frames that never arrived, by their numbers.",
     [](const status_t& s) { return static_cast<double>(s.sequence_gaps); }},
    {"eifmap_bad_messages_total", "counter", "Messages refused before they were decoded.",
     [](const status_t& s) { return static_cast<double>(s.bad_messages); }},
    {"eifmap_map_parts_sent_total", "counter", "Parts of map updates that were sent.",
     [](const status_t& s) { return static_cast<double>(s.parts_sent); }},
    {"eifmap_last_frame_time_seconds", "gauge",
     "Capture of the frame mapped last, since the Unix epoch, by its publisher's clock; 0 none.",
     [](const status_t& s) { return kMicro * static_cast<double>(s.last_frame_utime); }},
    {"eifmap_input_hertz", "gauge", "Frames that arrived, a second, over the last status period.",
     [](const status_t& s) { return static_cast<double>(s.input_hz); }},
    {"eifmap_pose_hertz", "gauge", "Poses a second over the last status period.",
     [](const status_t& s) { return static_cast<double>(s.pose_hz); }},
    {"eifmap_latency_seconds", "gauge", "Reception to publication, of the last 256 frames.",
     [](const status_t& s) { return kMilli * static_cast<double>(s.latency_ms_p50); }, Of::kCamera,
     "quantile", "0.5"},
    {"eifmap_latency_seconds", "gauge", "",
     [](const status_t& s) { return kMilli * static_cast<double>(s.latency_ms_p99); }, Of::kCamera,
     "quantile", "0.99"},
    {"eifmap_map_id", "gauge", "Number of the map in use; 0 none.",
     [](const status_t& s) { return static_cast<double>(s.map_id); }},
    {"eifmap_map_epoch", "gauge", "How often the published map became another.",
     [](const status_t& s) { return static_cast<double>(s.map_epoch); }},
    {"eifmap_map_seq", "gauge", "Number of the last published update of the map; 0 none.",
     [](const status_t& s) { return static_cast<double>(s.map_seq); }},
    {"eifmap_map_is_metric", "gauge", "1: the map's lengths are metres.",
     [](const status_t& s) { return s.scale == status_t::SCALE_METRIC ? 1.0 : 0.0; }},
    {"eifmap_map_metres_per_unit", "gauge", "Of the map as it began.",
     [](const status_t& s) { return s.metres_per_unit; }},
    {"eifmap_map_scale_sigma_ratio", "gauge", "Standard deviation of the scale's logarithm.",
     [](const status_t& s) { return s.sigma_log_scale; }},
    {"eifmap_earth", "gauge", "The map's place in earth: 0 unknown, 1 level, 2 placed.",
     [](const status_t& s) { return static_cast<double>(s.earth); }},
    {"eifmap_keyframes", "gauge", "Of the map.",
     [](const status_t& s) { return static_cast<double>(s.num_keyframes); }},
    {"eifmap_landmarks", "gauge", "Of the map.",
     [](const status_t& s) { return static_cast<double>(s.num_landmarks); }},
    {"eifmap_matches", "gauge", "Of the last frame with the map.",
     [](const status_t& s) { return static_cast<double>(s.num_matches); }},
    {"eifmap_inliers", "gauge", "Of these matches, those that agree with the pose.",
     [](const status_t& s) { return static_cast<double>(s.num_inliers); }},
    {"eifmap_nis_ratio", "gauge",
     "Normalized innovations squared of sights over their expectation; 1: sigmas are right; 0: "
     "cannot be told yet.",
     [](const status_t& s) { return static_cast<double>(s.nis_ratio); }},
};

constexpr DiagnosticMetric kDiagnostics[] = {
    {"cameras.mapped", "eifmap_cameras", "gauge", "Cameras that are mapped.", "", 1, Of::kServer},
    {"cameras.refused", "eifmap_cameras_refused", "gauge",
     "Cameras that are not, since there are too many; counted up to 64.", "", 1, Of::kServer},
    {"cameras.lost_measurements", "eifmap_refused_camera_measurements_total", "counter",
     "Absolute measurements of cameras that are not mapped.", "", 1, Of::kServer},
    {"rejected.*", "eifmap_frames_rejected_total", "counter", "Frames that were refused.",
     "reason"},
    {"maps.saved", "eifmap_map_saves_total", "counter", "Updates whose map is on the disk."},
    {"maps.not_saved", "eifmap_map_save_failures_total", "counter",
     "Updates whose map could not be written to the disk."},
    {"poses.*", "eifmap_poses_total", "counter", "Poses by what they rest on.", "source"},
    {"frames.*", "eifmap_frames_reason_total", "counter",
     "Frames that the mapper took, by the reason it gave.", "reason"},
    {"nis.*.ratio", "eifmap_innovation_ratio", "gauge",
     "Normalized innovations squared over their expectation.", "kind"},
    {"nis.*.sigma", "eifmap_innovation_ratio_sigma", "gauge", "What chance may do to that.",
     "kind"},
    {"nis.*.count", "eifmap_innovations", "gauge", "Innovations that it is of.", "kind"},
    {"nis.*.beyond", "eifmap_innovations_beyond", "gauge", "Of them, far from what was expected.",
     "kind"},
    {"bound.removed_keyframes", "eifmap_removed_keyframes_total", "counter",
     "Keyframes removed at the map's bound."},
    {"bound.removed_landmarks", "eifmap_removed_landmarks_total", "counter",
     "Landmarks removed at the map's bound."},
    {"loops.closed", "eifmap_loops_closed_total", "counter", "Loops closed."},
    {"loops.joined", "eifmap_loops_joined_total", "counter", "Landmarks joined by loops."},
    {"loops.refused.*", "eifmap_loops_refused_total", "counter", "Loops refused.", "reason"},
    {"submaps.kept", "eifmap_submaps", "gauge", "Maps that are kept, besides the one in use."},
    {"submaps.returned", "eifmap_submaps_returned_total", "counter",
     "Times that a kept map came into use again."},
    {"submaps.merged", "eifmap_submaps_merged_total", "counter", "Maps merged."},
    {"submaps.refused.*", "eifmap_submaps_refused_total", "counter", "Merges refused.", "reason"},
    {"moving.now", "eifmap_moving_features", "gauge", "Features on what moves, of the last frame."},
    {"moving.most", "eifmap_moving_features_max", "gauge", "The most of any frame."},
    {"moving.frames", "eifmap_moving_frames_total", "counter", "Frames that show what moves."},
    {"send_failures", "eifmap_send_failures_total", "counter", "Messages that could not be sent."},
    {"parts_dropped", "eifmap_map_parts_dropped_total", "counter",
     "Parts of the map that were not sent in time."},
    {"map_requests", "eifmap_map_requests_total", "counter", "Requests for parts of the map."},
    {"map_parts_again", "eifmap_map_parts_again_total", "counter",
     "Parts of the map that were sent again."},
    {"map_whole_again", "eifmap_map_whole_again_total", "counter",
     "Whole maps put together since somebody asked."},
    {"internal_errors", "eifmap_internal_errors_total", "counter", "Faults inside eifmap."},
    {"publisher_restarts", "eifmap_publisher_restarts_total", "counter",
     "Times that another publisher sent the camera's frames."},
    {"publisher.frames", "eifmap_publisher_frames", "gauge", "Frames of the publisher of now."},
    {"publisher.missing", "eifmap_publisher_frames_missing", "gauge",
     "Of them, those that never arrived."},
    {"publisher.reordered", "eifmap_publisher_frames_reordered", "gauge",
     "Of them, those that came too late."},
    {"publisher.duplicates", "eifmap_publisher_frames_doubled", "gauge",
     "Of them, those that came again."},
    {"publisher.clock_offset_us", "eifmap_publisher_clock_offset_seconds", "gauge",
     "The server's clock less the publisher's, the time on the way included.", "", kMicro},
    {"measurements.arrived", "eifmap_measurements_arrived_total", "counter",
     "Absolute measurements that arrived."},
    {"measurements.missing", "eifmap_measurements_missing_total", "counter",
     "Absolute measurements that never arrived, by their numbers."},
    {"measurements.dropped", "eifmap_measurements_without_room_total", "counter",
     "Absolute measurements dropped for want of room."},
    {"measurements.waiting", "eifmap_measurements_waiting", "gauge",
     "Absolute measurements that wait for their images."},
    {"measurements.refused.*", "eifmap_measurements_refused_by_reason_total", "counter",
     "Absolute measurements refused, by reason.", "reason"},
    {"measurements.*.used", "eifmap_measurements_used_total", "counter",
     "Absolute measurements that hold the map.", "kind"},
    {"measurements.*.refused", "eifmap_measurements_refused_total", "counter",
     "Absolute measurements refused, by kind.", "kind"},
    {"measurements.*.dropped", "eifmap_measurements_dropped_total", "counter",
     "Absolute measurements that went with a redundant keyframe.", "kind"},
    {"calibration_guessed", "eifmap_calibration_is_guessed", "gauge",
     "1: the calibration is a guess from hfov_deg."},
    {"split_frames.whole", "eifmap_split_frames_whole_total", "counter",
     "Frames in parts that arrived whole."},
    {"split_frames.incomplete", "eifmap_split_frames_incomplete_total", "counter",
     "Frames in parts, some of which never arrived."},
    {"split_frames.missing_parts", "eifmap_split_frames_missing_parts_total", "counter",
     "Parts that never arrived, of those."},
    {"split_frames.late_parts", "eifmap_split_frames_late_parts_total", "counter",
     "Parts that came too late or twice."},
};

// What the '*' of the pattern stands for: "" where there is none, nothing where the key is another.
std::optional<std::string_view> match(std::string_view pattern, std::string_view key) {
  const std::size_t star = pattern.find('*');
  if (star == std::string_view::npos)
    return pattern == key ? std::optional<std::string_view>("") : std::nullopt;
  const std::string_view before = pattern.substr(0, star), after = pattern.substr(star + 1);
  if (key.size() <= before.size() + after.size() || !key.starts_with(before) ||
      !key.ends_with(after))
    return std::nullopt;
  key.remove_prefix(before.size());
  key.remove_suffix(after.size());
  if (key.find('.') != std::string_view::npos) return std::nullopt;
  return key;
}

std::string escaped(std::string_view label_value) {
  std::string text;
  for (const char c : label_value) {
    if (c == '\\' || c == '"') text += '\\';
    if (c == '\n')
      text += "\\n";
    else
      text += c;
  }
  return text;
}

std::string number(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "+Inf" : "-Inf";
  std::array<char, 32> text{};
  constexpr double kExact = 9007199254740992;  // 2^53: up to there counts are written out
  const bool whole = value == std::floor(value) && std::abs(value) < kExact;
  const auto end = whole ? std::to_chars(text.begin(), text.end(), static_cast<std::int64_t>(value))
                         : std::to_chars(text.begin(), text.end(), value);
  return {text.data(), end.ptr};
}

class Text {
 public:
  void begin(std::string_view name, std::string_view type, std::string_view help) {
    name_ = name;
    header_ = "# HELP " + name_ + ' ' + std::string(help) + "\n# TYPE " + name_ + ' ' +
              std::string(type) + '\n';
  }
  // A family without any sample is left out.
  void add(const std::string& camera, std::string_view label, std::string_view label_value,
           double value) {
    text_ += std::exchange(header_, "");
    std::string labels;
    if (!camera.empty()) labels += "camera=\"" + escaped(camera) + '"';
    if (!label.empty())
      labels +=
          (labels.empty() ? "" : ",") + std::string(label) + "=\"" + escaped(label_value) + '"';
    text_ += name_ + (labels.empty() ? "" : '{' + labels + '}') + ' ' + number(value) + '\n';
  }
  std::string take() { return std::move(text_); }

 private:
  std::string name_, header_, text_;
};

void add_fields(const std::vector<status_t>& statuses, Text& text) {
  std::string_view last;
  for (const FieldMetric& metric : kFields) {
    if (metric.name != last) text.begin(metric.name, metric.type, metric.help);
    last = metric.name;
    for (const status_t& status : statuses)
      if (status.camera.empty() == (metric.of == Of::kServer))
        text.add(status.camera, metric.label, metric.label_value, metric.value(status));
  }
}

void add_diagnostics(const std::vector<status_t>& statuses, Text& text) {
  for (const DiagnosticMetric& metric : kDiagnostics) {
    text.begin(metric.name, metric.type, metric.help);
    for (const status_t& status : statuses) {
      if (status.camera.empty() != (metric.of == Of::kServer)) continue;
      for (const diagnostic_t& diagnostic : status.diagnostics) {
        const auto label_value = match(metric.key, diagnostic.key);
        if (!label_value) continue;
        double value = 0;
        const char* const end = diagnostic.value.data() + diagnostic.value.size();
        if (std::from_chars(diagnostic.value.data(), end, value).ptr == end)
          text.add(status.camera, metric.label, *label_value, metric.scale * value);
      }
    }
  }
}

// What is no figure, as labels.
void add_info(const std::vector<status_t>& statuses, Text& text) {
  text.begin("eifmap_info", "gauge", "The server's version.");
  for (const status_t& status : statuses)
    if (status.camera.empty()) text.add("", "version", status.version, 1);
}

}  // namespace

bool is_metric(const std::string& diagnostic_key) {
  for (const DiagnosticMetric& metric : kDiagnostics)
    if (match(metric.key, diagnostic_key)) return true;
  return false;
}

std::string metrics_text(const std::vector<status_t>& statuses) {
  Text text;
  add_info(statuses, text);
  add_fields(statuses, text);
  add_diagnostics(statuses, text);
  return text.take();
}

}  // namespace eifmap
