#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// Penalties of a splitting method (admm.h), one D x D metric M a contact in equilibrated variables.
/// They are equal at first, rho I, and then follow what a contact does as long as it goes on doing it:
///
///     stick     its impulse is to be found, its velocity is 0:        smaller by up to kStick
///     take-off  its impulse is 0:                                     larger by up to kTakeOff
///     slip      as for take-off across the cone's edge, d = 2 alone:  larger by up to kAcross
///
/// A mode of W with eigenvalue lambda dies as rho / (lambda + rho) where the contacts stick, as
/// lambda / (lambda + rho) where they are open; no one rho suits both. Contacts that change get rho
/// again. (Penalties per constraint: Stellato et al. 2020, OSQP, where equalities are known
/// beforehand; [ours] from the statuses of the iterates, and across the edge of the cone.)
template <int D>
class ContactPenalties {
 public:
  using Block = Eigen::Matrix<double, D, D>;

  ContactPenalties(Vector mu, double rho);

  double rho() const { return rho_; }
  /// Multiplies all of them.
  void scale(double factor);

  const Block& metric(int contact) const { return metric_[to_size(contact)]; }
  const Block& inverse(int contact) const { return inverse_[to_size(contact)]; }
  /// All of them, contact after contact.
  const double* inverses() const { return inverse_.data()->data(); }
  Local<D> times(int contact, const Local<D>& v) const { return metric_[to_size(contact)] * v; }
  /// The point of the cone next to r in the metric.
  Local<D> project(int contact, const Local<D>& r) const {
    const State& state = state_[to_size(contact)];
    const double mu = mu_[contact];
    if constexpr (D == 2) {
      if (state.across != 1) return project_across(metric_[to_size(contact)], mu, r);
    }
    return project_coulomb_cone<D>(r, mu);
  }

  /// Remembers the statuses of an iterate.
  void observe(const Vector& z);
  /// Sets the metrics by the statuses observed since the last time; M y stays as it is.
  void adapt(Vector& y);
  /// All are rho I again; M y stays as it is.
  void equalise(Vector& y);

 private:
  enum class Status : unsigned char { kUnknown, kTakeOff, kStick, kNearEdge, kSlip, kSlipBack };
  struct State {
    Status status = Status::kUnknown;
    bool changed = true;  ///< since the last adapt()
    double along = 1;     ///< of the whole metric, over rho
    double across = 1;    ///< across the edge, over along
  };

  static Local<D> project_across(const Block& metric, double mu, const Local<D>& r);
  void set_metric(int contact);

  Vector mu_;
  double rho_;
  std::vector<State> state_;
  std::vector<Block> metric_, inverse_;
};

}  // namespace bipot
