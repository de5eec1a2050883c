#include "tests/support/naive_error.h"

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>

namespace bipot {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double tangential_length(const VectorXd& x) {
  double sum = 0;
  for (Eigen::Index k = 1; k < x.size(); ++k) sum += x[k] * x[k];
  return std::sqrt(sum);
}

/// The nearest point of a cone: the point itself, or the foot on the generator nearest to it, or
/// the apex.
VectorXd nearest_in_cone(const VectorXd& x, double mu) {
  const double length = tangential_length(x);
  if (x[0] >= 0 && length <= mu * x[0]) return x;
  VectorXd generator = VectorXd::Zero(x.size());
  generator[0] = 1;
  for (Eigen::Index k = 1; k < x.size() && length > 0; ++k) generator[k] = mu * x[k] / length;
  generator /= generator.norm();
  const double foot = generator.dot(x);
  return foot > 0 ? VectorXd(foot * generator) : VectorXd::Zero(x.size());
}

double quotient(double numerator, double denominator) {
  if (numerator == 0) return 0;
  return denominator > 0 ? numerator / denominator : std::numeric_limits<double>::infinity();
}

}  // namespace

MatrixXd naive_delassus(const ContactProblem& p) {
  if (p.H.cols() == 0) return MatrixXd(p.W);
  const Eigen::SimplicialLDLT<SparseMatrix> factor(p.A);
  const SparseMatrix velocity = factor.solve(p.H);
  return MatrixXd(SparseMatrix(p.H.transpose()) * velocity);
}

NaiveError naive_error(const ContactProblem& p, const VectorXd& s_given) {
  return naive_error(p, naive_delassus(p), s_given);
}

NaiveError naive_error(const ContactProblem& p, const MatrixXd& delassus, const VectorXd& s_given) {
  const int contacts = static_cast<int>(p.mu.size());
  const int d = p.dim;
  const VectorXd r =
      p.row_scale.size() == 0 ? VectorXd(VectorXd::Ones(contacts * d)) : VectorXd(p.row_scale);
  // Back to the physical world: impulses s / r, mechanical operator diag(r) W diag(r), and mean
  // velocities u = D (W s) + b with D = 1 / r².
  const MatrixXd W = r.asDiagonal() * delassus * r.asDiagonal();
  VectorXd b = p.u_free.cwiseQuotient(r);
  VectorXd s = s_given.cwiseQuotient(r), mu(contacts);
  for (int c = 0; c < contacts; ++c) {
    mu[c] = d == 1 ? 0.0 : p.mu[c] * r[c * d] / r[c * d + 1];
    s.segment(c * d, d) = nearest_in_cone(s.segment(c * d, d), mu[c]);
  }
  const VectorXd Ws = W * s;
  NaiveError e{.u = Ws.cwiseQuotient(r.cwiseProduct(r)) + b};

  double D = 0, G = 0, G_clipped = 0, V = 0, E_free = 0, N2 = 0, natmap2 = 0, b2 = 0;
  for (int c = 0; c < contacts; ++c) {
    const VectorXd x = s.segment(c * d, d), u = e.u.segment(c * d, d);
    const double slip = tangential_length(u);
    const double rho = 1 / W(c * d, c * d);
    double tangential_power = 0;
    for (int k = 1; k < d; ++k) tangential_power += x[k] * u[k];
    D += mu[c] * x[0] * slip;
    G += mu[c] * x[0] * slip + tangential_power + x[0] * std::abs(u[0]);
    G_clipped += mu[c] * x[0] * slip + tangential_power + x[0] * (u[0] > 0 ? u[0] : 0);
    if (u[0] < 0) V += rho * u[0] * u[0] / 2;
    if (b[c * d] < 0) E_free += rho * b[c * d] * b[c * d] / 2;
    VectorXd hat = u;
    hat[0] += mu[c] * slip;
    N2 += (x - nearest_in_cone(x - rho * hat, mu[c])).squaredNorm() / (2 * rho);
    double trace = 0;
    for (int k = 0; k < d; ++k) trace += W(c * d + k, c * d + k);
    natmap2 += (x - nearest_in_cone(x - d / trace * hat, mu[c])).squaredNorm();
    b2 += (d / trace * b.segment(c * d, d)).squaredNorm();
  }
  const double E = std::max(s.dot(Ws) / 2, E_free);
  const double denominator = std::max(D, 0.1 * E);
  e.epsilon = quotient(G + V, denominator);
  e.eta = std::sqrt(quotient(N2, denominator));
  e.raw42 = D > 0 ? G_clipped / D : std::numeric_limits<double>::quiet_NaN();
  e.natmap_scaled = quotient(std::sqrt(natmap2), std::max(s.norm(), std::sqrt(b2)));
  return e;
}

}  // namespace bipot
