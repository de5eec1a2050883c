#include "solvers/kernels/contact_penalties.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace bipot {
namespace {

constexpr double kStick = 100, kTakeOff = 100, kAcross = 100;
// Largest factor of one change.
constexpr double kStep = 3;
// An impulse within this fraction of the cone will not leave it soon; beyond the other it is on the
// edge.
constexpr double kInside = 0.8, kOnEdge = 0.999;

}  // namespace

template <ContactRows D>
ContactPenalties<D>::ContactPenalties(std::vector<FrictionOf<D>> friction, double rho)
    : friction_(std::move(friction)),
      rho_(rho),
      state_(friction_.size()),
      metric_(state_.size(), rho * Block::Identity()),
      inverse_(state_.size(), 1 / rho * Block::Identity()) {}

template <ContactRows D>
void ContactPenalties<D>::scale(double factor) {
  rho_ *= factor;
  for (Block& block : metric_) block *= factor;
  for (Block& block : inverse_) block /= factor;
}

template <ContactRows D>
void ContactPenalties<D>::observe(const Vector& z) {
  for (int c = 0; c < static_cast<int>(friction_.size()); ++c) {
    State& state = state_[to_size(c)];
    Status now = Status::kStick;
    if (!(z[c * D] > 0)) {
      now = Status::kTakeOff;
    } else {
      const Local<D> x = z.segment<D>(c * D);
      each_bounded<D>(friction_[to_size(c)], [&](auto first, auto count, double bound) {
        const double slip = part_norm<first(), count()>(x);
        const double edge = bound * x[0];
        if (slip >= kOnEdge * edge) {
          // In 3D the sign would depend on the choice of tangents, and it is not needed.
          now = D == 2 && x[1] < 0 ? Status::kSlipBack : Status::kSlip;
        } else if (slip >= kInside * edge && now == Status::kStick) {
          now = Status::kNearEdge;
        }
      });
    }
    if (now != state.status) state.changed = true;
    state.status = now;
  }
}

template <ContactRows D>
void ContactPenalties<D>::adapt(Vector& y) {
  for (int c = 0; c < static_cast<int>(friction_.size()); ++c) {
    State& state = state_[to_size(c)];
    const double before = state.along;
    const bool slips = state.status == Status::kSlip || state.status == Status::kSlipBack;
    if (state.changed) {
      state.along = 1;
    } else if (state.status == Status::kStick) {
      state.along = std::max(before / kStep, 1 / kStick);
    } else if (state.status == Status::kTakeOff) {
      state.along = std::min(before * kStep, kTakeOff);
    } else {
      state.along = before < 1 ? std::min(before * kStep, 1.0) : std::max(before / kStep, 1.0);
    }
    state.across = D == 2 && slips && !state.changed ? std::min(state.across * kStep, kAcross) : 1;
    state.changed = false;
    const Local<D> push = times(c, y.segment<D>(c * D));
    set_metric(c);
    y.segment<D>(c * D) = inverse(c) * push;
  }
}

template <ContactRows D>
void ContactPenalties<D>::equalise(Vector& y) {
  for (State& state : state_) state = {};
  adapt(y);
}

template <ContactRows D>
void ContactPenalties<D>::set_metric(int contact) {
  const State& state = state_[to_size(contact)];
  Block metric = Block::Identity(), inverse = Block::Identity();
  if constexpr (D == 2) {
    if (state.across != 1) {
      const double side = state.status == Status::kSlip ? 1 : -1;
      const Local<2> normal = Local<2>(-friction_[to_size(contact)], side).normalized();
      metric += (state.across - 1) * normal * normal.transpose();
      inverse += (1 / state.across - 1) * normal * normal.transpose();
    }
  }
  metric_[to_size(contact)] = rho_ * state.along * metric;
  inverse_[to_size(contact)] = 1 / (rho_ * state.along) * inverse;
}

/// The cone in 2D: r itself, or the nearest point of one of the two edges.
template <ContactRows D>
Local<D> ContactPenalties<D>::project_across(const Block& metric, const FrictionOf<D>& mu,
                                             const Local<D>& r) {
  if constexpr (D == 2) {
    if (std::abs(r[1]) <= mu * r[0]) return r;
    const Local<2> push = metric * r;
    // Of the multiples of both edges, the one that reduces the norm of r most.
    Local<2> nearest = Local<2>::Zero();
    double most = 0;
    for (const double side : {-mu, mu}) {
      const Local<2> edge(1, side);
      const double along = edge.dot(push);
      if (!(along > 0)) continue;
      const double square = edge.dot(metric * edge);
      if (along * along > most * square) {
        most = along * along / square;
        nearest = along / square * edge;
      }
    }
    return nearest;
  } else {
    return project_coulomb_cone<D>(r, mu);
  }
}

template class ContactPenalties<1>;
template class ContactPenalties<2>;
template class ContactPenalties<3>;
template class ContactPenalties<ContactRows(3, true)>;
template class ContactPenalties<ContactRows(6, true)>;

}  // namespace bipot
