#include "solvers/kernels/local_coulomb.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace bipot {
namespace {

constexpr double kAccepted = 1e-9;  // relative natural map of an accepted solution
constexpr int kNewtonLimit = 100;

template <int D>
Local<D> velocity(const LocalProblem<D>& p, const Local<D>& s) {
  return p.w * s + p.q;
}

template <int D>
void cut_off_tangential(Local<D>& s, double mu) {
  if constexpr (D > 1) {
    const double norm = tangential_norm<D>(s), radius = mu * s[0];
    if (norm > radius) s.template tail<D - 1>() *= radius / norm;
  }
}

/// Natural map with separate steps, relative to s and to the impulse that would stop q.
template <int D>
bool accepted(const LocalProblem<D>& p, const Local<D>& s) {
  const Local<D> next = improve_local<D>(p, s, velocity<D>(p, s), 1.0, 1);
  const double size = s.norm() + p.step_normal * p.q.norm();
  return (next - s).norm() <= kAccepted * size;
}

/// Slip in 2D: u_n = 0, s_t = side mu s_n, side u_t <= 0. The candidate nearest to s.
bool solve_slip(const LocalProblem<2>& p, Local<2>& s) {
  bool found = false;
  double nearest = std::numeric_limits<double>::infinity();
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

template <int D>
LocalProblem<D> local_problem(const Eigen::MatrixXd& w, double mu) {
  LocalProblem<D> p;
  p.w = w;
  p.q.setZero();
  p.mu = mu;
  p.step_normal = 1 / w(0, 0);
  double largest = 0;
  if constexpr (D == 2) {
    largest = w(1, 1);
  } else if constexpr (D == 3) {
    const double mean = 0.5 * (w(1, 1) + w(2, 2)), half = 0.5 * (w(1, 1) - w(2, 2));
    const double coupling = 0.5 * (w(1, 2) + w(2, 1));
    largest = mean + std::sqrt(half * half + coupling * coupling);
  }
  p.step_tangential = largest > 1e-12 * w(0, 0) ? 1 / largest : p.step_normal;
  return p;
}

template <int D>
Local<D> improve_local(const LocalProblem<D>& p, Local<D> s, Local<D> u, double omega,
                       int iterations) {
  for (int k = 0; k < iterations; ++k) {
    const Local<D> before = s;
    s[0] = positive_part(s[0] - omega * p.step_normal * u[0]);
    if constexpr (D > 1) {
      const double change = s[0] - before[0];
      for (int a = 1; a < D; ++a) {
        s[a] -= omega * p.step_tangential * (u[a] + p.w(a, 0) * change);
      }
      cut_off_tangential<D>(s, p.mu);
    }
    if (k + 1 < iterations) u += p.w * (s - before);
  }
  return s;
}

template <int D>
bool solve_local(const LocalProblem<D>& p, Local<D>& s) {
  if (p.q[0] >= 0) {
    s.setZero();
    return true;
  }
  if constexpr (D == 1) {
    s[0] = -p.q[0] * p.step_normal;
    return true;
  } else {
    const Local<D> stick = -(p.w.partialPivLu().solve(p.q));
    if (stick.allFinite() && tangential_norm<D>(stick) <= p.mu * stick[0] &&
        accepted<D>(p, stick)) {
      s = stick;
      return true;
    }
    return solve_slip(p, s);
  }
}

template LocalProblem<1> local_problem<1>(const Eigen::MatrixXd&, double);
template LocalProblem<2> local_problem<2>(const Eigen::MatrixXd&, double);
template LocalProblem<3> local_problem<3>(const Eigen::MatrixXd&, double);
template Local<1> improve_local<1>(const LocalProblem<1>&, Local<1>, Local<1>, double, int);
template Local<2> improve_local<2>(const LocalProblem<2>&, Local<2>, Local<2>, double, int);
template Local<3> improve_local<3>(const LocalProblem<3>&, Local<3>, Local<3>, double, int);
template bool solve_local<1>(const LocalProblem<1>&, Local<1>&);
template bool solve_local<2>(const LocalProblem<2>&, Local<2>&);
template bool solve_local<3>(const LocalProblem<3>&, Local<3>&);

}  // namespace bipot
