#include "tests/support/naive_error.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

namespace bipot {
namespace {

using Real = NaiveMatrix::Scalar;
using RealVector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;
using RealSparse = Eigen::SparseMatrix<Real>;

Real tangential_length(const RealVector& x) {
  Real sum = 0;
  for (Eigen::Index k = 1; k < x.size(); ++k) sum += x[k] * x[k];
  return std::sqrt(sum);
}

/// The nearest point of a cone: the point itself, or the foot on the generator nearest to it, or
/// the apex.
RealVector nearest_in_cone(const RealVector& x, Real mu) {
  const Real length = tangential_length(x);
  if (x[0] >= 0 && length <= mu * x[0]) return x;
  RealVector generator = RealVector::Zero(x.size());
  generator[0] = 1;
  for (Eigen::Index k = 1; k < x.size() && length > 0; ++k) generator[k] = mu * x[k] / length;
  generator /= generator.norm();
  const Real foot = generator.dot(x);
  return foot > 0 ? RealVector(foot * generator) : RealVector::Zero(x.size());
}

Real quotient(Real numerator, Real denominator) {
  if (numerator == 0) return 0;
  return denominator > 0 ? numerator / denominator : std::numeric_limits<Real>::infinity();
}

}  // namespace

NaiveMatrix naive_delassus(const ContactProblem& p) {
  if (p.H.cols() == 0) return Eigen::MatrixXd(p.W).cast<Real>();
  const RealSparse H = p.H.cast<Real>();
  const Eigen::SimplicialLDLT<RealSparse> factor(p.A.cast<Real>());
  const RealSparse velocity = factor.solve(H);
  return NaiveMatrix(RealSparse(H.transpose()) * velocity);
}

NaiveError naive_error(const ContactProblem& p, const Eigen::VectorXd& s_given) {
  return naive_error(p, naive_delassus(p), s_given);
}

NaiveError naive_error(const ContactProblem& p, const NaiveMatrix& delassus,
                       const Eigen::VectorXd& s_given) {
  const int contacts = static_cast<int>(p.mu.size());
  const int d = p.dim;
  RealVector r = RealVector::Ones(contacts * d);
  if (p.row_scale.size() > 0) r = p.row_scale.cast<Real>();
  // Back to the physical world: impulses s / r, mechanical operator diag(r) W diag(r), and mean
  // velocities u = D (W s) + b with D = 1 / r².
  const NaiveMatrix W = r.asDiagonal() * delassus * r.asDiagonal();
  const RealVector b = p.u_free.cast<Real>().cwiseQuotient(r);
  RealVector s = s_given.cast<Real>().cwiseQuotient(r), mu(contacts);
  for (int c = 0; c < contacts; ++c) {
    mu[c] = d == 1 ? Real(0) : p.mu[c] * r[c * d] / r[c * d + 1];
    s.segment(c * d, d) = nearest_in_cone(s.segment(c * d, d), mu[c]);
  }
  const RealVector Ws = W * s;
  const RealVector velocity = Ws.cwiseQuotient(r.cwiseProduct(r)) + b;

  Real D = 0, G = 0, G_clipped = 0, V = 0, E_free = 0, N2 = 0, natmap2 = 0, b2 = 0;
  for (int c = 0; c < contacts; ++c) {
    const RealVector x = s.segment(c * d, d), u = velocity.segment(c * d, d);
    const Real slip = tangential_length(u);
    const Real rho = 1 / W(c * d, c * d);
    Real tangential_power = 0;
    for (int k = 1; k < d; ++k) tangential_power += x[k] * u[k];
    D += mu[c] * x[0] * slip;
    G += mu[c] * x[0] * slip + tangential_power + x[0] * std::abs(u[0]);
    G_clipped += mu[c] * x[0] * slip + tangential_power + x[0] * (u[0] > 0 ? u[0] : 0);
    if (u[0] < 0) V += rho * u[0] * u[0] / 2;
    if (b[c * d] < 0) E_free += rho * b[c * d] * b[c * d] / 2;
    RealVector hat = u;
    hat[0] += mu[c] * slip;
    N2 += (x - nearest_in_cone(x - rho * hat, mu[c])).squaredNorm() / (2 * rho);
    Real trace = 0;
    for (int k = 0; k < d; ++k) trace += W(c * d + k, c * d + k);
    natmap2 += (x - nearest_in_cone(x - d / trace * hat, mu[c])).squaredNorm();
    b2 += (d / trace * b.segment(c * d, d)).squaredNorm();
  }
  const Real E = std::max(s.dot(Ws) / 2, E_free);
  const Real denominator = std::max(D, E / 10);
  const auto rounded = [](Real x) { return static_cast<double>(x); };
  return {.epsilon = rounded(quotient(G + V, denominator)),
          .eta = rounded(std::sqrt(quotient(N2, denominator))),
          .raw42 = D > 0 ? rounded(G_clipped / D) : std::numeric_limits<double>::quiet_NaN(),
          .natmap_scaled = rounded(quotient(std::sqrt(natmap2), std::max(s.norm(), std::sqrt(b2)))),
          .u = velocity.cast<double>()};
}

}  // namespace bipot
