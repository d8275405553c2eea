#include "server/sequence_run.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>

#include "capture/open_source.h"
#include "features/front_end.h"
#include "sequence/measurements_file.h"
#include "server/image_decoder.h"
#include "server/jitter.h"
#include "server/replay.h"
#include "server/run_record.h"
#include "storage/map_file.h"

namespace eifmap {
namespace {

FrameResult refused(std::int64_t time_us, std::int64_t seq, Reason reason, std::string problem) {
  FrameResult result;
  result.time_us = time_us;
  result.seq = seq;
  result.rejected = true;
  result.reason = reason;
  result.detail = std::move(problem);
  return result;
}

// Of `size` images; < 0 for unknown.
int images_taken(int size, const SequenceRunOptions& options) {
  if (size == ImageSource::kNoEnd) return -1;
  size = std::max(0, size - options.first_frame);
  const int taken = size / options.every + (size % options.every > 0 ? 1 : 0);
  return options.max_frames > 0 ? std::min(taken, options.max_frames) : taken;
}

std::string leave_map(const std::filesystem::path& file, const Camera& camera,
                      const Mapper& mapper) {
  const MapperSnapshot snapshot = mapper.snapshot();
  if (!snapshot.in_use) return "no map was made, so none is written to " + file.string();
  return MapFile(file).save(*snapshot.in_use, {camera, 0, snapshot.last_map_id, {}});
}

// What a run needs, and its steps.
class SequenceRun {
 public:
  explicit SequenceRun(const SequenceRunOptions& options)
      : options_(options), extractor_(options.features), jitter_(options.jitter_px, options.seed) {}
  SequenceRun(const SequenceRun&) = delete;
  SequenceRun& operator=(const SequenceRun&) = delete;

  // In this order; each returns "" or what went wrong.
  std::string open(const Note& note);
  std::string begin();
  std::string map_and_write(const Progress& progress);

 private:
  std::string open_decisions_and_measurements();
  void begin_map();
  std::string load_map();
  void add_measurements_before(std::int64_t time_us);
  void add(const AbsoluteMeasurement& measurement);
  void take_image(int i);
  FrameResult map_image(int i);
  std::string write_results();

