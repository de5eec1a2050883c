#include "solvers/interior/proximal_newton.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/kernels/contact_residual.h"

namespace bipot {
namespace {

constexpr int kInnerCap = 8;
constexpr int kQuick = 6;  // inner iterations after which delta may fall
constexpr double kInnerAccuracy = 1e-8, kStagnation = 1e-4;
constexpr double kSmallestDelta = 1e-6, kDeltaToGiveUp = 1e2;

}  // namespace

template <ContactRows D>
StageEnd proximal_newton(const ContactProblem& p, const DelassusOperator& delassus,
                         ShiftedDelassus& shifted, const Vector& mobility, const Vector& start,
                         InteriorRun& run, int max_iterations) {
  const int contacts = p.num_contacts();
  std::vector<double> R(static_cast<std::size_t>(contacts) * D * D);
  Vector anchor = start, s = start, u, g(contacts * D), ds;
  double delta = 0.1;  // proximal term, in units of W_cc
  double first_residual = 0, last_residual = 0;
  int inner = 0;
  for (int k = 0; k < max_iterations; ++k) {
    delassus.velocity(s, u);
    double residual = 0, scale = 0;  // energies
    for (int c = 0; c < contacts; ++c) {
      Local<D> rho;
      for (int i = 0; i < D; ++i) rho[i] = 1 / (delta * mobility[c * D + i]);
      const Local<D> z = local<D>(anchor, c) - rho.cwiseProduct(local<D>(u, c));
      Eigen::Matrix<double, D.count, D.count> jacobian;
      const Local<D> f = split_projection<D>(z, friction_of<D>(p, c), jacobian) - local<D>(s, c);
      g.segment<D>(c * D) = f;
      for (int i = 0; i < D; ++i) {
        residual += mobility[c * D + i] * f[i] * f[i];
        scale += mobility[c * D + i] * z[i] * z[i];
      }
      Eigen::Map<Eigen::Matrix<double, D, D, Eigen::RowMajor>> block(
          &R[static_cast<std::size_t>(c) * D * D]);
      block = jacobian * rho.asDiagonal();
    }
    if (!std::isfinite(residual)) return StageEnd::kFailed;
    if (inner == 0) first_residual = residual;
    // The residual cannot fall below the rounding of u times the step 1/delta.
    const double rounding = 1e3 * std::numeric_limits<double>::epsilon() / delta;
    const double accuracy =
        std::max(kInnerAccuracy * kInnerAccuracy * first_residual, rounding * rounding * scale);
    // Ill-conditioned contacts stop earlier: small, and no longer decreasing.
    const bool stagnates = inner > 1 && residual > 0.25 * last_residual &&
                           residual <= kStagnation * kStagnation * first_residual;
    last_residual = residual;
    const bool converged = (inner > 0 && residual <= accuracy) || stagnates;
    if (converged || inner >= kInnerCap) {
      if (converged) {
        anchor = s;
        if (inner <= kQuick) delta = std::max(0.1 * delta, kSmallestDelta);
      } else {
        s = anchor;
        delta *= 10;
        if (delta > kDeltaToGiveUp) return StageEnd::kStuck;
      }
      inner = 0;
      --k;  // no factorisation
      continue;
    }
    // The anchor itself solves its proximal problem: no progress is possible.
    if (inner == 0 && residual <= rounding * rounding * scale) return StageEnd::kStuck;
    if (!shifted.factor(R)) return StageEnd::kFailed;
    shifted.solve(g, ds);
    s += ds;
    ++inner;
    if (run.next(s, delta)) return StageEnd::kStop;
  }
  return StageEnd::kLimit;
}

template StageEnd proximal_newton<1>(const ContactProblem&, const DelassusOperator&,
                                     ShiftedDelassus&, const Vector&, const Vector&, InteriorRun&,
                                     int);
template StageEnd proximal_newton<2>(const ContactProblem&, const DelassusOperator&,
                                     ShiftedDelassus&, const Vector&, const Vector&, InteriorRun&,
                                     int);
template StageEnd proximal_newton<3>(const ContactProblem&, const DelassusOperator&,
                                     ShiftedDelassus&, const Vector&, const Vector&, InteriorRun&,
                                     int);
template StageEnd proximal_newton<ContactRows(3, true)>(const ContactProblem&,
                                                        const DelassusOperator&, ShiftedDelassus&,
                                                        const Vector&, const Vector&, InteriorRun&,
                                                        int);
template StageEnd proximal_newton<ContactRows(6, true)>(const ContactProblem&,
                                                        const DelassusOperator&, ShiftedDelassus&,
                                                        const Vector&, const Vector&, InteriorRun&,
                                                        int);

}  // namespace bipot
