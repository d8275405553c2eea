#include "server/camera_commands.h"

#include "convert/measurement_message.h"
#include "names.h"
#include "sequence/number_text.h"
#include "wire/clock.h"

namespace eifmap {
namespace {

std::string name_of_state(std::int8_t state) {
  if (state == status_t::STATE_PAUSED) return "PAUSED";
  if (state == status_t::STATE_STOPPING) return "STOPPING";
  return std::string(name(static_cast<TrackingState>(state)));
}

// Names of saved maps.
constexpr const char* kUnnamed = "map";
constexpr const char* kCheckpoint = "checkpoint";

std::string listed(const std::vector<std::int64_t>& ids) {
  std::string text;
  for (const std::int64_t id : ids) {
    if (!text.empty()) text += ' ';
    text += std::to_string(id);
  }
  return text;
}

}  // namespace

CommandTarget::Place CameraCommands::place() const {
  return {mapper_.map_id(), mapper_.map_epoch(), maps_.map().seq()};
}

CommandOutcome CameraCommands::ping() {
  CommandOutcome outcome{reply_t::RESULT_OK, Reason::kNone, "here"};
  outcome.values = {{"camera", mapper_.camera()},
                    {"state", name_of_state(board_.headline().first)}};
  return outcome;
}

CommandOutcome CameraCommands::pause() {
  const bool was_paused = board_.is_paused();
  board_.set_paused(true);
  return {reply_t::RESULT_OK, Reason::kNone,
          was_paused ? "it was paused already"
                     : "paused: frames are counted and not mapped, until resume"};
}

CommandOutcome CameraCommands::resume() {
  const bool was_paused = board_.is_paused();
  board_.set_paused(false);
  return {reply_t::RESULT_OK,
          Reason::kNone,
          was_paused ? "resumed: frames are mapped again" : "it was not paused",
          {{"frames_left_out", std::to_string(board_.paused_frames())}}};
}

CommandOutcome CameraCommands::reset() {
  const std::int64_t given_up = mapper_.map_id();
  if (!mapper_.reset())
    return {reply_t::RESULT_OK, Reason::kNone,
            "nothing was mapped yet: there is nothing to give up"};
  board_.note_new_map();
  board_.note_reason(Reason::kMapReset, "");
  CommandOutcome outcome{reply_t::RESULT_OK, Reason::kNone,
                         "the map was given up; the next frame begins another"};
  if (given_up > 0) outcome.values = {{"map_given_up", std::to_string(given_up)}};
  return outcome;
}

CommandOutcome CameraCommands::maps() {
  if (mapper_.map_id() == 0) return {reply_t::RESULT_OK, Reason::kNone, "there is no map yet"};
  const MapperStatistics statistics = mapper_.statistics();
  const std::vector<std::int64_t> kept = mapper_.kept_maps();
  CommandOutcome outcome{reply_t::RESULT_OK, Reason::kNone,
                         "map " + std::to_string(mapper_.map_id()) + " is in use, " +
                             std::to_string(kept.size()) + " are kept beside it"};
  outcome.values = {{"map_id", std::to_string(mapper_.map_id())},
                    {"kept", listed(kept)},
                    {"keyframes", std::to_string(statistics.keyframes)},
                    {"landmarks", std::to_string(statistics.landmarks)},
                    {"scale", std::string(name(statistics.scale.status))},
                    {"metres_per_unit", exact_text(statistics.scale.metres_per_unit)},
                    {"digest", std::to_string(maps_.map().digest())}};
  return outcome;
}

CommandOutcome CameraCommands::snapshot() {
  if (maps_.map().seq() == 0) return CommandOutcome::refuse(Reason::kNoMap, "");
  map_request_t request{};
  request.requester = server_epoch_;
  request.request_id = ++snapshots_;
  request.camera = mapper_.camera();
  request.server_epoch = server_epoch_;
  request.have_seq = -1;
  const std::int64_t before = maps_.counts().parts_again;
  maps_.answer(request, std::chrono::steady_clock::now());
  const std::int64_t parts = maps_.counts().parts_again - before;
  return {reply_t::RESULT_OK,
          Reason::kNone,
          "the whole published map is on its way again",
          {{"parts", std::to_string(parts)},
           {"keyframes", std::to_string(maps_.map().keyframes().size())},
           {"landmarks", std::to_string(maps_.map().landmarks().size())}}};
}

CommandOutcome CameraCommands::set_scale(double metres_per_unit, double sigma) {
  const CameraMapper::SaidScale said =
      mapper_.say_scale(metres_per_unit, sigma, {server_epoch_, scales_});
  if (said.reason != Reason::kNone) return CommandOutcome::refuse(said.reason, said.detail);
  ++scales_;
  const AbsoluteMeasurement& m = said.measurement.measurement;
  send_(ChannelKind::kMeasurement, encode(to_message(said.measurement)));
  return {reply_t::RESULT_ACCEPTED,
          Reason::kNone,
          "as a distance of two keyframes it enters the map with the next keyframe",
          {{"length_m", exact_text(m.length)},
           {"sigma_m", exact_text(m.sigma)},
           {"utime", std::to_string(m.time_us)},
           {"utime2", std::to_string(m.until_us)}}};
}

CommandOutcome CameraCommands::save(const std::string& name) {
  const Taken taken = mapper_.save_map(name.empty() ? kUnnamed : name);
  if (taken.reason != Reason::kNone) return CommandOutcome::refuse(taken.reason, taken.detail);
  return {reply_t::RESULT_OK, Reason::kNone, "the map is on the disk", {{"file", taken.detail}}};
}

CommandOutcome CameraCommands::load(const std::string& name) {
  const Taken taken = mapper_.load_map(name.empty() ? kUnnamed : name);
  if (taken.reason != Reason::kNone) return CommandOutcome::refuse(taken.reason, taken.detail);
  board_.note_new_map();
  board_.note_resumed(mapper_.map_id(), mapper_.statistics());
  return {reply_t::RESULT_OK,
          Reason::kNone,
          "mapping goes on with that map, once an image shows where the camera is; what there was "
          "is given up",
          {{"file", taken.detail},
           {"map_id", std::to_string(mapper_.map_id())},
           {"keyframes", std::to_string(mapper_.statistics().keyframes)}}};
}

CommandOutcome CameraCommands::checkpoint() {
  return save(kCheckpoint);
}

CommandOutcome CameraCommands::undo() {
  return load(kCheckpoint);
}

CommandOutcome CameraCommands::localize_only(bool on) {
  const bool was_on = mapper_.localizes_only();
  mapper_.localize_only(on);
  const char* done = on ? "maps stay as they are; poses go on" : "maps grow again";
  return {reply_t::RESULT_OK, Reason::kNone,
          was_on == on ? std::string("it was so already: ") + done : done};
}

CommandOutcome CameraCommands::shutdown() {
  return CommandOutcome::refuse(Reason::kUnsupported,
                                "the whole server is shut down, not a camera: leave --camera out",
                                reply_t::RESULT_UNSUPPORTED);
}

}  // namespace eifmap
