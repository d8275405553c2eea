// Covariances of what users ask for that is neither a pose nor a feature of the map: linear
// functions of poses' errors, whose few columns are solved for in the filter's factor. As of the
// last successful update, as all of InformationFilter's; false where that cannot tell.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "filter/information_filter.h"

namespace eifmap {

// Of a_from_b: (rotation vector w in b's camera frame, R <- R Exp(w); displacement of b's centre in
// a's camera frame). Where the map's frame is does not matter to it; its unit does: until the map
// is metric the first baseline's length is the unit, and known.
bool relative_covariance(const InformationFilter& filter, int a, int b, PoseBlock& covariance);

// rad, of all directions together. Less certain than this, earth's orientation may be far from
// linear, or about a line anything: so it is as long as the positions lie almost on a line.
inline constexpr double kEarthUncertain = 0.2;
bool earth_is_certain(const InformationFilter& filter);

// Of earth_from_map * pose: (w in the camera's frame, displacement of the centre in earth).
bool covariance_in_earth(const InformationFilter& filter, int pose, PoseBlock& covariance);

// Of earth_from_map * the landmark's position.
bool landmark_covariance_in_earth(const InformationFilter& filter, int landmark,
                                  Eigen::Matrix3d& covariance);

// Of the logarithm of the factor by which a similarity transform that brings these poses' centres
// to the true ones would scale them, the derivative to each centre, a column each: to first order
// it is the sum of a_k'dc_k with a_k = (c_k - c) / sum |c_k - c|^2, c the mean. `poses`: without
// repetition; false where they are all in one place.
bool log_scale_derivative(const InformationFilter& filter, const std::vector<int>& poses,
                          Eigen::Matrix3Xd& to_centres);

// Its variance. Until the map is metric, in units of the first baseline.
bool log_scale_variance(const InformationFilter& filter, const std::vector<int>& poses,
                        double& variance);

}  // namespace eifmap
