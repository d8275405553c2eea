#include "server/sequence_run.h"

#include <algorithm>
#include <limits>
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

// "" or why the mapper cannot begin with this map.
std::string begin_with(const std::filesystem::path& file, const Camera& camera,
                       const MapperOptions& options, Mapper& mapper) {
  LoadedMap loaded = load_map(file, options, &camera);
  if (!loaded.ok())
    return file.string() + ": " + describe(loaded.reason).text + ": " + loaded.detail + "; " +
           describe(loaded.reason).hint;
  MapperSnapshot snapshot;
  snapshot.last_map_id = std::max(loaded.head.names.last_map_id, loaded.snapshot.map_id);
  snapshot.in_use = std::move(loaded.snapshot);
  mapper.restore(snapshot);
  return "";
}

std::string leave_map(const std::filesystem::path& file, const Camera& camera,
                      const Mapper& mapper) {
  const MapperSnapshot snapshot = mapper.snapshot();
  if (!snapshot.in_use) return "no map was made, so none is written to " + file.string();
  return MapFile(file).save(*snapshot.in_use, {camera, 0, snapshot.last_map_id, {}});
}

}  // namespace

std::string run_sequence(const SequenceRunOptions& options, const Progress& progress,
                         const Note& note) {
  if (options.every < 1) throw std::invalid_argument("every: must be at least 1");
  if (options.first_frame < 0) throw std::invalid_argument("first_frame: must be at least 0");
  if (options.max_frames < 0) throw std::invalid_argument("max_frames: must be at least 0");
  const OpenedSource opened = open_source(options.sequence, options.images);
  if (!opened.source) return opened.problem;
  ImageSource& sequence = *opened.source;
  if (sequence.live())
    return options.sequence + ": is a live camera; send it by eifmap publish to a live server";
  if (std::string problem = output_problem(options.output); !problem.empty()) return problem;
  if (note)
    for (const std::string& assumed : sequence.notes()) note(assumed);

  StepTimer timer;
  RunRecord record;
  Jitter jitter(options.jitter_px, options.seed);
  FeatureExtractor extractor(options.features);
  Replay replay;
  if (!options.decisions.empty())
    if (std::string problem = replay.open(options.decisions, options.measurements);
        !problem.empty())
      return problem;
  MeasurementsFile measurements;
  if (!options.measurements.empty() && !replay.is_open())
    measurements = read_measurements(options.measurements);
  if (!measurements.problem.empty()) return measurements.problem;
  const Handover handover = replay.is_open() ? replay.handover() : options.handover;
  std::optional<KeyframeWorker> keyframes;
  if (handover.is_beside()) keyframes.emplace(handover);
  std::optional<Mapper> made;
  const auto begin_map = [&] {
    record = {};
    timer = {};
    extractor = FeatureExtractor(options.features);
    if (keyframes) keyframes->discard();
    made.emplace(sequence.camera(), options.mapper);
    if (keyframes) made->set_keyframe_runner(&*keyframes, false);
    made->set_step_observer(
        [&](std::string_view step, bool begins) { timer.observe(step, begins); });
  };
  begin_map();
  Mapper& mapper = *made;  // also when it is another one
  if (!options.load_map.empty())
    if (std::string problem =
            begin_with(options.load_map, sequence.camera(), options.mapper, mapper);
        !problem.empty())
      return problem;

  // Each before the first image that is not before it; of a replay, where it was.
  std::size_t num_measured = 0;
  const auto add_measurement = [&](const AbsoluteMeasurement& measurement) {
    if (mapper.add_measurement(measurement) == Reason::kNone) record.add(measurement);
  };
  const auto add_measurements_until = [&](std::int64_t time_us) {
    if (replay.is_open())
      for (const AbsoluteMeasurement& m : replay.measurements_before(time_us)) add_measurement(m);
    const std::vector<AbsoluteMeasurement>& all = measurements.measurements;
    while (num_measured < all.size() && usable_from_us(all[num_measured]) <= time_us)
      add_measurement(all[num_measured++]);
  };

  const auto map_image = [&](int i) {
    GrayImage image;
    {
      const TimedStep step(timer, "decode");
      image = sequence.gray(i);
    }
    if (!image.problem.empty()) return refused(sequence.time_us(i), i, image.reason, image.problem);
    if (std::string problem = size_problem(image.image.cols, image.image.rows); !problem.empty())
      return refused(sequence.time_us(i), i, Reason::kBadImageSize, std::move(problem));
    FeatureFrame frame;
    {
      const TimedStep step(timer, "extract");
      frame = extract_frame(extractor, image.image, sequence.camera(),
                            {sequence.time_us(i), 0, i, "cam0"});
    }
    if (replay.is_open()) replay.restore(frame);
    if (!extractor.roll_is_sure()) record.add_unseen_roll();
    jitter.apply(frame);
    return mapper.process(frame);
  };

  const int total = images_taken(sequence.size(), options);
  std::string refusal;  // of the first image, while none has been taken
  bool taken = false, stopped = false;
  for (int n = 0; options.max_frames == 0 || n < options.max_frames; ++n) {
    const std::int64_t i = options.first_frame + std::int64_t{n} * options.every;
    if (i > std::numeric_limits<int>::max() || !sequence.has(static_cast<int>(i))) break;
    if (!progress(n, total < 0 ? total : std::max(n, total))) {
      stopped = true;
      break;
    }
    if (replay.is_open() && !replay.takes(sequence.time_us(static_cast<int>(i)))) continue;
    const bool resets =
        replay.is_open() && replay.resets_before(sequence.time_us(static_cast<int>(i)));
    if (resets) begin_map();
    add_measurements_until(sequence.time_us(static_cast<int>(i)));
    timer.begin_frame();
    FrameResult result = map_image(static_cast<int>(i));
    result.after_reset = resets && !result.rejected;
    if (keyframes) timer.add("keyframe", keyframes->take_busy_ms());
    timer.end_frame();
    if (replay.is_open()) replay.compare(result);
    if (result.rejected && refusal.empty()) refusal = result.detail;
    taken = taken || !result.rejected;
    record.add(result);
  }
  mapper.settle();
  progress(record.frames(), stopped ? total : record.frames());
  std::string problem = record.write(options.output, mapper, timer, options.sequence);
  if (problem.empty() && !options.save_map.empty())
    problem = leave_map(options.save_map, sequence.camera(), mapper);
  if (problem.empty() && !taken && record.frames() > 0)
    problem =
        "none of the " + std::to_string(record.frames()) + " images could be used: " + refusal;
  return problem.empty() && !stopped ? replay.departure() : problem;
}

}  // namespace eifmap
