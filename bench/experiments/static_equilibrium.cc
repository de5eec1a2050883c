#include "bench/experiments/static_equilibrium.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "core/base/triplets.h"
#include "core/problem/delassus.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// Contacts 2k and 2k + 1 push along the edges (1, ±mu) of the cone of contact k, unit length.
ContactProblem edges(const ContactProblem& p) {
  ContactProblem q{.dim = 1, .A = p.A, .v_free = p.v_free};
  Triplets entries;
  entries.reserve(static_cast<std::size_t>(4 * p.H.nonZeros()));
  for (int k = 0; k < p.num_contacts(); ++k) {
    const double length = std::hypot(1, p.mu[k]);
    for (int edge = 0; edge < 2; ++edge) {
      const double weight[2] = {1 / length, (edge == 0 ? p.mu[k] : -p.mu[k]) / length};
      for (int row = 0; row < 2; ++row) {
        for (SparseMatrix::InnerIterator it(p.H, 2 * k + row); it; ++it) {
          entries.emplace_back(static_cast<int>(it.row()), 2 * k + edge, it.value() * weight[row]);
        }
      }
    }
  }
  q.H = from_triplets(p.H.rows(), 2 * p.num_contacts(), entries);
  q.H.makeCompressed();
  q.mu = Vector::Zero(2 * p.num_contacts());
  q.u_free = q.H.transpose() * q.v_free;
  return q;
}

}  // namespace

StaticEquilibrium static_equilibrium(const ContactProblem& problem) {
  if (problem.dim != 2 || !problem.has_velocities() || problem.row_scale.size() > 0) {
    throw std::invalid_argument(
        "static equilibrium: a plane problem with H and without restitution is needed");
  }
  const ContactProblem q = edges(problem);
  const SolveResult result = solve("ipm", q, {.tol = 1e-11, .max_iterations = 5000});
  StaticEquilibrium found;
  found.v = body_velocities(q, result.s);
  found.motion = std::sqrt(found.v.dot(q.A * found.v) / q.v_free.dot(q.A * q.v_free));
  found.exists = found.motion <= StaticEquilibrium::kRest;
  const Vector u = q.H.transpose() * found.v;
  found.dual_violation = std::max(0.0, -u.minCoeff()) / q.v_free.cwiseAbs().maxCoeff();
  // Without the tolerance the velocity may still prove that there is no equilibrium.
  const bool proves_motion = found.motion > 1e3 * found.dual_violation && found.motion > 1e-6;
  if (!is_success(result.status) && !proves_motion) {
    throw std::runtime_error(fmt::format("static equilibrium: {}", result.message));
  }
  found.s.resize(problem.num_rows());
  for (int k = 0; k < problem.num_contacts(); ++k) {
    const double length = std::hypot(1, problem.mu[k]);
    const double a = result.s[2 * k] / length, b = result.s[2 * k + 1] / length;
    found.s[2 * k] = a + b;
    found.s[2 * k + 1] = problem.mu[k] * (a - b);
  }
  return found;
}

double critical_friction(const std::function<ContactProblem(double)>& with_friction, double low,
                         double high, double accuracy) {
  const auto stands = [&](double mu) { return static_equilibrium(with_friction(mu)).exists; };
  if (!stands(high)) return kNaN;
  if (stands(low)) return low;
  while (high - low > accuracy * high) {
    const double middle = 0.5 * (low + high);
    (stands(middle) ? high : low) = middle;
  }
  return high;
}

}  // namespace bipot
