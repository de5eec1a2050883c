#include "solvers/kernels/contact_penalties.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

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

/// The multiple of an edge e = (1, mu cos, mu sin) of the round cone that is nearest to r in the
/// metric M. It is a / b e with a = e·M r > 0 and b = e·M e, and reduces the square of the norm of r
/// by a² / b: Newton's method for the largest logarithm of it, each step an ascent.
class NearestEdge {
 public:
  NearestEdge(const Eigen::Matrix3d& metric, double mu, const Local<3>& r)
      : metric_(metric), push_(metric * r), mu_(mu) {}

  /// False if the multiplier M r lies in the polar cone: the nearest point is the tip.
  bool exists() const { return push_[0] > -mu_ * tangential_norm<3>(push_); }
  /// Where an edge points to, and how much it reduces the norm; 0 if no multiple of it does.
  struct Edge {
    double cosine = 1, sine = 0;
    Local<3> direction = Local<3>::Zero(), stretched = direction;  ///< e, M e
    double a = 0, b = 1;

    double gain() const { return a > 0 ? a * a / b : 0; }
  };
  Edge edge(double cosine, double sine) const {
    Edge made{cosine, sine, Local<3>(1, mu_ * cosine, mu_ * sine)};
    made.stretched = metric_ * made.direction;
    made.a = made.direction.dot(push_);
    made.b = made.direction.dot(made.stretched);
    return made;
  }
  /// The edge with the largest a, > 0 if exists().
  Edge first() const {
    const double length = tangential_norm<3>(push_);
    return length > 0 ? edge(push_[1] / length, push_[2] / length) : edge(1, 0);
  }
  Edge climb(Edge at) const {
    for (int k = 0; k < kSteps; ++k) {
      const Local<3> turned(0, -at.direction[2], at.direction[1]);
      const Local<3> twice(0, -at.direction[1], -at.direction[2]);
      const double a1 = turned.dot(push_) / at.a, b1 = 2 * turned.dot(at.stretched) / at.b;
      const double slope = 2 * a1 - b1;
      if (std::abs(slope) <= kFlat * (std::abs(2 * a1) + std::abs(b1))) break;
      const double bend = 2 * (twice.dot(push_) / at.a - a1 * a1) + b1 * b1 -
                          2 * (twice.dot(at.stretched) + turned.dot(metric_ * turned)) / at.b;
      double turn =
          bend < 0 ? std::clamp(-slope / bend, -kTurn, kTurn) : std::copysign(kTurn, slope);
      Edge next = rotated(at, turn);
      while (!(next.gain() > at.gain()) && std::abs(turn) > kFlat) {
        turn *= 0.25;
        next = rotated(at, turn);
      }
      if (!(next.gain() > at.gain())) break;
      at = next;
    }
    return at;
  }

 private:
  static constexpr int kSteps = 100;
  static constexpr double kTurn = 0.5, kFlat = 1e-14;
  Edge rotated(const Edge& at, double turn) const {
    const double c = at.cosine - turn * at.sine, s = at.sine + turn * at.cosine;
    const double length = std::hypot(c, s);
    return edge(c / length, s / length);
  }

  Eigen::Matrix3d metric_;
  Local<3> push_;
  double mu_;
};

/// The point of the round cone nearest to r in the metric. Of all edges the nearest alone has a
/// multiplier M (r - z) that points outward.
Local<3> project_round_cone(const Eigen::Matrix3d& metric, double mu, const Local<3>& r) {
  if (tangential_norm<3>(r) <= mu * r[0]) return r;
  const NearestEdge nearest(metric, mu, r);
  if (!nearest.exists()) return Local<3>::Zero();
  NearestEdge::Edge best = nearest.climb(nearest.first());
  const Local<3> multiplier = metric * r - best.a / best.b * best.stretched;
  if (!(multiplier.dot(Local<3>(-mu, best.cosine, best.sine)) >= 0)) {
    constexpr int kStarts = 32;
    for (int k = 0; k < kStarts; ++k) {
      const double angle = 2 * std::numbers::pi * k / kStarts;
      const NearestEdge::Edge other = nearest.edge(std::cos(angle), std::sin(angle));
      if (other.gain() > best.gain()) best = other;
    }
    best = nearest.climb(best);
  }
  return best.a / best.b * best.direction;
}

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

template class ContactPenalties<1>;
template class ContactPenalties<2>;
template class ContactPenalties<3>;
template class ContactPenalties<ContactRows(3, true)>;
template class ContactPenalties<ContactRows(6, true)>;

}  // namespace bipot
