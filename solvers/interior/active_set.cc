#include "solvers/interior/active_set.h"

#include <algorithm>
#include <limits>

namespace bipot {
namespace {

constexpr double kProximal = 1e-8;
constexpr int kRefinements = 2;

}  // namespace

template <int D>
ActiveSet<D>::ActiveSet(InteriorSystem<D>& system)
    : system_(system), status_(static_cast<std::size_t>(system.num_contacts())) {}

template <int D>
void ActiveSet<D>::start(const InteriorState<D>& z) {
  using Jordan = ContactJordan<D>;
  s_ = z.s;
  u_ = z.u;
  direction_.setZero(s_.size());
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const bool f = system_.friction(c);
    const auto x = Jordan::eigenvalues(system_.pairs(z.X, c), f);
    const auto y = Jordan::eigenvalues(system_.pairs(z.Y, c), f);
    Status& status = status_[static_cast<std::size_t>(c)];
    const Vector& mobility = system_.mobility();
    if (x[0] * mobility[c * D] < y[0]) {
      status = Status::kOpen;
    } else if (!f) {
      status = Status::kFrictionless;
    } else if constexpr (D > 1) {
      // d = 2: edges a (s_t = mu s_n) and c with their multipliers; d = 3: one edge, slip speed.
      const double Wt = mobility[c * D + 1];
      const auto tangent = s_.template segment<D - 1>(c * D + 1);
      bool slips = false;
      if constexpr (D == 2) {
        slips = tangent[0] > 0 ? x[1] * Wt < y[1] : x[2] * Wt < y[2];
      } else {
        slips = x[1] * Wt < Jordan::slip_speed(system_.pairs(z.Y, c), f);
      }
      const double norm = tangent.norm();
      status = slips && norm > 0 ? Status::kSlip : Status::kStick;
      if (norm > 0) direction_.template segment<D - 1>(c * D + 1) = tangent / norm;
    }
  }
}

template <int D>
void ActiveSet<D>::start(const Vector& s) {
  s_ = s;
  system_.delassus().velocity(s_, u_);
  direction_.setZero(s_.size());
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const Vector& mobility = system_.mobility();
    const double normal = s_[c * D] - u_[c * D] / mobility[c * D];
    Status& status = status_[static_cast<std::size_t>(c)];
    if (normal <= 0) {
      status = Status::kOpen;
    } else if (!system_.friction(c)) {
      status = Status::kFrictionless;
    } else if constexpr (D > 1) {
      const Eigen::Matrix<double, D - 1, 1> tangent =
          s_.template segment<D - 1>(c * D + 1) -
          u_.template segment<D - 1>(c * D + 1) / mobility[c * D + 1];
      const double norm = tangent.norm();
      status = norm > system_.mu(c) * normal ? Status::kSlip : Status::kStick;
      if (norm > 0) direction_.template segment<D - 1>(c * D + 1) = tangent / norm;
    }
  }
}

/// Solves the equations of the status, s = g - R u(s). For d = 3 the direction of sliding is
/// linearised at u: it turns by -(I - e eᵀ) du / |u|.
template <int D>
bool ActiveSet<D>::step() {
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  const int contacts = system_.num_contacts();
  R_.assign(static_cast<std::size_t>(contacts) * D * D, 0.0);
  g_.setZero(s_.size());
  for (int c = 0; c < contacts; ++c) {
    const Status status = status_[static_cast<std::size_t>(c)];
    if (status == Status::kOpen) continue;
    Eigen::Map<Block> R(&R_[static_cast<std::size_t>(c) * D * D]);
    const Vector& mobility = system_.mobility();
    R(0, 0) = 1 / (kProximal * mobility[c * D]);
    g_[c * D] = s_[c * D];
    if constexpr (D > 1) {
      const auto e = direction_.template segment<D - 1>(c * D + 1);
      if (status == Status::kStick) {
        for (int k = 1; k < D; ++k) R(k, k) = 1 / (kProximal * mobility[c * D + k]);
        g_.template segment<D - 1>(c * D + 1) = s_.template segment<D - 1>(c * D + 1);
      } else if (status == Status::kSlip) {
        const double mu = system_.mu(c);
        R.template bottomLeftCorner<D - 1, 1>() = mu * R(0, 0) * e;
        if constexpr (D == 3) {
          const double speed = u_.template segment<2>(c * D + 1).norm();
          const double turn =
              mu * std::max(s_[c * D], 0.0) / std::max(speed, std::numeric_limits<double>::min());
          R.template bottomRightCorner<2, 2>() =
              std::min(turn, 1 / (kProximal * mobility[c * D + 1])) *
              (Eigen::Matrix2d::Identity() - e * e.transpose());
        }
        g_.template segment<D - 1>(c * D + 1) = mu * s_[c * D] * e;
      }
    }
  }
  if (!system_.shifted().factor(R_)) return false;
  next_ = s_;
  for (int k = 0; k <= kRefinements; ++k) {
    system_.delassus().velocity(next_, u_);
    residual_ = g_ - next_;
    for (int c = 0; c < contacts; ++c) {
      residual_.template segment<D>(c * D) -=
          Eigen::Map<const Block>(&R_[static_cast<std::size_t>(c) * D * D]) * local<D>(u_, c);
    }
    system_.shifted().solve(residual_, correction_);
    next_ += correction_;
  }
  if (!next_.allFinite()) return false;
  s_ = next_;
  return true;
}

template <int D>
StageEnd ActiveSet<D>::operator()(int cap, InteriorRun& run) {
  for (int k = 0; k < cap; ++k) {
    if (!step()) return StageEnd::kFailed;
    if (run.next(s_, 1)) return StageEnd::kStop;
    if (k + 1 < cap) start(Vector(s_));
  }
  return StageEnd::kLimit;
}

template class ActiveSet<1>;
template class ActiveSet<2>;
template class ActiveSet<3>;

}  // namespace bipot