  const SequenceRunOptions& options_;
  std::unique_ptr<ImageSource> images_;
  Replay replay_;
  MeasurementsFile measurements_;  // in the order of their times; of a replay they are with it
  std::size_t num_measured_ = 0;
  FeatureExtractor extractor_;
  Jitter jitter_;
  StepTimer timer_;
  RunRecord record_;
  std::optional<KeyframeWorker> keyframes_;
  std::optional<Mapper> mapper_;
  std::string refusal_;  // of the first image that was refused
  bool any_taken_ = false;
};

std::string SequenceRun::open(const Note& note) {
  OpenedSource opened = open_source(options_.sequence, options_.images);
  if (!opened.source) return opened.problem;
  images_ = std::move(opened.source);
  if (images_->live())
    return options_.sequence + ": is a live camera; send it by eifmap publish to a live server";
  if (std::string problem = output_problem(options_.output); !problem.empty()) return problem;
  if (note)
    for (const std::string& assumed : images_->notes()) note(assumed);
  return open_decisions_and_measurements();
}

std::string SequenceRun::open_decisions_and_measurements() {
  if (!options_.decisions.empty()) return replay_.open(options_.decisions, options_.measurements);
  if (!options_.measurements.empty()) measurements_ = read_measurements(options_.measurements);
  return measurements_.problem;
}

std::string SequenceRun::begin() {
  const Handover handover = replay_.is_open() ? replay_.handover() : options_.handover;
  if (handover.is_beside()) keyframes_.emplace(handover);
  begin_map();
  return options_.load_map.empty() ? "" : load_map();
}

// Also where another one is given up: results are of this one.
void SequenceRun::begin_map() {
  record_ = {};
  timer_ = {};
  extractor_ = FeatureExtractor(options_.features);
  if (keyframes_) keyframes_->discard();
  mapper_.emplace(images_->camera(), options_.mapper);
  if (keyframes_) mapper_->set_keyframe_runner(&*keyframes_, false);
  mapper_->set_step_observer(
      [this](std::string_view step, bool begins) { timer_.observe(step, begins); });
}

std::string SequenceRun::load_map() {
  const std::filesystem::path& file = options_.load_map;
  const Camera& camera = images_->camera();
  LoadedMap loaded = eifmap::load_map(file, options_.mapper, &camera);
  if (!loaded.ok())
    return file.string() + ": " + describe(loaded.reason).text + ": " + loaded.detail + "; " +
           describe(loaded.reason).hint;
  MapperSnapshot snapshot;
  snapshot.last_map_id = std::max(loaded.head.names.last_map_id, loaded.snapshot.map_id);
  snapshot.in_use = std::move(loaded.snapshot);
  mapper_->restore(snapshot);
  return "";
}

// Each before the first image that is not before it; of a replay, where it was.
void SequenceRun::add_measurements_before(std::int64_t time_us) {
  if (replay_.is_open())
    for (const AbsoluteMeasurement& m : replay_.measurements_before(time_us)) add(m);
  const std::vector<AbsoluteMeasurement>& all = measurements_.measurements;
  while (num_measured_ < all.size() && usable_from_us(all[num_measured_]) <= time_us)
    add(all[num_measured_++]);
}

void SequenceRun::add(const AbsoluteMeasurement& measurement) {
  if (mapper_->add_measurement(measurement) == Reason::kNone) record_.add(measurement);
}

std::string SequenceRun::map_and_write(const Progress& progress) {
  const int total = images_taken(images_->size(), options_);
  bool stopped = false;
  for (int n = 0; options_.max_frames == 0 || n < options_.max_frames; ++n) {
    const std::int64_t i = options_.first_frame + std::int64_t{n} * options_.every;
    if (i > std::numeric_limits<int>::max() || !images_->has(static_cast<int>(i))) break;
    stopped = !progress(n, total < 0 ? total : std::max(n, total));
    if (stopped) break;
    take_image(static_cast<int>(i));
  }
  mapper_->settle();
  progress(record_.frames(), stopped ? total : record_.frames());
  const std::string problem = write_results();
  return problem.empty() && !stopped ? replay_.departure() : problem;
}

void SequenceRun::take_image(int i) {
  const std::int64_t time_us = images_->time_us(i);
  if (replay_.is_open() && !replay_.takes(time_us)) return;
  const bool resets = replay_.is_open() && replay_.resets_before(time_us);
  if (resets) begin_map();
  add_measurements_before(time_us);
  timer_.begin_frame();
  FrameResult result = map_image(i);
  result.after_reset = resets && !result.rejected;
  if (keyframes_) timer_.add("keyframe", keyframes_->take_busy_ms());
  timer_.end_frame();
  if (replay_.is_open()) replay_.compare(result);
  if (result.rejected && refusal_.empty()) refusal_ = result.detail;
  any_taken_ = any_taken_ || !result.rejected;
  record_.add(result);
}

FrameResult SequenceRun::map_image(int i) {
  const std::int64_t time_us = images_->time_us(i);
  GrayImage image;
  {
    const TimedStep step(timer_, "decode");
    image = images_->gray(i);
  }
  if (!image.problem.empty()) return refused(time_us, i, image.reason, image.problem);
  if (std::string problem = size_problem(image.image.cols, image.image.rows); !problem.empty())
    return refused(time_us, i, Reason::kBadImageSize, std::move(problem));
  FeatureFrame frame;
  {
    const TimedStep step(timer_, "extract");
    frame = extract_frame(extractor_, image.image, images_->camera(), {time_us, 0, i, "cam0"});
  }
  if (replay_.is_open()) replay_.restore(frame);
  if (!extractor_.roll_is_sure()) record_.add_unseen_roll();
  jitter_.apply(frame);
  return mapper_->process(frame);
}

std::string SequenceRun::write_results() {
  std::string problem = record_.write(options_.output, *mapper_, timer_, options_.sequence);
  if (problem.empty() && !options_.save_map.empty())
    problem = leave_map(options_.save_map, images_->camera(), *mapper_);
  if (problem.empty() && !any_taken_ && record_.frames() > 0)
    problem =
        "none of the " + std::to_string(record_.frames()) + " images could be used: " + refusal_;
  return problem;
}

}  // namespace

std::string run_sequence(const SequenceRunOptions& options, const Progress& progress,
                         const Note& note) {
  if (options.every < 1) throw std::invalid_argument("every: must be at least 1");
  if (options.first_frame < 0) throw std::invalid_argument("first_frame: must be at least 0");
  if (options.max_frames < 0) throw std::invalid_argument("max_frames: must be at least 0");
  SequenceRun run(options);
  if (std::string problem = run.open(note); !problem.empty()) return problem;
  if (std::string problem = run.begin(); !problem.empty()) return problem;
  return run.map_and_write(progress);
}

}  // namespace eifmap
