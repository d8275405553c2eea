#include "mapper.h"

namespace eifmap {
// Being written.
struct Mapper::State {
  MapperStatistics statistics;
};
Mapper::Mapper(const Camera&, const MapperOptions&) : state_(std::make_unique<State>()) {}
Mapper::~Mapper() = default;
Mapper::Mapper(Mapper&&) noexcept = default;
Mapper& Mapper::operator=(Mapper&&) noexcept = default;
FrameResult Mapper::process(const FeatureFrame&) { return {}; }
MapUpdate Mapper::map_update() { return {}; }
const MapperStatistics& Mapper::statistics() const { return state_->statistics; }
std::vector<TimedPose> Mapper::final_trajectory() const { return {}; }
std::vector<TimedPose> Mapper::keyframe_trajectory() const { return {}; }
std::vector<MapPoint> Mapper::map_points() const { return {}; }
void Mapper::set_step_observer(std::function<void(std::string_view, bool)>) {}
}  // namespace eifmap
