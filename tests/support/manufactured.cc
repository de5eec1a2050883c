#include "tests/support/manufactured.h"

#include "core/base/portable_random.h"
#include "core/base/triplets.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"

namespace bipot {
namespace {

/// A problem of bodies that any numbers couple, `dofs` of each; without what belongs to the law.
ContactProblem coupled_bodies(int rows, int dofs, int bodies, int contacts, PortableRandom& draw) {
  const int n = bodies * dofs, m = contacts * rows;
  ContactProblem p{.dim = rows};
  Triplets a, h;
  for (int k = 0; k < n; ++k) a.emplace_back(k, k, 0.5 + draw.uniform());
  for (int c = 0; c < contacts; ++c) {
    // Every body is touched: first a chain, then random pairs.
    const int i = c % bodies, j = c < bodies - 1 ? c + 1 : draw.below(bodies);
    for (int row = c * rows; row < (c + 1) * rows; ++row) {
      for (int k = 0; k < dofs; ++k) {
        h.emplace_back(i * dofs + k, row, draw.symmetric());
        if (j != i) h.emplace_back(j * dofs + k, row, draw.symmetric());
      }
    }
  }
  p.A = from_triplets(n, n, a);
  p.H = from_triplets(n, m, h);
  p.W = assemble_delassus(p.A, p.H, rows);
  return p;
}

/// The free velocities with which s and u are the solution.
void close_problem(Manufactured& out) {
  ContactProblem& p = out.problem;
  p.u_free = out.u - Vector(p.W * out.s);
  // Velocities without contact impulses that are consistent with u_free need not exist; v_free is
  // free to choose as u_free carries the rest.
  p.v_free = Vector::Zero(p.A.rows());
}

template <int D>
Manufactured make(int bodies, int contacts, unsigned seed, double mu) {
  PortableRandom draw(seed);
  constexpr int K = D == 3 ? 6 : (D == 2 ? 3 : 2);
  Manufactured out{.problem = coupled_bodies(D, K, bodies, contacts, draw)};
  ContactProblem& p = out.problem;
  p.mu = Vector::Constant(contacts, D == 1 ? 0.0 : mu);
  out.s = out.u = Vector::Zero(contacts * D);
  for (int c = 0; c < contacts; ++c) {
    const int status = draw.below(3);
    Local<D> s = Local<D>::Zero(), u = Local<D>::Zero(), direction = Local<D>::Zero();
    if constexpr (D > 1) {
      for (int k = 1; k < D; ++k) direction[k] = draw.symmetric();
      direction /= direction.norm();
    }
    const double normal = 0.2 + draw.uniform();
    if (status == 0) {  // take-off
      for (int k = 0; k < D; ++k) u[k] = draw.symmetric();
      u[0] = normal;
    } else if (status == 1) {  // stick, well inside the cone
      s = 0.7 * draw.uniform() * mu * normal * direction;
      s[0] = normal;
    } else {  // slip: the impulse opposes the velocity
      s = -mu * normal * direction;
      s[0] = normal;
      if constexpr (D > 1) u = (0.1 + draw.uniform()) * direction;
    }
    out.s.segment<D>(c * D) = s;
    out.u.segment<D>(c * D) = u;
  }
  close_problem(out);
  return out;
}

template <ContactRows K>
Manufactured make_rolling(int bodies, int contacts, unsigned seed) {
  PortableRandom draw(seed);
  Manufactured out{.problem = coupled_bodies(K, K == 6 ? 6 : 3, bodies, contacts, draw)};
  ContactProblem& p = out.problem;
  p.mu = Vector::Constant(contacts, 0.3);
  p.mu_r = Vector::Constant(contacts, 0.2);
  if (K == 6) p.mu_spin = Vector::Constant(contacts, 0.1);
  out.s = out.u = Vector::Zero(contacts * K);
  for (int c = 0; c < contacts; ++c) {
    Local<K> s = Local<K>::Zero(), u = Local<K>::Zero();
    const bool opens = draw.below(4) == 0;
    (opens ? u : s)[0] = 0.2 + draw.uniform();
    each_bounded<K>(friction_of<K>(p, c), [&](auto first, auto count, double bound) {
      Eigen::Matrix<double, count(), 1> direction;
      for (double& x : direction) x = draw.symmetric();
      direction /= direction.norm();
      const bool moves = draw.below(2) == 0;
      const double speed = 0.1 + draw.uniform(), part = moves ? -1 : 0.7 * draw.uniform();
      if (opens || moves) u.template segment<count()>(first()) = speed * direction;
      s.template segment<count()>(first()) = part * bound * s[0] * direction;
    });
    out.s.segment<K>(c * K) = s;
    out.u.segment<K>(c * K) = u;
  }
  close_problem(out);
  return out;
}

}  // namespace

Manufactured manufactured_rolling(int rows, int bodies, int contacts, unsigned seed) {
  if (rows == 6) return make_rolling<ContactRows(6, true)>(bodies, contacts, seed);
  return make_rolling<ContactRows(3, true)>(bodies, contacts, seed);
}

Manufactured manufactured_problem(int dim, int bodies, int contacts, unsigned seed, double mu) {
  return dispatch_dim(dim, [&](auto d) { return make<d()>(bodies, contacts, seed, mu); });
}

ManufacturedJoints manufactured_joints(int dim, int bodies, int contacts, unsigned seed,
                                       double mu) {
  Manufactured m = manufactured_problem(dim, bodies, contacts, seed, mu);
  ContactProblem& p = m.problem;
  PortableRandom draw(seed + 1000);
  const int n = p.num_dofs(), rows = n / bodies;
  const auto drawn = [&](int size) {
    Vector x(size);
    for (double& value : x) value = draw.symmetric();
    return x;
  };
  SparseRows G(rows, n);
  for (int row = 0; row < rows; ++row) {
    for (int dof = 0; dof < 3 * rows; ++dof) G.insert(row, dof) = draw.symmetric();
  }
  G.makeCompressed();
  ManufacturedJoints out{.s = m.s, .u = m.u, .v = drawn(n), .multipliers = drawn(rows)};
  const Vector impulse = p.H * out.s + G.transpose() * out.multipliers;
  p.v_free = out.v - impulse.cwiseQuotient(p.A.diagonal());
  p.u_free = out.u + p.H.transpose() * (p.v_free - out.v);
  out.problem = with_equality_rows(p, G, G * out.v);
  return out;
}

}  // namespace bipot
