#include "bench/measure/true_error.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bench/measure/energy_norm.h"
#include "core/problem/delassus.h"
#include "core/problem/sparse_factor.h"

namespace bipot {
namespace {

// A rank test by dense QR stays below a second up to here.
constexpr int kMaxRankRows = 600;

double largest_impulse(int dim, const Vector& s) {
  double largest = 0;
  for (Eigen::Index row = 0; row < s.size(); row += dim) {
    largest = std::max(largest, s.segment(row, dim).norm());
  }
  return largest;
}

/// True when each normal pushes one body or two with unit forces, the bodies laid out as `rows`
/// says.
bool has_unit_normals(const ContactProblem& p, const BodyRows& rows) {
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    int body = -1;
    double squared = 0;
    const auto is_unit = [&] { return body < 0 || std::abs(std::sqrt(squared) - 1) < 1e-6; };
    for (SparseMatrix::InnerIterator it(p.H, c * p.dim); it; ++it) {
      const int row = static_cast<int>(it.row());
      if (row >= rows.bodies * rows.per_body) break;
      if (row / rows.per_body != body) {
        if (!is_unit()) return false;
        body = row / rows.per_body;
        squared = 0;
      }
      if (row % rows.per_body < rows.translations) squared += std::pow(scale * it.value(), 2);
    }
    if (body < 0 || !is_unit()) return false;
  }
  return true;
}

/// True when W is regular by a rank-revealing QR; false for large problems, where it is not asked.
bool has_unique_forces(const ContactProblem& p) {
  const int rows = p.num_rows();
  if (rows == 0 || rows > kMaxRankRows) return false;
  if (p.has_velocities() && rows > p.num_dofs()) return false;
  const Eigen::MatrixXd W =
      p.has_delassus() ? Eigen::MatrixXd(p.W) : Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim));
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(W);
  qr.setThreshold(1e-10);
  return qr.rank() == rows;
}

}  // namespace

std::optional<BodyRows> find_body_rows(const ContactProblem& p) {
  if (!p.has_velocities()) return std::nullopt;
  BodyRows rows;
  rows.per_body = p.dim == 1 ? 2 : p.dim == 2 ? 3 : 6;
  rows.translations = p.dim == 1 ? 2 : p.dim;
  // A few walls' rows could stand where another body's would: their number is searched.
  constexpr int kMaxWalls = 24;
  for (rows.walls = p.num_dofs() % rows.per_body; rows.walls <= std::min(kMaxWalls, p.num_dofs());
       rows.walls += rows.per_body) {
    rows.bodies = (p.num_dofs() - rows.walls) / rows.per_body;
    if (has_unit_normals(p, rows)) return rows;
  }
  return std::nullopt;
}

double TrueErrorEvaluator::largest_resultant(const Vector& s) const {
  const Vector x = given_.problem.H * s;
  const BodyRows& rows = *body_rows_;
  double largest = 0;
  for (int b = 0; b < rows.bodies; ++b) {
    largest = std::max(largest, x.segment(b * rows.per_body, rows.translations).norm());
  }
  if (rows.walls > 0) largest = std::max(largest, x.tail(rows.walls).cwiseAbs().maxCoeff());
  return largest;
}

TrueErrorEvaluator::TrueErrorEvaluator(const TestProblem& problem,
                                       const ReferenceSolution& reference)
    : given_(problem), reference_(reference), evaluate_(problem.problem) {
  const ContactProblem& p = problem.problem;
  reference_norm_ = std::sqrt(energy_product(p, evaluate_.delassus(), reference.s));
  reference_impulse_ = largest_impulse(p.dim, reference.s);
  body_rows_ = find_body_rows(p);
  if (body_rows_) reference_force_ = largest_resultant(reference.s);
  reference_dissipated_ = dissipated(reference.s);
  unique_ = has_unique_forces(p);
}

/// Kinetic energy that the impulses take out of the free motion, -s·(½ W s + b). With bodies given,
/// b = Hᵀ v_free, so that neither restitution nor moving walls enter; else b = u_free.
double TrueErrorEvaluator::dissipated(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  const double linear = p.has_velocities() ? Vector(p.H * s).dot(p.v_free) : s.dot(p.u_free);
  return -(0.5 * energy_product(p, evaluate_.delassus(), s) + linear);
}

TrueError TrueErrorEvaluator::operator()(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  TrueError error;
  if (s.size() != p.num_rows()) return error;
  const Vector difference = s - reference_.s;
  error.velocity = relative_error(std::sqrt(energy_product(p, evaluate_.delassus(), difference)),
                                  reference_norm_);
  if (body_rows_) error.force = relative_error(largest_resultant(difference), reference_force_);
  if (unique_)
    error.contact_force = relative_error(largest_impulse(p.dim, difference), reference_impulse_);
  evaluate_(s);
  error.penetration_velocity = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    error.penetration_velocity =
        std::max(error.penetration_velocity, -evaluate_.velocity()[c * p.dim] / scale);
  }
  error.penetration = error.penetration_velocity * given_.step / given_.smallest_radius;
  error.dissipated = dissipated(s);
  error.energy = relative_error(std::abs(error.dissipated - reference_dissipated_),
                                std::abs(reference_dissipated_));
  return error;
}

}  // namespace bipot
