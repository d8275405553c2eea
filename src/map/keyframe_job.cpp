#include "keyframe_job.h"

#include <utility>

#include "map/keyframe_work.h"

namespace eifmap {

KeyframeJob::KeyframeJob(std::unique_ptr<KeyframeWork> work) : work_(std::move(work)) {}
KeyframeJob::~KeyframeJob() = default;
KeyframeJob::KeyframeJob(KeyframeJob&&) noexcept = default;
KeyframeJob& KeyframeJob::operator=(KeyframeJob&&) noexcept = default;

std::int64_t KeyframeJob::id() const {
  return work_->id;
}

void KeyframeJob::run() {
  KeyframeWork& work = *work_;
  work.after = std::make_shared<Map>(*work.before);  // which shares what stays as it is
  const int epoch = work.after->epoch();
  add_measurements(*work.after, std::move(work.measurements.placed), work.options.measurement);
  work.insertion =
      insert_keyframe(*work.after, work.observed, work.tracking, work.hardly_seen, work.options);
  if (work.insertion.reason == Reason::kNone)
    work.insertion.reason = fix_scale(*work.after, work.options.measurement);
  if (work.insertion.reason != Reason::kNone) return;
  if (work.options.loop.enabled)
    work.loop = close_loop(*work.after, work.insertion.keyframe, work.loop_search, work.options);
  if (work.loop.closed()) judge_scale(*work.after, work.options.measurement);
  work.calibration->look_at(*work.after);
  if (!work.kept.empty())
    work.merge = merge_maps(*work.after, work.map_id, work.insertion.keyframe, work.kept,
                            *work.view, work.merge_search, work.options);
  const Map& map = work.merge.merged ? *work.merge.merged : *work.after;
  if (work.news && (work.merge.merged || map.epoch() != epoch)) work.news->begin_anew();
  if (work.news) work.update = work.news->since_last(map);
}

}  // namespace eifmap
