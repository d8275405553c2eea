#include "server/sequence_run.h"

#include <algorithm>
#include <stdexcept>

#include "features/front_end.h"
#include "sequence/recorded_sequence.h"
#include "server/image_decoder.h"
#include "server/jitter.h"
#include "server/run_record.h"

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

}  // namespace

std::string run_sequence(const SequenceRunOptions& options, const Progress& progress) {
  if (options.every < 1) throw std::invalid_argument("every: must be at least 1");
  if (options.max_frames < 0) throw std::invalid_argument("max_frames: must be at least 0");
  const RecordedSequence::Opened opened = RecordedSequence::open(options.sequence);
  if (!opened.sequence) return opened.problem;
  const RecordedSequence& sequence = *opened.sequence;

  StepTimer timer;
  RunRecord record;
  Jitter jitter(options.jitter_px, options.seed);
  FeatureExtractor extractor(options.features);
  Mapper mapper(sequence.camera(), options.mapper);
  mapper.set_step_observer(
      [&](std::string_view step, bool begins) { timer.observe(step, begins); });

  const auto map_image = [&](int i) {
    GrayImage image;
    {
      const TimedStep step(timer, "decode");
      image = sequence.load_gray(i);
    }
    if (!image.problem.empty())
      return refused(sequence.time_us(i), i, Reason::kCorruptImage, image.problem);
    if (std::string problem = size_problem(image.image.cols, image.image.rows); !problem.empty())
      return refused(sequence.time_us(i), i, Reason::kBadImageSize, std::move(problem));
    FeatureFrame frame;
    {
      const TimedStep step(timer, "extract");
      frame = extract_frame(extractor, image.image, sequence.camera(),
                            {sequence.time_us(i), 0, i, "cam0"});
    }
    if (!extractor.roll_is_sure()) record.add_unseen_roll();
    jitter.apply(frame);
    return mapper.process(frame);
  };

  int total = (sequence.size() + options.every - 1) / options.every;
  if (options.max_frames > 0) total = std::min(total, options.max_frames);
  for (int n = 0; n < total; ++n) {
    if (!progress(n, total)) break;
    timer.begin_frame();
    record.add(map_image(n * options.every));
    timer.end_frame();
  }
  progress(record.frames(), total);
  return record.write(options.output, mapper, timer, options.sequence.string());
}

}  // namespace eifmap
