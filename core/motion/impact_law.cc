#include "core/motion/impact_law.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/motion/closing_pairs.h"
#include "core/problem/delassus.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

using Impact = ContactLaw::Impact;

/// Velocities before the step in the problem's degrees of freedom.
template <int D>
Vector velocities_before(const State<D>& start, const Midpoint<D>& mid, const DofMap& dofs) {
  Vector v = Vector::Zero(dofs.size);
  for (std::size_t i = 0; i < start.bodies.size(); ++i) {
    const int k = dofs.disk[i];
    if (k < 0) continue;
    const Body<D>& body = start.bodies[i];
    if (body.cluster >= 0) {
      const Cluster<D>& cluster = mid.clusters.bodies[to_size(body.cluster)];
      v.segment<D>(k) = cluster.v;
      v.segment<kSpins<D>>(k + D) << own_spin(cluster);
      continue;
    }
    v.segment<D>(k) = body.v;
    if (dofs.per_disk > D) v.segment<kSpins<D>>(k + D) << body.spin;
  }
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    if (dofs.wall[w] >= 0) v[dofs.wall[w]] = driven_speed(mid.walls[w]);
  }
  for (int k = 0; k < 3; ++k) {
    if (dofs.side[k] >= 0) v[dofs.side[k]] = mid.cell.side(k).speed;
  }
  return v;
}

/// The entry of W of this row.
double diagonal_entry(const ContactProblem& p, int row) {
  double w = 0;
  for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
    w += it.value() * it.value() / p.A.coeff(it.row(), it.row());
  }
  return w;
}

// Closing speeds below this share of the speeds that they are differences of are rounding.
constexpr double kClosingRounding = 1e-12;

/// Takes closing speeds that are rounding of the velocities `v` out of the data. Between bodies that
/// go on together nothing else may be left, and no solver can meet a tolerance on it.
void drop_rounding(const Vector& v, ContactProblem& p) {
  for (int row = 0; row < p.num_rows(); row += p.dim) {
    double speed = 0;
    for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
      speed += std::abs(it.value() * v[it.row()]);
    }
    if (std::abs(p.u_free[row]) <= kClosingRounding * speed) p.u_free[row] = 0;
  }
}

/// The problem after impulses s as well.
void act(const Vector& s, ContactProblem& p) {
  if (p.num_rows() == 0) return;
  const Vector v = (p.H * s).cwiseQuotient(p.A.diagonal());
  p.v_free += v;
  p.u_free += p.H.transpose() * v;
}

/// Contacts whose returned impulse has friction.
std::vector<int> rubbing(const ContactProblem& step, const Vector& returned) {
  std::vector<int> contacts;
  for (int c = 0; c < step.num_contacts() && step.dim > 1; ++c) {
    if (returned[c] > 0 && step.mu[c] > 0) contacts.push_back(c);
  }
  return contacts;
}

/// The impulses of compression, and what is returned of them.
Vector given_impulses(const ContactProblem& step, const Vector& compression,
                      const Vector& returned) {
  Vector s = compression;
  for (int c = 0; c < step.num_contacts(); ++c) s[c * step.dim] += returned[c];
  return s;
}

void copy_column(const SparseMatrix& from, int column, int to, SparseMatrix& H) {
  H.startVec(to);
  for (SparseMatrix::InnerIterator it(from, column); it; ++it) {
    H.insertBack(it.row(), to) = it.value();
  }
}

Vector joined(const Vector& a, const Vector& b) {
  Vector both(a.size() + b.size());
  both << a, b;
  return both;
}

}  // namespace

template <int D>
Scene<D> with_step_laws(const Scene<D>& scene) {
  Scene<D> given = scene;
  const double e = scene.impact == Impact::kFremond ? 1 : 0;
  for (ContactLaw& law : given.laws) law.e_n = law.e_t = e;
  return given;
}

template <int D>
void add_mean_restitution(const Scene<D>& scene, const State<D>& start, const Midpoint<D>& mid,
                          AssembledStep& step) {
  ContactProblem& p = step.problem;
  step.shift = Vector::Zero(p.num_rows());
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact<D>& contact = mid.contacts[c];
    const Eigen::Index row = static_cast<Eigen::Index>(c) * p.dim;
    const double e_n = pair_law(scene, start.bodies, mid.walls, contact.i, contact.j).e_n;
    step.shift[row] = 0.5 * p.row_scale[row] * (1 - e_n) * std::max(-step.u_before[row], 0.0);
  }
  p.u_free += step.shift;
}

