#include "server/mapping_server.h"

#include <utility>

#include "bus/link.h"
#include "convert/feature_message.h"
#include "wire/clock.h"

namespace eifmap {
namespace {

// The bus's own queue, per subscription, and so of all cameras. When it is full, liblcm drops what
// comes.
constexpr int kQueuedNewest = 30;      // a camera
constexpr int kQueuedLossless = 2000;  // and of parts, of which a frame may have a hundred

bool makes_a_lane(ChannelKind kind) {
  return kind == ChannelKind::kCalibration || kind == ChannelKind::kImage ||
         kind == ChannelKind::kFeatures;
}

// Of a frame in parts, one counts.
bool is_frame(ChannelKind kind, Bytes bytes) {
  if (kind == ChannelKind::kFeatures) return !is_part_of_features(bytes) || is_first_part(bytes);
  return kind == ChannelKind::kImage;
}

const ServerConfig& checked(const ServerConfig& config) {
  if (const std::string problem = config.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  return config;
}

CommandAccess access_of(const ServerConfig& config) {
  CommandAccess access;
  access.server_epoch = now_us();
  access.is_local = stays_on_this_machine(config.lcm_url);
  access.first_ticket = random_ticket();
  access.begin = std::chrono::steady_clock::now();
  if (config.secret_file.empty()) return access;
  SecretFile read = read_secret(config.secret_file);
  if (!read.secret) throw std::invalid_argument("secret_file: " + read.problem);
  access.secret = std::make_shared<const Secret>(std::move(*read.secret));
  return access;
}

}  // namespace

MappingServer::MappingServer(const ServerConfig& config, Bus& bus, OnChange on_change,
                             OnStep on_step, Results results)
    : config_(checked(config)),
      bus_(bus),
      on_change_(std::move(on_change)),
      on_step_(std::move(on_step)),
      results_(results),
      access_(access_of(config)),
      own_status_(config.status_period_s, bus, access_.server_epoch,
                  [this](const status_t& status) { tell(status); }),
      commands_(
          access_, bus, [this] { return commanded(); },
          [this](const CommandDesk::Counts& counts) { own_status_.note_commands(counts); }) {
  subscribe();
}

MappingServer::~MappingServer() {
  stop();
  bus_.unsubscribe_all();
}

void MappingServer::subscribe() {
  const int num_cameras = config_.camera.empty() ? config_.max_cameras : 1;
  const int max_queued =
      config_.input == InputMode::kLossless ? kQueuedLossless : kQueuedNewest * num_cameras;
  const auto queued = [max_queued](ChannelKind kind) {
    return kind == ChannelKind::kFeatures || Inbox::each_counts(kind) ? kQueuedLossless
                                                                      : max_queued;
  };
  for (const ChannelKind kind :
       {ChannelKind::kCalibration, ChannelKind::kImage, ChannelKind::kFeatures,
        ChannelKind::kMeasurement, ChannelKind::kRelativeRequest, ChannelKind::kMapRequest,
        ChannelKind::kCommand})
    bus_.subscribe(channel_pattern(config_.camera, kind), queued(kind),
                   [this](const std::string& channel, Bytes bytes) { receive(channel, bytes); });
  if (!config_.camera.empty())
    bus_.subscribe(channel_pattern(kNoCamera, ChannelKind::kCommand), max_queued,
                   [this](const std::string& channel, Bytes bytes) { receive(channel, bytes); });
  if (config_.image_channel.empty()) return;
  bus_.subscribe(literal_pattern(config_.image_channel), max_queued,
                 [this](const std::string&, Bytes bytes) {
                   route({config_.camera, ChannelKind::kImage}, bytes);
                 });
}

void MappingServer::receive(const std::string& channel, Bytes bytes) {
  if (const std::optional<Channel> parsed = parse_channel(channel))
    route(*parsed, bytes);
  else
    own_status_.note_bad_channel();
}

// Where there may be others, their messages must not wait for room in one camera's inbox.
void MappingServer::route(const Channel& channel, Bytes bytes) {
  if (channel.camera == kNoCamera && channel.kind == ChannelKind::kCommand)
    return commands_.receive(bytes);
  if (channel.camera == kNoCamera) return own_status_.note_bad_channel();
  const bool may_wait = !config_.camera.empty();
  if (CameraLane* lane = lane_of(channel, bytes)) lane->receive(channel.kind, bytes, may_wait);
}

// Null: the message is refused, which has been noted. Requests for a camera that is not mapped here
// may be another server's.
CameraLane* MappingServer::lane_of(const Channel& channel, Bytes bytes) {
  const std::lock_guard lock(lanes_mutex_);
  if (const auto found = lanes_.find(channel.camera); found != lanes_.end())
    return found->second.get();
  if (stopping_) return nullptr;
  if (makes_a_lane(channel.kind)) return add_lane(channel.camera, is_frame(channel.kind, bytes));
  if (channel.kind == ChannelKind::kMeasurement) own_status_.note_lost_measurement();
  return nullptr;
}

CameraLane* MappingServer::add_lane(const std::string& camera, bool is_frame) {
  if (lanes_.size() >= static_cast<std::size_t>(config_.max_cameras)) {
    own_status_.refuse(camera, is_frame, Reason::kTooManyCameras,
                       std::to_string(lanes_.size()) + " others are mapped already");
    return nullptr;
  }
  try {
    CameraLane* lane = lanes_.emplace(camera, make_lane(camera)).first->second.get();
    own_status_.note_camera();
    return lane;
  } catch (const std::exception& error) {  // memory, or no more threads
    own_status_.refuse(camera, is_frame, Reason::kInternalError, error.what());
    return nullptr;
  }
}

std::unique_ptr<CameraLane> MappingServer::make_lane(const std::string& camera) {
  ServerConfig config = config_;
  config.camera = camera;
  CameraLane::OnStep on_step;
  if (on_step_)
    on_step = [this, camera](std::string_view step, bool begins) {
      on_step_(camera, step, begins);
    };
  return std::make_unique<CameraLane>(
      config, bus_, access_, [this](const status_t& status) { tell(status); }, on_step, results_);
}

std::vector<ServerCommands::Camera> MappingServer::commanded() const {
  std::vector<ServerCommands::Camera> cameras;
  for (CameraLane* lane : lanes())
    cameras.push_back({lane->camera(), [lane](const ServerCommands::Action& action) {
                         return lane->command(action);
                       }});
  return cameras;
}

void MappingServer::tell(const status_t& status) {
  const std::lock_guard lock(tell_mutex_);
  if (on_change_) on_change_(status);
}

std::vector<CameraLane*> MappingServer::lanes() const {
  const std::lock_guard lock(lanes_mutex_);
  std::vector<CameraLane*> lanes;
  for (const auto& [camera, lane] : lanes_) lanes.push_back(lane.get());
  return lanes;
}

bool MappingServer::wait_until_idle(std::chrono::milliseconds timeout) {
  const auto deadline = CameraLane::Clock::now() + timeout;
  for (CameraLane* lane : lanes())
    if (!lane->wait_until_idle(deadline)) return false;
  return true;
}

std::vector<status_t> MappingServer::statuses() {
  std::vector<status_t> statuses{own_status_.now()};
  for (const CameraLane* lane : lanes())
    if (status_t last = lane->last_status(); !last.camera.empty())  // none in its first moment
      statuses.push_back(std::move(last));
  return statuses;
}

void MappingServer::stop() {
  {
    const std::lock_guard lock(lanes_mutex_);
    stopping_ = true;
  }
  commands_.stop();
  for (CameraLane* lane : lanes()) lane->begin_stop();
  own_status_.begin_stop();
  for (CameraLane* lane : lanes()) lane->end();
  own_status_.end();
}

std::vector<const CameraLane*> MappingServer::lanes_with_results() const {
  std::vector<const CameraLane*> found;
  for (const CameraLane* lane : lanes())
    if (lane->has_results()) found.push_back(lane);
  return found;
}

bool MappingServer::has_results() const {
  return !lanes_with_results().empty();
}

std::string MappingServer::write_results(const std::filesystem::path& folder) const {
  const std::vector<const CameraLane*> with_results = lanes_with_results();
  if (with_results.empty())
    return "no calibrated frame has arrived, so there are no results to write";
  if (with_results.size() == 1) return with_results.front()->write_results(folder);
  std::string problems;
  for (const CameraLane* lane : with_results) {
    const std::string problem = lane->write_results(folder / lane->camera());
    if (!problem.empty()) problems += (problems.empty() ? "" : "; ") + problem;
  }
  return problems;
}

}  // namespace eifmap
