#include "bench/measure/peer_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

template <int D>
double squared_residual(const ContactProblem& p, const Vector& s, const Vector& u, double w) {
  double sum = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> x = local<D>(s, c);
    const Local<D> moved = x - de_saxce_velocity<D>(local<D>(u, c), p.mu[c]) / w;
    sum += (x - project_coulomb_cone<D>(moved, p.mu[c])).squaredNorm();
  }
  return sum;
}

}  // namespace

double peer_natural_map(const ContactProblem& p, const Vector& s) {
  if (s.size() != p.num_rows()) {
    throw std::invalid_argument(fmt::format("s has size {}, expected {}", s.size(), p.num_rows()));
  }
  if (p.num_contacts() == 0) return 0;
  const DelassusOperator delassus(p);
  const Vector diagonal = delassus.diagonal();
  double w = 0;
  for (int c = 0; c < p.num_contacts(); ++c) w += diagonal[c * p.dim] / p.num_contacts();
  if (!(w > 0)) throw std::invalid_argument("no contact has a mobility");
  Vector u(p.num_rows());
  delassus.velocity(s, u);
  const double sum = dispatch_dim(p.dim, [&](auto d) { return squared_residual<d()>(p, s, u, w); });
  if (sum == 0) return 0;
  return std::sqrt(sum) / std::max({s.norm(), p.u_free.norm() / w, u.norm() / w});
}

}  // namespace bipot
