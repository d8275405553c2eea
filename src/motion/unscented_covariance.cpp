#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/rigid3.h"
#include "geometry/robust.h"
#include "motion/epipolar_fit.h"
#include "motion/epipolar_geometry.h"

namespace eifmap {
namespace {

// The minimum of the members' cost, and where it goes when one match changes. All the others still
// hold the Hessian: it is taken once, the changed match's share of it exchanged, and the first step
// costs nothing in the number of matches.
class DisturbedMinimum {
 public:
  DisturbedMinimum(std::span<const Correspondence> matches,
                   const std::vector<EpipolarMember>& members, const RelativePose& near,
                   double limit)
      : matches_(matches),
        members_(members),
        limit_(limit),
        centre_(settled(near)),
        basis_(sphere_basis(centre_.direction)) {
    const EpipolarGeometry geometry(centre_);
    terms_.reserve(members.size());
    for (const EpipolarMember& m : members) {
      terms_.push_back(term(geometry, matches[m.match], m.trust));
      sum_.add(terms_.back(), 1);
    }
  }

  // 5-vector (w, ab) from the undisturbed minimum to that with member k's match as given.
  Vector5d step_to(std::size_t k, const Correspondence& changed) const {
    Sum sum = sum_;
    sum.add(terms_[k], -1);
    sum.add(term(EpipolarGeometry(centre_), changed, members_[k].trust), 1);
    const Eigen::LDLT<Matrix5d> factor(sum.hessian);
    RelativePose pose = centre_;
    Vector5d gradient = sum.gradient;
    for (int step = 0; step < kSteps; ++step) {
      const Vector5d change = factor.solve(gradient);
      if (!change.allFinite()) break;
      pose = moved(pose, with_basis(change, basis_, sphere_basis(pose.direction)));
      if (size(change, gradient) < kSmallStep) break;
      gradient = gradient_at(pose, k, changed);
    }
    Vector5d result;
    result << so3_log(centre_.i_from_j.conjugate() * pose.i_from_j),
        basis_.transpose() * (pose.direction - centre_.direction);
    return result;
  }

 private:
  static constexpr int kSteps = 6;
  // See size(). Steps with the kept Hessian shrink some fiftyfold: after one of a tenth the rest is
  // .2 %.
  static constexpr double kSmallStep = 1e-2, kSettled = 1e-6;
  using Basis = Eigen::Matrix<double, 3, 2>;

  struct Term {
    RowVector5d jacobian = RowVector5d::Zero();
    double pull = 0;       // derivative of the cost to the residual
    double curvature = 0;  // second derivative, where it is not negative
  };
  struct Sum {
    Matrix5d hessian = Matrix5d::Zero();
    Vector5d gradient = Vector5d::Zero();  // the step is hessian^-1 gradient

    void add(const Term& t, double sign) {
      hessian.noalias() += sign * t.curvature * t.jacobian.transpose() * t.jacobian;
      gradient.noalias() -= sign * t.pull * t.jacobian.transpose();
    }
  };

  // Squared, in standard deviations that one sigma point stands for.
  double size(const Vector5d& change, const Vector5d& gradient) const {
    return change.dot(gradient) * static_cast<double>(members_.size());
  }

  Term term(const EpipolarGeometry& geometry, const Correspondence& match, double trust) const {
    Term t;
    const double residual = geometry.residual(match, &t.jacobian);
    t.pull = trust * bisquare_weight(residual, limit_) * residual;
    t.curvature = trust * std::max(0.0, bisquare_curvature(residual, limit_));
    return t;
  }

  Vector5d gradient_at(const RelativePose& pose, std::size_t k,
                       const Correspondence& changed) const {
    const EpipolarGeometry geometry(pose);
    Vector5d gradient = Vector5d::Zero();
    RowVector5d jacobian;
    for (std::size_t m = 0; m < members_.size(); ++m) {
      const Correspondence& match = m == k ? changed : matches_[members_[m].match];
      const double residual = geometry.residual(match, &jacobian);
      gradient.noalias() -=
          members_[m].trust * bisquare_weight(residual, limit_) * residual * jacobian.transpose();
    }
    return with_basis(gradient, sphere_basis(pose.direction), basis_);
  }

  // (w, ab) of one tangent plane in the basis of its neighbour: the Hessian is in the centre's, and
  // sphere_basis() may turn between two close directions.
  static Vector5d with_basis(const Vector5d& v, const Basis& from, const Basis& to) {
    Vector5d result = v;
    result.tail<2>() = to.transpose() * (from * v.tail<2>());
    return result;
  }

  // A step of the last refinement left undone would show in every sigma point.
  RelativePose settled(RelativePose pose) const {
    for (int step = 0; step < 4 * kSteps; ++step) {
      const EpipolarNormal normal = linearize(matches_, members_, pose, limit_);
      const Vector5d change = normal.information.ldlt().solve(normal.gradient);
      if (!change.allFinite()) break;
      pose = moved(pose, change);
      if (size(change, normal.gradient) < kSettled) break;
    }
    return pose;
  }

  std::span<const Correspondence> matches_;
  const std::vector<EpipolarMember>& members_;
  double limit_;
  RelativePose centre_;
  Basis basis_;  // of the tangent plane at the centre's direction
  std::vector<Term> terms_;
  Sum sum_;
};

}  // namespace

bool set_unscented_covariance(std::span<const Correspondence> matches,
                              const std::vector<EpipolarMember>& members, double spread,
                              RelativePose& pose) {
  const double claimed = std::max(1.0, spread);
  const double limit = kBisquare * claimed;
  const Eigen::LLT<Matrix5d> measured(linearize(matches, members, pose, limit).information);
  if (measured.info() != Eigen::Success || !(measured.rcond() > 1e-12)) return false;
  const DisturbedMinimum minimum(matches, members, pose, limit);
  const double length = std::sqrt(3.0) * claimed;
  Matrix5d sum = Matrix5d::Zero();
  for (std::size_t k = 0; k < members.size(); ++k) {
    const Correspondence& match = matches[members[k].match];
    const auto add = [&](const Correspondence& changed) {
      const Vector5d step = minimum.step_to(k, changed);
      sum.noalias() += step * step.transpose();
    };
    for (const double side : {-length, length})
      for (const int axis : {0, 1}) {
        Correspondence changed = match;
        changed.x_i[axis] += side * match.sigma_i;
        add(changed);
        changed = match;
        changed.x_j[axis] += side * match.sigma_j;
        add(changed);
      }
  }
  // About the centre's own image and not the mean, whose weight 1 - 4 N / 3 is far below 0 (the
  // modified form of Julier and Uhlmann, which cannot be indefinite).
  pose.covariance = sum / 6;
  return set_sigma_direction(pose);
}

}  // namespace eifmap
