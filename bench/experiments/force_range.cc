#include "bench/experiments/force_range.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/stopwatch.h"
#include "core/base/triplets.h"
#include "solvers/analysis/linear_programme.h"

namespace bipot {

std::vector<ForceRange> admissible_forces(const ContactProblem& problem) {
  if (problem.dim != 2 || !problem.has_velocities() || problem.row_scale.size() > 0) {
    throw std::invalid_argument("admissible forces: asks for d = 2, H, and no restitution");
  }
  const int contacts = problem.num_contacts();
  const Vector load = problem.A * problem.v_free;
  const double unit = load.cwiseAbs().maxCoeff();
  if (contacts == 0 || !(unit > 0)) return {};

  // Unknowns: two edges (1, ±mu) for each contact in units of the largest load, and the load's
  // share x0 <= 1. The problem is homogeneous in them, so that an optimum has x0 = 1 if it has any.
  LinearProgramme programme;
  Triplets entries;
  const auto dof_scale = [&](Eigen::Index dof) { return 1 / std::sqrt(problem.A.coeff(dof, dof)); };
  for (int k = 0; k < contacts; ++k) {
    for (const int row : {2 * k, 2 * k + 1}) {
      for (SparseMatrix::InnerIterator it(problem.H, row); it; ++it) {
        for (const int sign : {1, -1}) {
          const double share = row == 2 * k ? 1 : sign * problem.mu[k];
          entries.emplace_back(static_cast<int>(it.row()), 2 * k + (sign > 0 ? 0 : 1),
                               share * it.value() * dof_scale(it.row()));
        }
      }
    }
  }
  for (int dof = 0; dof < load.size(); ++dof) {
    if (load[dof] != 0) entries.emplace_back(dof, 2 * contacts, load[dof] / unit * dof_scale(dof));
  }
  programme.A = from_triplets(load.size(), 2 * contacts + 1, entries);
  programme.upper = Vector::Constant(2 * contacts + 1, kInfinity);
  programme.upper[2 * contacts] = 1;

  const auto optimum = [&](int contact, double weight, double reward) {
    programme.cost = Vector::Zero(2 * contacts + 1);
    programme.cost[2 * contacts] = -reward;
    if (contact >= 0) programme.cost.segment(2 * contact, 2).setConstant(weight);
    const Stopwatch watch;
    return solve(programme, [&] { return watch.seconds() > 60; });
  };
  const LinearProgramme::Optimum any = optimum(-1, 0, 1);
  if (!any.found) throw std::runtime_error("admissible forces: " + any.message);
  if (any.x[2 * contacts] < 1 - 1e-6) return {};

  std::vector<ForceRange> ranges;
  for (int k = 0; k < contacts; ++k) {
    const auto force = [&](const LinearProgramme::Optimum& o) {
      return unit * (o.x[2 * k] + o.x[2 * k + 1]);
    };
    ForceRange range;
    const double known = any.x[2 * k] + any.x[2 * k + 1];
    // Any admissible force bounds the least one, so that this reward makes x0 = 1.
    const LinearProgramme::Optimum least = optimum(k, 1, 2 * known + 1);
    if (!least.found) throw std::runtime_error("admissible forces: " + least.message);
    range.low = force(least);
    const LinearProgramme::Optimum most = optimum(k, -1, 1);
    range.high = most.found ? force(most) : kInfinity;
    ranges.push_back(range);
  }
  return ranges;
}

double force_spread(const std::vector<ForceRange>& ranges) {
  double widths = 0, middles = 0;
  for (const ForceRange& r : ranges) {
    widths += r.high - r.low;
    middles += 0.5 * (r.high + r.low);
  }
  return std::isinf(widths) ? kInfinity : widths / middles;
}

}  // namespace bipot
