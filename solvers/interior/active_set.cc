#include "solvers/interior/active_set.h"

#include <algorithm>
#include <limits>

namespace bipot {
namespace {

constexpr double kProximal = 1e-8;
constexpr int kRefinements = 2;

}  // namespace

template <ContactRows D>
ActiveSet<D>::ActiveSet(InteriorSystem<D>& system)
    : system_(system), status_(to_size(system.num_contacts())) {}

template <ContactRows D>
void ActiveSet<D>::start(const InteriorState<D>& z) {
  s_ = z.s;
  u_ = z.u;
  direction_.setZero(s_.size());
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const unsigned f = system_.parts(c);
    const auto x = Jordan::eigenvalues(system_.pairs(z.X, c), f);
    const auto y = Jordan::eigenvalues(system_.pairs(z.Y, c), f);
    unsigned& status = status_[to_size(c)];
    const Vector& mobility = system_.mobility();
    status = x[0] * mobility[c * D] < y[0] ? kOpen : 0;
    if (status == kOpen) continue;
    Jordan::each_part(f, [&](auto first, auto count, auto pair) {
      // One row: edges a (s_t = mu s_n) and c with their multipliers; two: one edge, slip speed.
      const int row = c * D + first();
      constexpr int part = pair() - first(), at = 1 + 2 * part;
      const double Wt = mobility[row];
      const auto tangent = s_.template segment<count()>(row);
      const int edge = count() == 2 || tangent[0] > 0 ? at : at + 1;
      const double speed = count() == 2 ? z.Y[c * Jordan::P + pair()] : y[edge];
      const double norm = tangent.norm();
      if (x[edge] * Wt < speed && norm > 0) status |= 1U << part;
      if (norm > 0) direction_.template segment<count()>(row) = tangent / norm;
    });
  }
}

template <ContactRows D>
void ActiveSet<D>::start(const Vector& s) {
  s_ = s;
  system_.delassus().velocity(s_, u_);
  direction_.setZero(s_.size());
  for (int c = 0; c < system_.num_contacts(); ++c) {
    const Vector& mobility = system_.mobility();
    const double normal = s_[c * D] - u_[c * D] / mobility[c * D];
    unsigned& status = status_[to_size(c)];
    status = normal <= 0 ? kOpen : 0;
    if (status == kOpen) continue;
    Jordan::each_part(
        system_.parts(c), system_.mu(c), [&](auto first, auto count, auto pair, double bound) {
          const int row = c * D + first();
          const Eigen::Matrix<double, count(), 1> tangent =
              s_.template segment<count()>(row) - u_.template segment<count()>(row) / mobility[row];
          const double norm = tangent.norm();
          if (norm > bound * normal) status |= 1U << (pair() - first());
          if (norm > 0) direction_.template segment<count()>(row) = tangent / norm;
        });
  }
}

/// Solves the equations of the status, s = g - R u(s). For d = 3 the direction of sliding is
/// linearised at u: it turns by -(I - e eᵀ) du / |u|.
template <ContactRows D>
bool ActiveSet<D>::step() {
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  const int contacts = system_.num_contacts();
  R_.assign(to_size(contacts) * D * D, 0.0);
  g_.setZero(s_.size());
  for (int c = 0; c < contacts; ++c) {
    const unsigned status = status_[to_size(c)];
    if (status == kOpen) continue;
    Eigen::Map<Block> R(&R_[to_size(c) * D * D]);
    const Vector& mobility = system_.mobility();
    R(0, 0) = 1 / (kProximal * mobility[c * D]);
    g_[c * D] = s_[c * D];
    Jordan::each_part(
        system_.parts(c), system_.mu(c), [&](auto first, auto count, auto pair, double mu) {
          constexpr int from = first(), rows = count();
          const int row = c * D + from;
          const auto e = direction_.template segment<rows>(row);
          if ((status >> (pair() - from) & 1U) == 0) {
            for (int k = from; k < from + rows; ++k)
              R(k, k) = 1 / (kProximal * mobility[c * D + k]);
            g_.template segment<rows>(row) = s_.template segment<rows>(row);
            return;
          }
          R.template block<rows, 1>(from, 0) = mu * R(0, 0) * e;
          if constexpr (rows == 2) {
            const double speed = u_.template segment<2>(row).norm();
            const double turn =
                mu * std::max(s_[c * D], 0.0) / std::max(speed, std::numeric_limits<double>::min());
            R.template block<2, 2>(from, from) = std::min(turn, 1 / (kProximal * mobility[row])) *
                                                 (Eigen::Matrix2d::Identity() - e * e.transpose());
          }
          g_.template segment<rows>(row) = mu * s_[c * D] * e;
        });
  }
  if (!system_.shifted().factor(R_)) return false;
  next_ = s_;
  for (int k = 0; k <= kRefinements; ++k) {
    system_.delassus().velocity(next_, u_);
    residual_ = g_ - next_;
    for (int c = 0; c < contacts; ++c) {
      residual_.template segment<D>(c * D) -=
          Eigen::Map<const Block>(&R_[to_size(c) * D * D]) * local<D>(u_, c);
    }
    system_.shifted().solve(residual_, correction_);
    next_ += correction_;
  }
  if (!next_.allFinite()) return false;
  s_ = next_;
  return true;
}

template <ContactRows D>
StageEnd ActiveSet<D>::operator()(int cap, InteriorRun& run) {
  for (int k = 0; k < cap; ++k) {
    if (!step()) return StageEnd::kFailed;
    if (run.next(s_, 1)) return StageEnd::kStop;
    if (k + 1 < cap) start(Vector(s_));
  }
  return StageEnd::kLimit;
}

BIPOT_FOR_ROWS(template class ActiveSet);

}  // namespace bipot
