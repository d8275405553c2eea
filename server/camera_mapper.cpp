#include "server/camera_mapper.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "convert/feature_message.h"
#include "features/front_end.h"
#include "frame_check.h"
#include "sequence/number_text.h"
#include "server/image_decoder.h"

namespace eifmap {
namespace {

FrameResult rejected(Reason reason, std::string detail) {
  FrameResult result;
  result.rejected = true;
  result.reason = reason;
  result.detail = std::move(detail);
  return result;
}

// Id 0 is a publisher that does not say.
std::string id_problem(std::int64_t calibration_id, const Camera& camera) {
  if (calibration_id == 0 || calibration_id == camera.id()) return "";
  return "the frame names calibration " + std::to_string(calibration_id) + ", known is " +
         std::to_string(camera.id());
}

std::string in_words(const Camera& camera) {
  return "now " + std::to_string(camera.width) + "x" + std::to_string(camera.height) + ", fx " +
         std::to_string(camera.fx) + " px";
}

const ServerConfig& checked(const ServerConfig& config) {
  if (const std::string problem = config.problem(); !problem.empty())
    throw std::invalid_argument(problem);
  return config;
}

}  // namespace

CameraMapper::CameraMapper(const ServerConfig& config)
    : CameraMapper(config, checked(config).live_handover()) {}

CameraMapper::CameraMapper(const ServerConfig& config, Handover handover)
    : config_(checked(config)),
      extractor_(config.features),
      calibrations_(config.calibration, config.hfov_deg),
      camera_(config.camera),
      localize_only_(config.mapper.localize_only),
      measurements_(config.mapper.measurement.max_waiting) {
  if (handover.is_beside()) keyframes_.emplace(std::move(handover));
}

// A good frame of the calibration that waited has come.
void CameraMapper::change_calibration(const std::string& camera) {
  calibrations_.change(camera);
  if (mapper_) begin_map(camera, *calibrations_.of(camera));
}

void CameraMapper::begin_map(const std::string& camera, const Camera& calibration, bool stored) {
  camera_ = camera;
  record_.reset();
  if (results_ == Results::kKept) record_.emplace();
  timer_ = {};
  if (keyframes_) keyframes_->discard();
  mapper_.emplace(calibration, config_.mapper);
  mapper_->localize_only(localize_only_);
  mapper_->restore(stored_maps(calibration, stored));
  if (keyframes_) mapper_->set_keyframe_runner(&*keyframes_, true);
  mapper_->set_step_observer([this](std::string_view step, bool begins) {
    timer_.observe(step, begins);
    if (step_observer_) step_observer_(step, begins);
  });
}

CameraMapper::Mapped CameraMapper::take_frame(const Channel& channel, Bytes bytes,
                                              std::int64_t received_us) {
  received_us_ = received_us;
  const bool is_guess = calibrations_.guess(channel, bytes);
  const Camera* camera = calibrations_.of(channel.camera);
  if (!camera) return {rejected(Reason::kNoCalibration, "camera " + channel.camera), {}, ""};
  timer_.begin_frame();
  Decoded<FeatureFrame> frame;
  try {
    frame = read_frame(channel, bytes);
  } catch (const std::exception& error) {
    frame = Decoded<FeatureFrame>::refuse(Reason::kInternalError, error.what());
  }
  Mapped mapped;
  if (frame.ok() && frame.value.calibration_id != camera->id()) {
    if (const FrameCheck check = check_frame(frame.value, calibrations_.waiting(channel.camera));
        !check.ok())
      frame = Decoded<FeatureFrame>::refuse(check.reason, check.detail);
  }
  if (frame.ok() && frame.value.calibration_id != camera->id()) {
    change_calibration(channel.camera);
    if (mapper_) mapped.new_calibration = in_words(*camera);
  }
  if (frame.ok() && !mapper_) begin_map(channel.camera, *camera);
  if (frame.ok() && timer_.is_empty()) timer_.begin_frame();  // the map, and this, are new
  if (frame.ok())
    map(frame.value, mapped);
  else
    mapped.result = rejected(frame.reason, std::move(frame.detail));
  if (!frame.ok() && is_guess) calibrations_.withdraw_guess(channel.camera);
  if (keyframes_) timer_.add("keyframe", keyframes_->take_busy_ms());
  timer_.end_frame(record_.has_value());
  if (record_) record_->add(mapped.result);
  return mapped;
}

// The frame names the calibration that it belongs to: the one in use or the one that waits.
Decoded<FeatureFrame> CameraMapper::read_frame(const Channel& channel, Bytes bytes) {
  using Result = Decoded<FeatureFrame>;
  if (channel.kind == ChannelKind::kImage) return read_image(channel, bytes);
  const TimedStep step(timer_, "decode");
  Result frame = decode_features(bytes);
  if (!frame.ok()) return frame;
  note_arrival(frame.value.publisher, frame.value.seq, frame.value.time_us);
  if (std::string problem = camera_problem(frame.value.camera, channel.camera); !problem.empty())
    return Result::refuse(Reason::kMalformedMessage, std::move(problem));
  const Camera& camera = calibrations_.of_frame(channel.camera, frame.value.calibration_id,
                                                frame.value.width, frame.value.height);
  if (std::string problem = id_problem(frame.value.calibration_id, camera); !problem.empty())
    return Result::refuse(Reason::kCalibrationMismatch, std::move(problem));
  frame.value.calibration_id = camera.id();
  return frame;
}

Decoded<FeatureFrame> CameraMapper::read_image(const Channel& channel, Bytes bytes) {
  using Result = Decoded<FeatureFrame>;
  Decoded<ImageMessage> image;
  DecodedImage pixels;
  const Camera* camera = nullptr;
  {
    const TimedStep step(timer_, "decode");
    image = decode_image(bytes);
    if (!image.ok()) return Result::refuse(image.reason, std::move(image.detail));
    note_arrival(image.value.publisher, image.value.seq, image.value.time_us);
    camera = &calibrations_.of_frame(channel.camera, image.value.calibration_id, image.value.width,
                                     image.value.height);
    if (std::string problem = id_problem(image.value.calibration_id, *camera); !problem.empty())
      return Result::refuse(Reason::kCalibrationMismatch, std::move(problem));
    pixels = decode_pixels(image.value, *camera, config_.gray16_bits);
    if (!pixels.ok()) return Result::refuse(pixels.reason, std::move(pixels.detail));
  }
  const TimedStep step(timer_, "extract");
  const FrameHeader header{image.value.time_us, image.value.publisher, image.value.seq,
                           channel.camera};
  Result frame;
  if (is_late(image.value, channel, *camera)) {
    frame.value = frame_without_features(extractor_, *camera, header);
    return frame;
  }
  frame.value = extract_frame(extractor_, pixels.gray, *camera, header);
  if (record_ && !extractor_.roll_is_sure()) record_->add_unseen_roll();
  return frame;
}

// It will be refused, and must not leave its traces in the extractor, which follows the camera.
bool CameraMapper::is_late(const ImageMessage& image, const Channel& channel,
                           const Camera& camera) const {
  return mapper_ && camera.id() == calibrations_.of(channel.camera)->id() &&
         mapper_->is_late(image.publisher, image.time_us);
}

void CameraMapper::map(const FeatureFrame& frame, Mapped& mapped) {
  try {
    give_measurements();
    mapped.result = mapper_->process(frame);
    if (mapped.result.map_updated) mapped.update = next_update();
  } catch (const std::invalid_argument& error) {
    // A fault of ours, met before anything was done: it costs this frame.
    mapped.result = rejected(Reason::kInternalError, error.what());
    return;
  } catch (const std::exception& error) {
    give_up_map();
    mapped.result =
        rejected(Reason::kFilterFailed, std::string("the map was given up: ") + error.what());
    return;
  }
  if (!mapped.result.rejected) mapped.result.after_reset = std::exchange(was_reset_, false);
  if (mapped.result.map_id > 0) {
    mapped.result.map_seq = map_seq_;
    note_published(mapped.result.map_id, mapped.result.map_epoch);
  }
}

// After a fault of ours, and who knows what was half done: the map is no longer to be trusted, the
// next frame begins another.
void CameraMapper::give_up_map() {
  begin_map(camera_, *calibrations_.of(camera_));
}

// What is refused now is counted by the mapper.
void CameraMapper::give_measurements() {
  for (const AbsoluteMeasurement& measurement : measurements_.give(camera_))
    if (mapper_->add_measurement(measurement) == Reason::kNone && record_)
      record_->add(measurement);
}

MapUpdate CameraMapper::next_update() {
  MapUpdate update = mapper_->map_update();
  update.seq = ++map_seq_;
  if (update.base_seq != -1) update.base_seq = update.seq - 1;
  map_epoch_ = update.map_epoch;
  note_published(update.map_id, update.map_epoch);
  return update;
}

void CameraMapper::note_published(std::int64_t map_id, std::int64_t epoch) {
  map_id_ = map_id;
  largest_map_id_ = std::max(largest_map_id_, map_id);
  largest_epoch_ = std::max(largest_epoch_, epoch);
}

bool CameraMapper::reset() {
  if (!mapper_) return false;
  begin_map(camera_, *calibrations_.of(camera_), false);
  extractor_ = FeatureExtractor(config_.features);
  was_reset_ = true;
  return true;
}

CameraMapper::SaidScale CameraMapper::say_scale(double metres_per_unit, double sigma,
                                                MeasurementId id) {
  constexpr std::size_t kLatest = 100;  // whose frames the mapper remembers
  const double max_sigma = config_.mapper.measurement.max_scale_sigma;
  if (sigma > max_sigma)
    return {Reason::kBadArguments,
            "sigma is above " + exact_text(max_sigma) + ", measurement.max_scale_sigma"};
  std::vector<KeyframeView> keyframes;
  if (mapper_) keyframes = mapper_->keyframes();
  if (keyframes.size() < 2) return {Reason::kNoMap, "two keyframes are needed"};
  if (statistics().scale.status == ScaleStatus::kFixed)
    return {Reason::kMapIsMetric,
            "by now " + exact_text(statistics().scale.metres_per_unit) + " m a unit as it began"};
  if (keyframes.size() > kLatest) keyframes.erase(keyframes.begin(), keyframes.end() - kLatest);
  SaidScale said;
  AbsoluteMeasurement& m = said.measurement.measurement;
  for (const KeyframeView& a : keyframes)
    for (const KeyframeView& b : keyframes) {
      const double length =
          metres_per_unit * (a.map_from_camera.translation - b.map_from_camera.translation).norm();
      if (a.time_us >= b.time_us || length <= m.length) continue;
      m.time_us = a.time_us;
      m.until_us = b.time_us;
      m.length = length;
    }
  if (m.length == 0) return {Reason::kNoMap, "all keyframes are at one place"};
  m.id = id;
  m.kind = MeasurementKind::kDistance;
  m.sigma = sigma * m.length;
  said.measurement.camera = camera_;
  Taken taken = measurements_.take_own(said.measurement);
  said.reason = taken.reason;
  said.detail = std::move(taken.detail);
  return said;
}

std::vector<std::int64_t> CameraMapper::kept_maps() const {
  return statistics().submaps.kept_ids;
}

RelativeAnswer CameraMapper::answer(const RelativeRequest& request) const {
  RelativeAnswer answer;
  answer.request = request;
  answer.map_epoch = map_epoch_;
  answer.map_seq = map_seq_;
  std::optional<RelativeView> view;
  if (mapper_ && request.camera == camera_ && request.map_id == map_id_)
    view = mapper_->relative_pose(request.a, request.b);
  if (view)
    answer.view = *view;
  else
    answer.reason = Reason::kKeyframeUnknown;
  return answer;
}

std::optional<MapUpdate> CameraMapper::adopt_keyframe(bool wait) {
  if (!keyframes_ || !(wait ? keyframes_->has_job() : keyframes_->may_be_adopted()))
    return std::nullopt;
  // At the end the results without the last keyframe are more than none.
  return settle(wait ? IfItFails::kKeepMap : IfItFails::kGiveUpMap);
}

std::optional<MapUpdate> CameraMapper::settle(IfItFails then) {
  try {
    if (mapper_->settle()) return next_update();
  } catch (const std::exception&) {
    if (then == IfItFails::kGiveUpMap) give_up_map();
    throw;
  }
  return std::nullopt;
}

bool CameraMapper::maps_beside() const {
  return keyframes_ && keyframes_->has_job() &&
         (keyframes_->may_be_adopted() || !keyframes_->is_done());
}

// As soon as the header is known: a frame that is refused has arrived all the same.
void CameraMapper::note_arrival(std::int64_t publisher, std::int64_t seq, std::int64_t time_us) {
  streams_.note({publisher, seq, time_us, received_us_}, dropped_);
  dropped_ = 0;
}

MapperStatistics CameraMapper::statistics() const {
  return mapper_ ? mapper_->statistics() : MapperStatistics{};
}

std::string CameraMapper::write_results(const std::filesystem::path& folder) const {
  if (!mapper_) return "no calibrated frame has arrived, so there are no results to write";
  if (!record_) return "no results were kept";
  return record_->write(folder, *mapper_, timer_, "camera " + camera_);
}

}  // namespace eifmap
