#include "core/problem/energy_norm.h"

#include <algorithm>

namespace bipot {

double energy_product(const ContactProblem& p, const DelassusOperator& delassus, const Vector& s) {
  if (p.has_velocities() && is_diagonal(p.A)) {
    const Vector x = p.H * s;
    return x.cwiseAbs2().cwiseQuotient(Vector(p.A.diagonal())).sum();
  }
  Vector u(p.num_rows());
  delassus.apply(s, u);
  return std::max(0.0, s.dot(u));  // rounded data of other codes: W may be slightly indefinite
}

double relative_error(double error, double reference) {
  if (error == 0) return 0;
  return reference > 0 ? error / reference : kNaN;
}

}  // namespace bipot
