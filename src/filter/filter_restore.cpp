// A filter as it was, from what a file keeps of it.
#include <cmath>

#include "filter/information_filter.h"

namespace eifmap {

FilterBooks InformationFilter::books() const {
  FilterBooks books;
  books.has_gauge = has_gauge_;
  books.is_metric = is_metric_;
  books.is_placed = is_placed_;
  books.has_level = has_level();
  books.gauge = gauge_;
  books.earth_from_map = earth_from_map_;
  books.held_up = held_up();
  books.absolute_weight = absolute_weight_;
  books.map_variance = map_variance_;
  books.edge_variance = edge_variance_;
  books.variances_asked_for = variances_asked_for_;
  return books;
}

// What it rests on besides numbers that any file may hold.
bool InformationFilter::is_restorable(const FilterBooks& books) const {
  const auto is_positive = [](double x) { return x > 0 && std::isfinite(x); };
  const bool holds_scale = books.gauge.length > 0 && books.gauge.direction.allFinite();
  return num_poses() >= 2 && !has_gauge_ && books.has_gauge && (books.is_metric || holds_scale) &&
         (!books.is_placed || (books.is_metric && books.has_level)) &&
         is_positive(books.absolute_weight) && is_positive(books.map_variance) &&
         is_positive(books.edge_variance) && books.held_up.allFinite() &&
         books.earth_from_map.translation.allFinite() &&
         books.earth_from_map.rotation.coeffs().allFinite();
}

bool InformationFilter::restore(const FilterBooks& books,
                                const std::vector<AbsoluteObservation>& absolutes) {
  if (!is_restorable(books)) return false;
  has_gauge_ = true;
  gauge_ = books.gauge;
  is_metric_ = books.is_metric;
  is_placed_ = books.is_placed;
  earth_from_map_ = books.earth_from_map;
  absolute_weight_ = books.absolute_weight;
  map_variance_ = books.map_variance;
  edge_variance_ = books.edge_variance;
  variances_asked_for_ = books.variances_asked_for;
  if (is_metric_) gauge_.length = 0;
  system_.set_gauge(gauge_);
  if (books.has_level) {
    system_.append_earth(num_poses());
    system_.hold_earth(books.held_up);
  }
  for (const AbsoluteObservation& observation : absolutes) {
    FilterAbsolute absolute;
    absolute.observation = observation;
    if ((!is_metric_ && observation.kind != AbsoluteObservation::Kind::kDown) ||
        check(observation) != Reason::kNone || !whitening(observation, absolute.whiten))
      return false;
    absolutes_.push_back(std::move(absolute));
  }
  linearize_moved();
  system_.sum(index_, landmarks_, touched_.sorted(), edges_, absolutes_,
              poses_[1].translation - poses_[0].translation);
  if (!factor_for_all()) return false;
  for (int l : touched_in_update_.sorted()) judge_landmark(l);
  correlation_ = correlation_sums_.correlation();
  touched_.clear();
  touched_in_update_.clear();
  positions_before_.clear();
  return true;
}

}  // namespace eifmap
