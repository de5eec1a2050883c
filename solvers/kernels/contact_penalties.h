#pragma once

#include <vector>

#include "core/base/types.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// Penalties of a splitting method (admm.h): one D x D metric M for each contact, in equilibrated
/// variables. They start equal, rho I, and then follow the status of a contact while it lasts:
///
///     stick     the impulse is unknown, the velocity is 0:         smaller by up to kStick
///     take-off  the impulse is 0:                                  larger by up to kTakeOff
///     slip      as for take-off across the edge of the cone:       larger by up to kAcross
///               around the cone (d = 3) the impulse follows u_t:   larger by its root
///
/// A mode of W with eigenvalue lambda is damped by rho / (lambda + rho) if the contacts stick, and
/// by lambda / (lambda + rho) if they are open. No single rho suits both. Contacts that change
/// their status get rho again. Penalties per constraint: Stellato et al. 2020 (OSQP, for equalities
/// known beforehand). [ours] They follow the statuses of the iterates, and act across the edge of
/// the cone.
template <ContactRows D>
class ContactPenalties {
 public:
  using Block = Eigen::Matrix<double, D.count, D.count>;

  /// `friction`: of each contact, in equilibrated variables.
  ContactPenalties(std::vector<FrictionOf<D>> friction, double rho);

  double rho() const { return rho_; }
  /// Multiplies all of them.
  void scale(double factor);

  const Block& metric(int contact) const { return metric_[to_size(contact)]; }
  const Block& inverse(int contact) const { return inverse_[to_size(contact)]; }
  /// The inverses of all metrics, contact after contact.
  const double* inverses() const { return inverse_.data()->data(); }
  Local<D> times(int contact, const Local<D>& v) const { return metric_[to_size(contact)] * v; }
  /// The point of the cone nearest to r in the metric.
  Local<D> project(int contact, const Local<D>& r) const {
    const State& state = state_[to_size(contact)];
    const FrictionOf<D>& mu = friction_[to_size(contact)];
    if constexpr (kHasEdge) {
      if (state.across != 1) return project_across(metric_[to_size(contact)], mu, r);
    }
    return project_coulomb_cone<D>(r, mu);
  }

  /// Records the statuses of an iterate.
  void observe(const Vector& z);
  /// Sets the metrics by the statuses observed since the last call, with M y unchanged.
  void adapt(Vector& y);
  /// Resets all metrics to rho I, with M y unchanged.
  void equalise(Vector& y);

 private:
  /// Coulomb's cone has an edge that penalties can follow; round in space.
  static constexpr bool kHasEdge = !D.rolls && D > 1, kRound = !D.rolls && D == 3;
  enum class Status : unsigned char { kUnknown, kTakeOff, kStick, kNearEdge, kSlip };
  struct State {
    Status status = Status::kUnknown;
    bool changed = true;               ///< since the last adapt()
    double along = 1;                  ///< of the whole metric, over rho
    double across = 1;                 ///< across the edge, over along
    Local<D> edge = Local<D>::Zero();  ///< unit tangent of the friction, in slip
  };

  static Local<D> project_across(const Block& metric, const FrictionOf<D>& mu, const Local<D>& r);
  void set_metric(int contact);

  std::vector<FrictionOf<D>> friction_;
  double rho_;
  std::vector<State> state_;
  std::vector<Block> metric_, inverse_;
};

}  // namespace bipot