bool has_compression(const AssembledStep& step, double tol) {
  const ContactProblem& p = step.problem;
  double before = 0, with_forces = 0;
  for (int row = 0; row < p.num_rows(); row += p.dim) {
    const double w = diagonal_entry(p, row);
    before += std::pow(std::min(step.u_before[row], 0.0), 2) / w;
    with_forces += std::pow(std::min(p.u_free[row], 0.0), 2) / w;
  }
  return before > tol * with_forces;
}

template <int D>
ContactProblem compression_problem(const State<D>& start, const Midpoint<D>& mid,
                                   const AssembledStep& step) {
  ContactProblem p = step.problem;
  p.v_free = velocities_before(start, mid, step.dofs);
  p.u_free = step.u_before;
  drop_rounding(p.v_free, p);
  return p;
}

template <int D>
Vector returned_impulses(const Scene<D>& scene, const State<D>& start, const Midpoint<D>& mid,
                         const ContactProblem& problem, const Vector& compression) {
  Vector returned(problem.num_contacts());
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    const Contact<D>& contact = mid.contacts[c];
    const Eigen::Index k = static_cast<Eigen::Index>(c);
    const double e_n = pair_law(scene, start.bodies, mid.walls, contact.i, contact.j).e_n;
    returned[k] = e_n * std::max(compression[k * problem.dim], 0.0);
  }
  return returned;
}

ContactProblem expansion_problem(const ContactProblem& step, const Vector& compression,
                                 const Vector& returned) {
  ContactProblem p = step;
  act(given_impulses(step, compression, returned), p);
  drop_rounding(step.v_free.cwiseAbs() + p.v_free.cwiseAbs(), p);
  const std::vector<int> contacts = rubbing(step, returned);
  if (contacts.empty()) return p;

  const int d = step.dim, n = step.num_dofs(), m = step.num_rows();
  const int more = static_cast<int>(contacts.size());
  ContactProblem q{.dim = d};
  q.A.resize(n + more, n + more);
  q.H.resize(n + more, m + d * more);
  for (int k = 0; k < n; ++k) copy_column(step.A, k, k, q.A);
  for (int k = 0; k < m; ++k) copy_column(step.H, k, k, q.H);
  Vector v(more), u(d * more), mu(more);
  for (int k = 0; k < more; ++k) {
    const int row = contacts[to_size(k)] * d;
    const double w = diagonal_entry(step, row);  // as heavy as what the contact moves
    q.A.startVec(n + k);
    q.A.insertBack(n + k, n + k) = 1 / w;
    q.H.startVec(m + d * k);
    q.H.insertBack(n + k, m + d * k) = 1;
    for (int t = 1; t < d; ++t) copy_column(step.H, row + t, m + d * k + t, q.H);
    v[k] = -w * returned[contacts[to_size(k)]];
    u[d * k] = v[k];
    u.segment(d * k + 1, d - 1) = p.u_free.segment(row + 1, d - 1);
    mu[k] = step.mu[contacts[to_size(k)]];
  }
  q.A.finalize();
  q.H.finalize();
  q.v_free = joined(p.v_free, v);
  q.u_free = joined(p.u_free, u);
  q.mu = joined(p.mu, mu);
  return q;
}

Vector impulses_of_phases(const ContactProblem& step, const Vector& compression,
                          const Vector& returned, const Vector& expansion) {
  const int d = step.dim, m = step.num_rows();
  Vector s = given_impulses(step, compression, returned) + expansion.head(m);
  const std::vector<int> contacts = rubbing(step, returned);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    s.segment(contacts[k] * d + 1, d - 1) +=
        expansion.segment(m + d * static_cast<int>(k) + 1, d - 1);
  }
  return s;
}

template Scene<2> with_step_laws(const Scene<2>&);
template Scene<3> with_step_laws(const Scene<3>&);
template void add_mean_restitution(const Scene<2>&, const State<2>&, const Midpoint<2>&,
                                   AssembledStep&);
template void add_mean_restitution(const Scene<3>&, const State<3>&, const Midpoint<3>&,
                                   AssembledStep&);
template ContactProblem compression_problem(const State<2>&, const Midpoint<2>&,
                                            const AssembledStep&);
template ContactProblem compression_problem(const State<3>&, const Midpoint<3>&,
                                            const AssembledStep&);
template Vector returned_impulses(const Scene<2>&, const State<2>&, const Midpoint<2>&,
                                  const ContactProblem&, const Vector&);
template Vector returned_impulses(const Scene<3>&, const State<3>&, const Midpoint<3>&,
                                  const ContactProblem&, const Vector&);

}  // namespace bipot
