#pragma once

#include "core/problem/coulomb_cone.h"

namespace bipot {

/// Equation f(s, u) = 0 of one contact, equivalent to Coulomb's law, with one element of its
/// generalized Jacobian: df = P ds + Q du. s and u must have comparable sizes (equilibrated
/// variables), as the steps of both residuals are 1.
template <int D>
struct LocalResidual {
  using Block = Eigen::Matrix<double, D, D>;
  Local<D> f = Local<D>::Zero();
  Block P = Block::Zero(), Q = Block::Zero();
};

/// Alart and Curnier (1991), standard form:
///     f_n = s_n - max(0, s_n - u_n),
///     f_t = s_t - proj(s_t - u_t, disk of radius mu max(0, s_n - u_n)),
/// and likewise for rolling and spin. On the edges of its cases the Jacobian is that of sticking, or
/// of take-off.
template <ContactRows D>
LocalResidual<D> alart_curnier(const Local<D>& s, const Local<D>& u, FrictionOf<D> mu);

/// Projection of Alart and Curnier at z, s_n on the half-line and then s_t on the disk of radius
/// mu s_n (rolling and spin likewise), and a generalised Jacobian of it.
template <ContactRows D>
Local<D> split_projection(const Local<D>& z, const FrictionOf<D>& mu,
                          Eigen::Matrix<double, D.count, D.count>& jacobian);

/// Fischer-Burmeister function of the Jordan product (Fukushima, Luo, Tseng 2002):
///     f = x + y - (x∘x + y∘y)^{1/2},   x = (s_n, s_t / mu),   y = (u_n + mu |u_t|, mu u_t),
/// both in the self-dual cone |z_t| <= z_n, x·y = s·û. [ours] The tangential rows are multiplied by
/// min(mu, 1), so that they keep size one as mu -> 0. mu = 0 is s_t = 0 and the scalar function.
///
/// The smaller spectral value of x∘x + y∘y is formed as a sum of squares: the difference in the
/// textbook formula would lose half of the digits. Where it vanishes (x + y on the edge of the
/// cone), the Jacobian replaces its root by 1e-10 of the larger one.
template <int D>
LocalResidual<D> fischer_burmeister(const Local<D>& s, const Local<D>& u, double mu);

}  // namespace bipot
