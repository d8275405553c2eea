// How far the errors of a feature's sights are from independent.
//
// A blob's place drifts as it is seen from elsewhere: of a track's errors, neighbours, in the order
// of where they are seen from, resemble each other (measured on rendered and recorded images: lag-1
// autocorrelation .6 to .75), so that n sights say as much as a fraction of n. The filter counts
// them all, and its covariances would be too small by the factor that a first-order autoregressive
// error has: (1 + rho) / (1 - rho) of a long track, a fifth less of ten sights at rho .6.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "filter/filter_state.h"
#include "geometry/rigid3.h"
#include "shared_vector.h"

namespace eifmap {

struct SightCorrelation {
  double rho = 0;                                           // lag-1 autocorrelation, [0, 0.9]
  double length = std::numeric_limits<double>::infinity();  // sights of a track, as most are in
  // What covariances must be multiplied by: as the variance of the mean of so many of a first-order
  // autoregressive error. 1 where errors are independent.
  double variance_factor() const {
    const double of_long = (1 + rho) / (1 - rho);
    return of_long - 2 * rho * (1 - std::pow(rho, length)) / (length * (1 - rho) * (1 - rho));
  }
};

// Its estimate: from the residuals left at the mean of tracks of six sights and more, the
// estimate's own pull on them allowed for. With few such tracks, mostly what is usual.
class CorrelationSums {
 public:
  // What the landmark's sights say now, in place of what they said.
  void set(int landmark, const FilterLandmark& of, const std::vector<Rigid3>& poses);
  // It has none any more.
  void remove(int landmark) {
    if (static_cast<std::size_t>(landmark) < tracks_.size()) tracks_.reset(landmark);
  }
  SightCorrelation correlation() const;

 private:
  struct OfTrack {
    double sights = 0, pairs = 0, squares = 0, products = 0;
  };
  SharedVector<OfTrack, 64> tracks_;  // by landmark; zero where there are too few sights
};

}  // namespace eifmap
