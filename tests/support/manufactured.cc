#include "tests/support/manufactured.h"

#include "core/base/portable_random.h"
#include "core/base/triplets.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"

namespace bipot {
namespace {

template <int D>
Manufactured make(int bodies, int contacts, unsigned seed, double mu) {
  PortableRandom draw(seed);
  constexpr int K = D == 3 ? 6 : (D == 2 ? 3 : 2);
  const int n = bodies * K, m = contacts * D;
  Manufactured out;
  ContactProblem& p = out.problem;
  p.dim = D;
  Triplets a, h;
  for (int b = 0; b < bodies; ++b) {
    for (int k = 0; k < K; ++k) a.emplace_back(b * K + k, b * K + k, 0.5 + draw.uniform());
  }
  p.A = from_triplets(n, n, a);
  for (int c = 0; c < contacts; ++c) {
    // Every body is touched: first a chain, then random pairs.
    const int i = c % bodies;
    const int j = c < bodies - 1 ? c + 1 : draw.below(bodies);
    for (int r = 0; r < D; ++r) {
      for (int k = 0; k < K; ++k) {
        h.emplace_back(i * K + k, c * D + r, draw.symmetric());
        if (j != i) h.emplace_back(j * K + k, c * D + r, draw.symmetric());
      }
    }
  }
  p.H = from_triplets(n, m, h);
  p.W = assemble_delassus(p.A, p.H, D);
  p.mu = Vector::Constant(contacts, D == 1 ? 0.0 : mu);
  out.s = Vector::Zero(m);
  out.u = Vector::Zero(m);
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
  p.u_free = out.u - Vector(p.W * out.s);
  // Velocities without contact impulses that are consistent with u_free need not exist; v_free is
  // free to choose as u_free carries the rest.
  p.v_free = Vector::Zero(n);
  return out;
}

template <ContactRows K>
Manufactured make_rolling(int bodies, int contacts, unsigned seed) {
  PortableRandom draw(seed);
  constexpr int kDofs = K == 6 ? 6 : 3;
  const int n = bodies * kDofs, m = contacts * K;
  Manufactured out;
  ContactProblem& p = out.problem;
  p.dim = K;
  Triplets a, h;
  for (int k = 0; k < n; ++k) a.emplace_back(k, k, 0.5 + draw.uniform());
  for (int c = 0; c < contacts; ++c) {
    const int i = c % bodies, j = c < bodies - 1 ? c + 1 : draw.below(bodies);
    for (int row = c * K; row < (c + 1) * K; ++row) {
      for (int k = 0; k < kDofs; ++k) {
        h.emplace_back(i * kDofs + k, row, draw.symmetric());
        if (j != i) h.emplace_back(j * kDofs + k, row, draw.symmetric());
      }
    }
  }
  p.A = from_triplets(n, n, a);
  p.H = from_triplets(n, m, h);
  p.W = assemble_delassus(p.A, p.H, K);
  p.mu = Vector::Constant(contacts, 0.3);
  p.mu_r = Vector::Constant(contacts, 0.2);
  if (K == 6) p.mu_spin = Vector::Constant(contacts, 0.1);
  out.s = out.u = Vector::Zero(m);
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
  p.u_free = out.u - Vector(p.W * out.s);
  p.v_free = Vector::Zero(n);
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
