#include "solvers/kernels/local_coulomb.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <utility>

namespace bipot {
namespace {

constexpr double kAccepted = 1e-9;  // relative natural map of an accepted solution
constexpr int kNewtonLimit = 100;
constexpr int kRoundLimit = 1000;
constexpr double kSettled = 1e-15;  // relative natural map from which rounds are over

template <ContactRows D>
Local<D> velocity(const LocalProblem<D>& p, const Local<D>& s) {
  return p.w * s + p.q;
}

/// The largest eigenvalue of the symmetric part of the block of two rows from `first` on.
double largest_of_two(const Eigen::MatrixXd& w, int first) {
  const double a = w(first, first), b = w(first + 1, first + 1), half = 0.5 * (a - b);
  const double coupling = 0.5 * (w(first, first + 1) + w(first + 1, first));
  return 0.5 * (a + b) + std::sqrt(half * half + coupling * coupling);
}

/// Natural map with separate steps, relative to s and to the impulse that would stop q, as energies.
template <ContactRows D>
double relative_map(const LocalProblem<D>& p, const Local<D>& s, const Local<D>& next) {
  const Local<D> steps = steps_of<D>(p);
  double change = 0, size = 0;
  for (int k = 0; k < D; ++k) {
    if (!(steps[k] > 0)) continue;
    change += (next[k] - s[k]) * (next[k] - s[k]) / steps[k];
    size += s[k] * s[k] / steps[k] + steps[k] * p.q[k] * p.q[k];
  }
  return std::sqrt(change / size);
}

/// Natural map with separate steps, relative to s and to the impulse that would stop q.
template <ContactRows D>
bool accepted(const LocalProblem<D>& p, const Local<D>& s) {
  const Local<D> next = improve_local<D>(p, s, velocity<D>(p, s), 1.0, 1);
  const double size = s.norm() + p.step_normal * p.q.norm();
  return (next - s).norm() <= kAccepted * size;
}

/// Slip in 2D: u_n = 0, s_t = side mu s_n, side u_t <= 0. The candidate nearest to s.
bool solve_slip(const LocalProblem<2>& p, Local<2>& s) {
  bool found = false;
  double nearest = kInfinity;
  const Local<2> start = s;
  for (const double side : {-1.0, 1.0}) {
    const double stiffness = p.w(0, 0) + side * p.mu * p.w(0, 1);
    if (!(stiffness > 0)) continue;
    const double normal = -p.q[0] / stiffness;
    const Local<2> candidate(normal, side * p.mu * normal);
    const double distance = (candidate - start).squaredNorm();
    if (distance < nearest && accepted<2>(p, candidate)) {
      nearest = distance;
      s = candidate;
      found = true;
    }
  }
  return found;
}

bool solve_slip(const LocalProblem<3>& p, Local<3>& s) {
  using Tangent = Eigen::Matrix<double, 2, 1, Eigen::DontAlign>;
  using TangentBlock = Eigen::Matrix<double, 2, 2, Eigen::DontAlign>;
  if (p.mu == 0) {
    s = Local<3>(-p.q[0] * p.step_normal, 0, 0);
    return true;
  }
  const Tangent w_nt(p.w(0, 1), p.w(0, 2)), w_tn(p.w(1, 0), p.w(2, 0));
  const TangentBlock schur = p.w.bottomRightCorner<2, 2>() - w_tn * w_nt.transpose() / p.w(0, 0);
  const Tangent r = p.q.tail<2>() - w_tn * (p.q[0] / p.w(0, 0));
  double low = 0;
  double high = 1.01 * (schur.norm() +
                        r.norm() * (p.w(0, 0) + p.mu * w_nt.norm()) / (p.mu * std::abs(p.q[0])));
  double factor = 0.5 * std::min(high, schur.norm());
  Local<3> candidate = s;
  for (int k = 0; k < kNewtonLimit; ++k) {
    TangentBlock shifted = schur;
    shifted.diagonal().array() += factor;
    const TangentBlock inverse = shifted.inverse();
    const Tangent x = -(inverse * r);
    const double normal = -(p.q[0] + w_nt.dot(x)) / p.w(0, 0);
    const double norm = x.norm();
    candidate << normal, x;
    const bool too_small = norm > p.mu * normal;  // the factor, that is
    (too_small ? low : high) = factor;
    double next = 0.5 * (low + high);
    if (normal > 0 && norm > 0) {
      const Tangent slope = -(inverse * x);
      const double value = 1 / norm - 1 / (p.mu * normal);
      const double derivative = -x.dot(slope) / (norm * norm * norm) -
                                w_nt.dot(slope) / (p.w(0, 0) * p.mu * normal * normal);
      const double newton = factor - value / derivative;
      if (newton > low && newton < high) next = newton;
    }
    if (std::abs(next - factor) <= 4 * std::numeric_limits<double>::epsilon() * factor) break;
    factor = next;
  }
  if (!(candidate[0] > 0)) return false;
  candidate.tail<2>() *= p.mu * candidate[0] / candidate.tail<2>().norm();
  if (!accepted<3>(p, candidate)) return false;
  s = candidate;
  return true;
}

}  // namespace

template <ContactRows D>
LocalProblem<D> local_problem(const Eigen::MatrixXd& w, const FrictionOf<D>& mu) {
  LocalProblem<D> p;
  p.w = w;
  p.q.setZero();
  p.mu = mu;
  p.step_normal = 1 / w(0, 0);
  double largest = 0;
  if constexpr (D.tangents() == 1) largest = w(1, 1);
  if constexpr (D.tangents() == 2) largest = largest_of_two(w, 1);
  p.step_tangential = largest > 1e-12 * w(0, 0) ? 1 / largest : p.step_normal;
  if constexpr (D.rolls && D == 3) p.step_rolling = 1 / w(2, 2);
  if constexpr (D.rolls && D == 6) {
    p.step_rolling = 1 / largest_of_two(w, 3);
    p.step_spin = 1 / w(5, 5);
  }
  for (double* step : {&p.step_rolling, &p.step_spin}) {
    if (!std::isfinite(*step)) *step = 0;
  }
  return p;
}

/// w⁻¹ x by elimination with row exchanges; not finite if w is singular.
template <int D>
Local<D> solved(LocalBlock<D> w, Local<D> x) {
  for (int k = 0; k < D; ++k) {
    int pivot = k;
    for (int i = k + 1; i < D; ++i) {
      if (std::abs(w(i, k)) > std::abs(w(pivot, k))) pivot = i;
    }
    if (w(pivot, k) == 0) continue;
    for (int j = 0; j < D; ++j) std::swap(w(k, j), w(pivot, j));
    std::swap(x[k], x[pivot]);
    for (int i = k + 1; i < D; ++i) {
      w(i, k) /= w(k, k);
      for (int j = k + 1; j < D; ++j) w(i, j) -= w(i, k) * w(k, j);
    }
  }
  const auto eliminate = [&](int i, int begin, int end) {
    double sum = 0;
    for (int j = begin; j < end; ++j) sum += w(i, j) * x[j];
    x[i] -= sum;
  };
  for (int i = 1; i < D; ++i) eliminate(i, 0, i);
  for (int i = D - 1; i >= 0; --i) {
    eliminate(i, i + 1, D);
    x[i] /= w(i, i);
  }
  return x;
}

template <ContactRows D>
bool solve_local(const LocalProblem<D>& p, Local<D>& s) {
  if (p.q[0] >= 0) {
    s.setZero();
    return true;
  }
  if constexpr (D == 1) {
    s[0] = -p.q[0] * p.step_normal;
    return true;
  } else if constexpr (D.rolls) {
    Local<D> now = s;
    double map = 1;
    for (int k = 0; k < kRoundLimit && map > kSettled; ++k) {
      const Local<D> next = improve_local<D>(p, now, velocity<D>(p, now), 1.0, 1);
      map = relative_map<D>(p, now, next);
      now = next;
    }
    if (!(map <= kAccepted)) return false;
    s = now;
    return true;
  } else {
    const Local<D> stick = -solved<D>(p.w, p.q);
    if (stick.allFinite() && tangential_norm<D>(stick) <= p.mu * stick[0] &&
        accepted<D>(p, stick)) {
      s = stick;
      return true;
    }
    return solve_slip(p, s);
  }
}

#define BIPOT_LOCAL(rows)                                                   \
  template LocalProblem<rows> local_problem<rows>(const Eigen::MatrixXd&,   \
                                                  const FrictionOf<rows>&); \
  template bool solve_local<rows>(const LocalProblem<rows>&, Local<rows>&);
BIPOT_LOCAL(1)
BIPOT_LOCAL(2)
BIPOT_LOCAL(3)
BIPOT_LOCAL((ContactRows{3, true}))
BIPOT_LOCAL((ContactRows{6, true}))
#undef BIPOT_LOCAL

}  // namespace bipot
