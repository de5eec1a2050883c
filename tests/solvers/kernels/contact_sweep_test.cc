#include "solvers/kernels/contact_sweep.h"

#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

Vector some_impulse(int rows) {
  Vector s(rows);
  for (int i = 0; i < rows; ++i) s[i] = 1e-5 * (1 + std::sin(3.0 * i));
  return s;
}

/// Sets impulses one after the other and compares every velocity with the product W s + u_free.
template <int D, class Sweep>
void follows(Sweep sweep, const ContactProblem& p) {
  const SparseRows W = assemble_delassus(p.A, p.H, D);
  Vector s = some_impulse(p.num_rows());
  sweep.reset(s);
  for (int c = 0; c < p.num_contacts(); c += 2) {
    const Local<D> changed = 2 * sweep.impulse(c);
    sweep.set(c, changed);
    s.segment<D>(c * D) = changed;
  }
  const Vector u = W * s + p.u_free;
  for (int c = 0; c < p.num_contacts(); ++c) {
    EXPECT_LT((sweep.velocity(c) - u.segment<D>(c * D)).norm(), 1e-13 * u.norm()) << c;
  }
  EXPECT_LT((sweep.impulse() - s).norm(), 1e-15 * s.norm());
}

template <int D>
ContactProblem lattice(double e_t) {
  return triangular_lattice(5, {.dim = D, .e_n = 0.2, .e_t = e_t});
}

TEST(ContactSweep, DiskVelocitiesFollowTheImpulses) {
  const ContactProblem one = lattice<1>(0), two = lattice<2>(0.7);
  follows<1>(DiskSweep<1>(one, *disk_structure(one)), one);
  follows<2>(DiskSweep<2>(two, *disk_structure(two)), two);
}

TEST(ContactSweep, SphereVelocitiesFollowTheImpulses) {
  const ContactProblem p = cubic_lattice(3, {.e_n = 0.2, .e_t = 0.7});
  follows<3>(SphereSweep(p, *sphere_structure(p)), p);
}

TEST(ContactSweep, RunVelocitiesFollowTheImpulses) {
  const ContactProblem two = lattice<2>(0.7), three = cubic_lattice(3);
  ASSERT_TRUE((TwoPassSweep<2, 3>::fits(two)));
  ASSERT_TRUE((TwoPassSweep<3, 6>::fits(three)));
  follows<2>(TwoPassSweep<2, 3>(two), two);
  follows<3>(TwoPassSweep<3, 6>(three), three);
}

TEST(ContactSweep, ExplicitVelocitiesFollowTheImpulses) {
  const ContactProblem p = manufactured_problem(3, 6, 9, 2).problem;
  follows<3>(ExplicitSweep<3>(p, std::make_shared<DelassusBlocks>(p.W, 3)), p);
}

TEST(ContactSweep, RelaxIsTheProjectionInTwoSteps) {
  const ContactProblem p = lattice<2>(0.7);
  DiskSweep<2> relaxed(p, *disk_structure(p)), plain(p, *disk_structure(p));
  const Vector diagonal = DelassusOperator(p).diagonal();
  const Vector start = some_impulse(p.num_rows());
  relaxed.reset(start);
  plain.reset(start);
  for (int c = 0; c < p.num_contacts(); ++c) {
    relaxed.set_steps(c, Local<2>(1.2 / diagonal[2 * c], 1.2 / diagonal[2 * c + 1]), p.mu[c]);
    relaxed.relax(c);
    const Local<2> u = plain.velocity(c);
    Local<2> s = plain.impulse(c);
    s[0] = std::max(0.0, s[0] - 1.2 / diagonal[2 * c] * u[0]);
    s[1] = std::clamp(s[1] - 1.2 / diagonal[2 * c + 1] * u[1], -p.mu[c] * s[0], p.mu[c] * s[0]);
    plain.set(c, s);
  }
  EXPECT_LT((relaxed.impulse() - plain.impulse()).norm(), 1e-12 * plain.impulse().norm());
}

}  // namespace
}  // namespace bipot
