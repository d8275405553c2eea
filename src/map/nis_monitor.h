// Whether innovations are as large as the filter's sigmas say: a running chi-square for each kind
// of measurement.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <string>

#include "map/innovations.h"
#include "map_view.h"

namespace eifmap {

// Mean of a chi-square variable of `degrees` degrees of freedom of those below `limit`.
double truncated_chi_square_mean(int degrees, double limit);

// The last keyframes' innovations of each kind. With a variance that is s^2 times what is claimed
// the mean of the squares within a gate g is s^2 M(g^2 / s^2), M(a) the mean of chi-square below a:
// solving that for s^2 gives the ratio as it would be without the gate. A gate of 3.5 would else
// show a noise of twice the sigma as 1.5 times.
//
// The alarm is for what matters, not for what is significant: no image is as the model says, and
// among tens of thousands of sights a hundredth of a sigma would be. It is raised when the ratio,
// less what chance may do to it, is beyond kSuspect: noise of 1.4 times the sigmas, or of as much
// less. Chance is taken to be as large as the correlation of a track's errors can make it.
class NisMonitor {
 public:
  static constexpr int kFewest = 5, kWindow = 100;  // keyframes
  static constexpr double kSuspect = 2.0;           // ratio of variances, and its inverse

  // Of a keyframe that has become part of the map. `variance_factor`: of SightCorrelation.
  void add(const Innovations& innovations, double variance_factor);

  // Nothing (count 0) of a kind that there is none of.
  NisRatio ratio(InnovationKind kind) const { return ratios_[static_cast<std::size_t>(kind)]; }
  bool alarm() const { return alarm_; }
  // The alarm in words: how many times what the sigmas say the residuals are.
  std::string detail(double sigma_factor) const;

  // While there is an alarm, a tracked frame that has no reason gets kSigmaSuspect.
  void warn(FrameResult& result, double sigma_factor) const;

 private:
  std::deque<Innovations> window_;
  std::array<NisRatio, kInnovationKinds> ratios_;
  bool alarm_ = false;
};

}  // namespace eifmap
