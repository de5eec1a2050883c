#include "solvers/kernels/contact_penalties.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/kernels/round_cone_projection.h"

namespace bipot {
namespace {

constexpr double kStick = 100, kTakeOff = 100, kAcross = 100;
// Largest factor of one change.
constexpr double kStep = 3;
// An impulse within this fraction of the cone will not leave it soon; beyond the other it is on the
// edge.
constexpr double kInside = 0.8, kOnEdge = 0.999;
// In space edges turn, and a contact that sticks beside its edge is as stiff as any other.
constexpr double kInsideRound = 0.99;

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
        const double slip = part_norm<first(), count()>(x), edge = bound * x[0];
        if (slip >= kOnEdge * edge) {
          now = Status::kSlip;
        } else if (slip >= (kRound ? kInsideRound : kInside) * edge && now == Status::kStick) {
          now = Status::kNearEdge;
        }
      });
      if constexpr (kHasEdge) {
        Local<D> friction = x;
        friction[0] = 0;
        if (friction.isZero(0)) friction[1] = 1;  // mu = 0: any direction
        friction.normalize();
        // On the other side of the cone it is another edge.
        if (now == Status::kSlip && !(friction.dot(state.edge) > 0)) state.changed = true;
        if (now == Status::kSlip) state.edge = friction;
      }
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
    if (state.changed) {
      state.along = 1;
    } else if (state.status == Status::kStick) {
      state.along = std::max(before / kStep, 1 / kStick);
    } else if (state.status == Status::kTakeOff) {
      state.along = std::min(before * kStep, kTakeOff);
    } else {
      state.along = before < 1 ? std::min(before * kStep, 1.0) : std::max(before / kStep, 1.0);
    }
    const bool slips = kHasEdge && state.status == Status::kSlip && !state.changed;
    state.across = slips ? std::min(state.across * kStep, kAcross) : 1;
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
  if constexpr (kHasEdge) {
    if (state.across != 1) {
      // The matrix and its inverse have the factor along a direction of unit length.
      const auto stretch = [&](const Local<D>& direction, double factor) {
        metric += (factor - 1) * direction * direction.transpose();
        inverse += (1 / factor - 1) * direction * direction.transpose();
      };
      Local<D> normal = state.edge;
      normal[0] = -friction_[to_size(contact)];
      stretch(normal.normalized(), state.across);
      if constexpr (kRound) {
        stretch(Local<3>(0, -state.edge[2], state.edge[1]), std::sqrt(state.across));
      }
    }
  }
  metric_[to_size(contact)] = rho_ * state.along * metric;
  inverse_[to_size(contact)] = 1 / (rho_ * state.along) * inverse;
}

/// d = 2: r itself, or the nearest point of one of the two edges.
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
  } else if constexpr (kRound) {
    return project_round_cone(metric, mu, r);
  } else {
    return project_coulomb_cone<D>(r, mu);
  }
}

BIPOT_FOR_ROWS(template class ContactPenalties);

}  // namespace bipot
