#include "bench/measure/true_error.h"

#include "core/linear/dense_factor.h"
#include "core/problem/energy_norm.h"

namespace bipot {
namespace {

// Largest size for a rank test by dense QR.
constexpr int kMaxRankRows = 600;

double largest_impulse(int dim, const Vector& s) {
  double largest = 0;
  for (Eigen::Index row = 0; row < s.size(); row += dim) {
    largest = std::max(largest, s.segment(row, dim).norm());
  }
  return largest;
}

/// True if W is regular by a rank-revealing QR; false without a test for large problems.
bool has_unique_forces(const ContactProblem& p) {
  const int rows = p.num_rows();
  if (rows == 0 || rows > kMaxRankRows) return false;
  if (p.has_velocities() && rows > p.num_dofs()) return false;
  const Eigen::MatrixXd W =
      p.has_delassus() ? Eigen::MatrixXd(p.W) : Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim));
  return numerical_rank(W, 1e-10) == rows;
}

}  // namespace

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

/// Kinetic energy that the impulses take from the free motion, -s·(½ W s + b). With bodies given, b
/// = Hᵀ v_free, so that neither restitution nor moving walls enter; else b = u_free.
double TrueErrorEvaluator::dissipated(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  const double linear = p.has_velocities() ? Vector(p.H * s).dot(p.v_free) : s.dot(p.u_free);
  return -(0.5 * energy_product(p, evaluate_.delassus(), s) + linear);
}

double TrueErrorEvaluator::distance(const Vector& a, const Vector& b) const {
  return std::sqrt(energy_product(given_.problem, evaluate_.delassus(), a - b));
}

TrueError TrueErrorEvaluator::difference(const Vector& s, const Vector& exact) const {
  TrueError error;
  const Vector difference = s - exact;
  error.velocity = relative_error(distance(s, exact), reference_norm_);
  if (body_rows_) error.force = relative_error(largest_resultant(difference), reference_force_);
  if (unique_) {
    error.contact_force =
        relative_error(largest_impulse(given_.problem.dim, difference), reference_impulse_);
  }
  error.dissipated = dissipated(s);
  error.energy = relative_error(std::abs(error.dissipated - dissipated(exact)),
                                std::abs(reference_dissipated_));
  return error;
}

TrueError TrueErrorEvaluator::operator()(const Vector& s) const {
  const ContactProblem& p = given_.problem;
  if (s.size() != p.num_rows()) return {};
  const Vector* exact = &reference_.s;
  int nearest = 0;
  double closest = reference_.several() ? distance(s, *exact) : 0;
  for (std::size_t k = 0; k < reference_.others.size(); ++k) {
    const double apart = distance(s, reference_.others[k]);
    if (!(apart < closest)) continue;
    closest = apart;
    exact = &reference_.others[k];
    nearest = static_cast<int>(k) + 1;
  }
  TrueError error = difference(s, *exact);
  error.nearest = nearest;
  evaluate_(s);
  error.penetration_velocity = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double scale = p.row_scale.size() != 0 ? p.row_scale[c * p.dim] : 1.0;
    error.penetration_velocity =
        std::max(error.penetration_velocity, -evaluate_.velocity()[c * p.dim] / scale);
  }
  error.penetration = error.penetration_velocity * given_.step / given_.smallest_radius;
  return error;
}

ReferenceSolution::Spread TrueErrorEvaluator::spread() const {
  ReferenceSolution::Spread spread;
  std::vector<const Vector*> all{&reference_.s};
  for (const Vector& other : reference_.others) all.push_back(&other);
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const TrueError d = difference(*all[i], *all[j]);
      spread.velocity = std::fmax(spread.velocity, d.velocity);
      spread.force = std::fmax(spread.force, d.force);
      spread.energy = std::fmax(spread.energy, d.energy);
    }
  }
  return spread;
}

}  // namespace bipot
