#include "client/logger.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/map_points.h"
#include "convert/earth_fields.h"
#include "convert/scale_fields.h"
#include "names.h"
#include "sequence/decisions_file.h"
#include "sequence/measurements_file.h"
#include "sequence/ply.h"
#include "sequence/tum.h"
#include "wire/channel.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

// Poses and parts that may wait in LCM while the disk is busy.
constexpr int kQueue = 2000;

std::string line_of(const Json& json) {
  // Texts come from the network: what is no UTF-8 is replaced, not thrown about.
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json pose_json(const Rigid3& pose) {
  const auto& [q, t] = pose;
  return {{"position", {t.x(), t.y(), t.z()}}, {"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

// The same keys of a pose and of a status.
void add_scale(Json& json, const ScaleState& scale) {
  json["scale"] = name(scale.status);
  json["metres_per_unit"] = scale.metres_per_unit;
  json["sigma_log_scale"] = scale.sigma;  // null: unknown
}

// Of a status. Nothing more of an earth that is unknown.
void add_earth(Json& json, const EarthState& earth) {
  json["earth"] = name(earth.status);
  if (earth.status == EarthStatus::kUnknown) return;
  const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> rows = earth.covariance;
  json["earth_from_map"] = pose_json(earth.earth_from_map);
  json["earth_covariance"] = std::vector<double>(rows.data(), rows.data() + rows.size());
}

Json json_of(const PublishedPose& message) {
  const FrameResult& result = message.result;
  Json json;
  json["utime"] = result.time_us;
  json["camera"] = message.origin.camera;
  json["publisher"] = result.publisher;
  json["seq"] = result.seq;
  json["server_epoch"] = message.origin.server_epoch;
  json["map_id"] = result.map_id;
  json["map_epoch"] = result.map_epoch;
  json["map_seq"] = result.map_seq;
  add_scale(json, result.scale);
  json["state"] = name(result.state);
  json["source"] = name(result.source);
  json["reason"] = describe(result.reason).name;
  json["matches"] = result.num_matches;
  json["inliers"] = result.num_inliers;
  if (result.state != TrackingState::kTracking) return json;
  json["map_from_camera"] = pose_json(result.map_from_camera);
  json["reference_keyframe"] = result.reference_keyframe;
  json["reference_from_camera"] = pose_json(result.reference_from_camera);
  if (result.covariance_status != CovarianceStatus::kNone)
    json["covariance"] =
        std::vector<double>(result.covariance.data(), result.covariance.data() + 36);
  return json;
}

Json json_of(const status_t& status) {
  Json json;
  json["utime"] = status.utime;
  json["server"] = status.name;
  json["version"] = status.version;
  json["camera"] = status.camera;
  json["state"] = status.state;
  json["level"] = status.level;
  json["reason"] = status.reason;
  json["message"] = status.message;
  json["hint"] = status.hint;
  json["server_epoch"] = status.server_epoch;
  json["map_id"] = status.map_id;
  json["map_epoch"] = status.map_epoch;
  json["map_seq"] = status.map_seq;
  json["map_digest"] = status.map_digest;
  add_scale(json, read_scale(status));
  add_earth(json, read_earth(status));
  json["frames_received"] = status.frames_received;
  json["frames_processed"] = status.frames_processed;
  json["frames_dropped"] = status.frames_dropped;
  json["frames_rejected"] = status.frames_rejected;
  json["sequence_gaps"] = status.sequence_gaps;
  json["bad_messages"] = status.bad_messages;
  json["input_hz"] = status.input_hz;
  json["pose_hz"] = status.pose_hz;
  json["latency_ms_p50"] = status.latency_ms_p50;
  json["latency_ms_p99"] = status.latency_ms_p99;
  json["keyframes"] = status.num_keyframes;
  json["landmarks"] = status.num_landmarks;
  json["nis_ratio"] = status.nis_ratio;
  json["rss_bytes"] = status.rss_bytes;
  for (const diagnostic_t& diagnostic : status.diagnostics)
    json["diagnostics"][diagnostic.key] = diagnostic.value;
  return json;
}

}  // namespace

Logger::Opened Logger::open(const std::filesystem::path& folder, const std::string& camera,
                            Bus& bus) {
  if (!camera.empty() && !valid_camera_name(camera))
    return {nullptr, "camera is '" + camera + "', wanted 1 to 24 characters of A-Z a-z 0-9 _ -"};
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return {nullptr,
            folder.string() + ": cannot be made (" + error.message() + "); give another folder"};
  Opened opened;
  opened.logger.reset(new Logger(folder, camera, bus));
  for (const std::ofstream* file :
       {&opened.logger->trajectory_, &opened.logger->poses_, &opened.logger->statuses_,
        &opened.logger->decisions_, &opened.logger->measurements_})
    if (!*file)
      return {nullptr, folder.string() + ": files in it cannot be written; give another folder"};
  return opened;
}

Logger::Logger(const std::filesystem::path& folder, const std::string& camera, Bus& bus)
    : folder_(folder),
      camera_(camera),
      bus_(bus),
      trajectory_(folder / "trajectory.tum"),
      poses_(folder / "poses.jsonl"),
      statuses_(folder / "status.jsonl"),
      decisions_(folder / "decisions.jsonl"),
      measurements_(folder / "measurements.jsonl"),
      map_(camera, [this](const std::string& channel, const std::vector<std::uint8_t>& bytes) {
        bus_.publish(channel, bytes);
      }) {
  const auto subscribe = [&](std::string_view of, ChannelKind kind,
                             void (Logger::*handler)(const std::string&, Bytes)) {
    bus.subscribe(channel_pattern(of, kind), kQueue,
                  [this, handler](const std::string& channel, Bytes bytes) {
                    if (is_mine(channel)) (this->*handler)(channel, bytes);
                  });
  };
  subscribe(camera, ChannelKind::kPose, &Logger::receive_pose);
  subscribe(camera, ChannelKind::kStatus, &Logger::receive_status);
  subscribe(camera, ChannelKind::kMap, &Logger::receive_map);
  subscribe(camera, ChannelKind::kDecision, &Logger::receive_decision);
  subscribe(camera, ChannelKind::kMeasurement, &Logger::receive_measurement);
  if (!camera.empty() && camera != kNoCamera)
    subscribe(kNoCamera, ChannelKind::kStatus, &Logger::receive_status);
}

Logger::~Logger() {
  bus_.unsubscribe_all();
}

// Poses and statuses that cannot be read are not given to the map's client: none is counted twice.
Logger::Counts Logger::counts() const {
  Counts counts = counts_;
  counts.map_parts = map_.counts().parts;
  counts.malformed += map_.counts().malformed;
  return counts;
}

bool Logger::is_mine(const std::string& channel) {
  const auto parsed = parse_channel(channel);
  if (!parsed) return false;
  return camera_.empty() || parsed->camera == camera_ || parsed->kind == ChannelKind::kStatus;
}

// Poses and map parts tell which server maps the camera, also when it was started anew.
void Logger::take(const Origin& origin) {
  if (camera_.empty()) camera_ = origin.camera;
  for (const NamedMeasurement& measurement : std::exchange(early_, {})) write(measurement);
  server_epoch_ = std::max(server_epoch_.value_or(origin.server_epoch), origin.server_epoch);
  last_message_ = Clock::now();
}

void Logger::receive_pose(const std::string& channel, Bytes bytes) {
  const auto pose = decode_pose(bytes);
  if (!pose.ok()) {
    ++counts_.malformed;
    return;
  }
  take(pose.value.origin);
  map_.receive(channel, bytes.data(), bytes.size());
  const FrameResult& result = pose.value.result;
  ++counts_.poses;
  // Flushed line by line: a logger that is killed leaves what it had.
  poses_ << line_of(json_of(pose.value)) << std::flush;
  paths_[pose.value.origin.server_epoch].add(result);
  if (result.state != TrackingState::kTracking) return;
  ++counts_.tracked;
  trajectory_ << tum_line({result.time_us, result.map_from_camera}) << '\n' << std::flush;
}

void Logger::receive_status(const std::string& channel, Bytes bytes) {
  auto status = decode_status(bytes);
  if (!status.ok()) {
    ++counts_.malformed;
    return;
  }
  const std::string& camera = status.value.camera;
  const std::int64_t epoch = status.value.server_epoch;
  if (camera_.empty()) camera_ = camera;
  // One without a camera is of this one's server as long as that maps none, and then of others.
  const bool is_mine = camera.empty() ? !server_epoch_ : camera == camera_;
  if (!is_mine || (server_epoch_ && epoch != *server_epoch_)) return;
  if (!camera.empty()) server_epoch_ = epoch;
  map_.receive(channel, bytes.data(), bytes.size());
  last_message_ = Clock::now();
  ++counts_.statuses;
  // The last map's scale may become known after the last pose.
  if (const auto path = paths_.find(epoch); path != paths_.end())
    path->second.note_scale(status.value.map_id, read_scale(status.value));
  statuses_ << line_of(json_of(status.value)) << std::flush;
  // While the camera's server is not known, that one without a camera stops says nothing about it.
  server_stopped_ = status.value.state == status_t::STATE_STOPPING &&
                    (camera_.empty() || server_epoch_.has_value());
  last_status_ = std::move(status.value);
}

void Logger::receive_decision(const std::string&, Bytes bytes) {
  const auto decision = decode_decision(bytes);
  if (!decision.ok()) {
    ++counts_.malformed;
    return;
  }
  take(decision.value.origin);
  const auto& [origin, decided] = decision.value;
  decisions_ << line_of(decided, origin.server_epoch) << '\n' << std::flush;
}

void Logger::receive_measurement(const std::string&, Bytes bytes) {
  constexpr std::size_t kMostEarly = 10'000;
  const auto measurement = decode_measurement(bytes);
  if (!measurement.ok())
    ++counts_.malformed;
  else if (!camera_.empty())
    write(measurement.value);
  else if (early_.size() < kMostEarly)
    early_.push_back(measurement.value);
}

void Logger::write(const NamedMeasurement& named) {
  if (named.camera != camera_ || !measured_.insert(named.measurement.id).second) return;
  ++counts_.measurements;
  measurements_ << eifmap::line_of(named.measurement) << '\n' << std::flush;
}

void Logger::receive_map(const std::string& channel, Bytes bytes) {
  const std::int64_t before = map_.counts().parts;
  map_.receive(channel, bytes.data(), bytes.size());
  if (map_.counts().parts == before) return;
  if (camera_.empty()) camera_ = map_.camera();
  last_message_ = Clock::now();
}

// Which of the published maps it is, and whether there was a later one.
std::string Logger::write_map_facts() const {
  const PublishedMap& map = map_.map();
  const Json facts{{"camera", map.camera()},
                   {"server_epoch", map.server_epoch()},
                   {"map_id", map.map_id()},
                   {"map_epoch", map.map_epoch()},
                   {"map_seq", map.seq()},
                   {"map_digest", map.digest()},
                   {"is_last", !map_.is_stale()},
                   {"keyframes", map.keyframes().size()},
                   {"landmarks", map.landmarks().size()},
                   {"observations", map.num_observations()},
                   {"requests", map_.counts().requests}};
  std::ofstream file(folder_ / "map.json");
  file << facts.dump(1) << '\n' << std::flush;
  return file ? "" : (folder_ / "map.json").string() + ": cannot be written; is the disk full?";
}

// So far it has each pose in the unit of its time.
std::string Logger::finish_trajectory() {
  std::vector<TimedPose> poses;
  bool differs = false;
  for (const auto& [epoch, path] : paths_) {
    const std::vector<TimedPose> more = path.poses();
    poses.insert(poses.end(), more.begin(), more.end());
    differs = differs || path.has_become_metric();
  }
  if (!differs) return "";
  trajectory_.close();
  return write_tum(folder_ / "trajectory.tum", poses);
}

std::string Logger::finish() {
  for (std::ofstream* file : {&trajectory_, &poses_, &statuses_, &decisions_, &measurements_})
    if (!file->flush()) return folder_.string() + ": could not be written to the end; is it full?";
  if (std::string problem = finish_trajectory(); !problem.empty()) return problem;
  if (std::string problem = write_map_facts(); !problem.empty()) return problem;
  return write_ply(folder_ / "map.ply", points_of(map_.map()));
}

}  // namespace eifmap
