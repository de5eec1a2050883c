#include "solvers/kernels/round_cone_projection.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bipot {
namespace {

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
      if (slope == 0) break;
      const double bend = 2 * (twice.dot(push_) / at.a - a1 * a1) + b1 * b1 -
                          2 * (twice.dot(at.stretched) + turned.dot(metric_ * turned)) / at.b;
      double turn =
          bend < 0 ? std::clamp(-slope / bend, -kTurn, kTurn) : std::copysign(kTurn, slope);
      if (std::abs(turn) <= kLastTurn) return rotated(at, turn);
      Edge next = rotated(at, turn);
      while (!(next.gain() > at.gain()) && std::abs(turn) > kLastTurn) {
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
  // Largest turn, and the one whose square is rounding: the error that Newton's method leaves.
  static constexpr double kTurn = 0.5, kLastTurn = 1e-8;
  Edge rotated(const Edge& at, double turn) const {
    const double c = at.cosine - turn * at.sine, s = at.sine + turn * at.cosine;
    const double length = std::sqrt(c * c + s * s);  // in [1, 1.12]
    return edge(c / length, s / length);
  }

  Eigen::Matrix3d metric_;
  Local<3> push_;
  double mu_;
};

}  // namespace

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

}  // namespace bipot
