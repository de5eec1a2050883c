#include "core/criterion/contact_error.h"

#include <Eigen/Geometry>

#include "core/motion/assembly.h"
#include "core/problem/delassus.h"
#include "core/scene/contact_detection.h"
#include "core/scene/scene_parts.h"
#include "tests/support/manufactured.h"
#include "tests/support/naive_error.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// One contact with W = diag(w).
ContactProblem one_contact(const Vector& w, const Vector& b, double mu) {
  return delassus_problem(static_cast<int>(w.size()), w.asDiagonal().toDenseMatrix(), b,
                          Vector::Constant(1, mu));
}

Vector random_impulse(int dim, int contacts, PortableRandom& draw) {
  Vector s(dim * contacts);
  for (Eigen::Index k = 0; k < s.size(); ++k) s[k] = 2 * draw.symmetric();
  for (int c = 0; c < contacts; ++c) s[c * dim] += 1;
  return s;
}

void add_random_scale(ContactProblem& p, PortableRandom& draw) {
  p.row_scale.resize(p.num_rows());
  for (int c = 0; c < p.num_contacts(); ++c) {
    p.row_scale[c * p.dim] = std::sqrt(1 + draw.uniform());
    const double r_t = std::sqrt(1 + draw.uniform());
    for (int k = 1; k < p.dim; ++k) p.row_scale[c * p.dim + k] = r_t;
  }
}

void expect_same(const ContactError& a, const ContactError& b, double relative) {
  EXPECT_NEAR(a.epsilon, b.epsilon, relative * b.epsilon);
  EXPECT_NEAR(a.eta, b.eta, relative * b.eta);
  EXPECT_NEAR(a.raw42, b.raw42, relative * b.raw42);
  EXPECT_NEAR(a.natural_map, b.natural_map, relative * b.natural_map);
}

TEST(ContactError, EqualsThePapersWhereNothingPenetratesAndFrictionDissipates) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    PortableRandom draw(seed);
    const int dim = 2 + seed % 2;
    Manufactured m = manufactured_problem(dim, 6, 8, seed);
    ContactProblem& p = m.problem;
    // Impulses in the cone with velocities that open: the law is in error by power, not by sign.
    Vector u(p.num_rows());
    for (int c = 0; c < 8; ++c) {
      for (int k = 0; k < dim; ++k) u[c * dim + k] = 3 * draw.symmetric();
      u[c * dim] = draw.between(1e-3, 0.1);
    }
    p.u_free = u - Vector(p.W * m.s);
    const ContactError e = contact_error(p, m.s);
    if (e.friction_power < kTheta * e.energy) continue;
    ++compared;
    EXPECT_GT(e.raw42, 0);
    EXPECT_EQ(e.epsilon, e.raw42);
  }
  EXPECT_GT(compared, 200);
}

// One contact, s in K, N = s - p with p = P_K(s - rho û). The inequality of the projection, tested
// with s, gives |N|² <= rho û·N = rho (û·s - û·p). p in K and mu p_n |u_t| + p_t·u_t >= 0 give -û·p
// <= p_n u_n⁻ <= (s_n + |N|) u_n⁻. With s_n (u_n + u_n⁻) <= s_n |u_n| follows |N|² <= rho (G_c + |N|
// u_n⁻), and with rho |N| u_n⁻ <= ½ |N|² + ½ rho² (u_n⁻)² at last |N|²/(2 rho) <= G_c + V_c. Sum over
// the contacts and divide.
TEST(ContactError, NaturalMapIsBoundedByTheRootOfEpsilon) {
  for (unsigned seed = 1; seed <= 1500; ++seed) {
    PortableRandom draw(seed);
    const int dim = 1 + seed % 3;
    Manufactured m = manufactured_problem(dim, 5, 7, seed, draw.decades(-1.3, 0.3));
    if (seed % 2 == 0) add_random_scale(m.problem, draw);
    const Vector far = random_impulse(dim, 7, draw) * draw.decades(-3, 3);
    const Vector near = m.s + draw.decades(-10, 0) * random_impulse(dim, 7, draw);
    for (const Vector& s : {far, near}) {
      const ContactError e = contact_error(m.problem, s);
      EXPECT_LE(e.eta, std::sqrt(e.epsilon) * (1 + 1e-9));
      EXPECT_EQ(e.guarded(), std::max(e.epsilon, e.eta));
    }
  }
}

TEST(ContactError, AgreesWithTheNaiveImplementation) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    PortableRandom draw(seed);
    const int dim = 1 + seed % 3;
    Manufactured m = manufactured_problem(dim, 5, 7, seed, draw.decades(-1.3, 0.3));
    if (seed % 2 == 0) add_random_scale(m.problem, draw);
    if (seed % 5 == 0) {  // W alone
      m.problem.A = m.problem.H = SparseMatrix();
      m.problem.v_free = Vector();
    }
    ASSERT_EQ(validate(m.problem), "");
    const Vector s = m.s + draw.decades(-3, 2) * random_impulse(dim, 7, draw);
    const ContactError e = contact_error(m.problem, s);
    const NaiveError naive = naive_error(m.problem, s);
    EXPECT_NEAR(e.epsilon / naive.epsilon, 1, 1e-10);
    EXPECT_NEAR(e.eta / naive.eta, 1, 1e-10);
    EXPECT_NEAR(e.natural_map / naive.natmap_scaled, 1, 1e-10);
    if (dim == 1) {
      EXPECT_TRUE(std::isnan(e.raw42) && std::isnan(naive.raw42));
    } else {
      EXPECT_NEAR(e.raw42, naive.raw42, 1e-10 * naive.raw42);
    }
  }
}

TEST(ContactError, RefusesAnImpulseOfAnotherProblem) {
  const ContactProblem p = one_contact(Vector::Ones(2), Vector::Ones(2), 0.3);
  EXPECT_THROW(contact_error(p, Vector::Ones(1)), std::invalid_argument);
  EXPECT_THROW(contact_error(p, Vector::Ones(3)), std::invalid_argument);
}

TEST(ContactError, DoesNotDependOnUnits) {
  // Lengths x 1000, masses x 1000, times x 10: velocities x 100, impulses x 1e5, lever arms x 1000.
  const double length = 1000, mass = 1000, time = 10;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    PortableRandom draw(seed);
    const int dim = 1 + seed % 3;
    const int dofs = dim == 3 ? 6 : (dim == 2 ? 3 : 2), linear = dim == 3 ? 3 : 2;
    Manufactured m = manufactured_problem(dim, 5, 7, seed);
    if (seed % 2 == 0) add_random_scale(m.problem, draw);
    ContactProblem q = m.problem;
    q.W = SparseRows();
    for (int k = 0; k < q.A.outerSize(); ++k) {
      q.A.coeffRef(k, k) *= mass * (k % dofs < linear ? 1 : length * length);
    }
    for (int k = 0; k < q.H.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator it(q.H, k); it; ++it) {
        if (it.row() % dofs >= linear) it.valueRef() *= length;
      }
    }
    q.u_free *= length / time;
    const Vector s = m.s + 0.1 * random_impulse(dim, 7, draw);
    const ContactError e = contact_error(m.problem, s);
    const ContactError scaled = contact_error(q, s * (mass * length / time));
    EXPECT_NEAR(scaled.epsilon / e.epsilon, 1, 1e-12);
    EXPECT_NEAR(scaled.eta / e.eta, 1, 1e-12);
    EXPECT_NEAR(scaled.natural_map / e.natural_map, 1, 1e-12);
    if (dim > 1) {
      EXPECT_NEAR(scaled.raw42 / e.raw42, 1, 1e-12);
    }
    EXPECT_EQ(scaled.worst_epsilon, e.worst_epsilon);
    EXPECT_EQ(scaled.worst_eta, e.worst_eta);
  }
}

TEST(ContactError, DoesNotDependOnTheOrientationOfTheScene) {
  Scene<2> scene{.materials = {"m"}, .laws = {{.mu = 0.4, .e_n = 0.3, .e_t = 0.8}}};
  PortableRandom draw(5);
  std::vector<Disk> disks;
  for (int k = 0; k < 60; ++k) {
    Disk d;
    d.x = Vec2(draw.uniform(), draw.uniform());
    d.v = Vec2(draw.symmetric(), draw.symmetric());
    d.spin = draw.symmetric();
    d.radius = draw.between(0.05, 0.1);
    d.mass = draw.between(0.5, 2);
    d.inertia = 0.5 * d.mass * d.radius * d.radius;
    disks.push_back(d);
  }
  std::vector<Wall<2>> walls(2);
  walls[0].a = Vec2(0, 0.05);
  walls[1].shape = Wall<2>::Shape::kSegment;
  walls[1].a = Vec2(0.05, 0);
  walls[1].b = Vec2(0.1, 1);
  drive(walls[1], Vec2(0.6, 0.8), 3);
  walls[1].v = 0.2 * walls[1].direction;
  const auto evaluate = [&](double degrees) {
    const Eigen::Rotation2D<double> turn(degrees * std::numbers::pi / 180);
    std::vector<Disk> d = disks;
    std::vector<Wall<2>> w = walls;
    std::vector<Vec2> v_free;
    for (Disk& x : d) {
      x.x = turn * x.x;
      x.v = turn * x.v;
      v_free.emplace_back(x.v + turn * Vec2(0, -0.1));
    }
    for (Wall<2>& x : w) {
      x.a = turn * x.a;
      x.b = turn * x.b;
      x.normal = turn * x.normal;
      x.direction = turn * x.direction;
      x.v = turn * x.v;
    }
    scene.walls = w;
    const std::vector<double> wall_free = {0, 0.25};
    const AssembledStep step =
        assemble_step<2>({scene, d, w, detect_contacts(d, w, 0), v_free, wall_free});
    EXPECT_GT(step.problem.num_contacts(), 60);
    PortableRandom impulses(7);
    return contact_error(step.problem, random_impulse(2, step.problem.num_contacts(), impulses));
  };
  const ContactError upright = evaluate(0);
  EXPECT_GT(upright.guarded(), 0.01);
  expect_same(evaluate(37), upright, 1e-11);
}

// Planted errors: a solution, then one contact's impulse is moved by delta along `direction`.
void expect_monotone_response(const Manufactured& m, int contact, const Vector& direction) {
  const int d = m.problem.dim;
  double previous = contact_error(m.problem, m.s).guarded();
  EXPECT_LT(previous, 1e-13);
  for (double delta = 1e-9; delta < 0.2; delta *= 10) {
    Vector s = m.s;
    s.segment(contact * d, d) += delta * direction;
    const double now = contact_error(m.problem, s).guarded();
    EXPECT_GT(now, 2 * previous) << "delta = " << delta;
    EXPECT_GT(now, 1e-2 * delta) << "delta = " << delta;
    previous = now;
  }
}

int find_contact(const Manufactured& m, ContactStatus wanted) {
  const int d = m.problem.dim;
  for (int c = 0; c < m.problem.num_contacts(); ++c) {
    const bool slips = (m.u.segment(c * d + 1, d - 1).array() != 0).any();
    if (wanted == (m.s[c * d] == 0 ? ContactStatus::kTakeOff
                   : slips         ? ContactStatus::kSlip
                                   : ContactStatus::kStick)) {
      return c;
    }
  }
  ADD_FAILURE() << "no such contact";
  return 0;
}

TEST(ContactError, RespondsToAnErrorInTheNormalPartOnly) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 12, 10, 3);
    const int stick = find_contact(m, ContactStatus::kStick);
    const int apart = find_contact(m, ContactStatus::kTakeOff);
    Vector normal = Vector::Zero(dim);
    normal[0] = 1;
    expect_monotone_response(m, stick, normal);
    expect_monotone_response(m, apart, normal);
  }
}

TEST(ContactError, RespondsToAnErrorInTheTangentialPartOnly) {
  for (int dim = 2; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 12, 10, 3);
    const int stick = find_contact(m, ContactStatus::kStick);
    const Vector s = m.s.segment(stick * dim, dim);
    Vector inwards = Vector::Zero(dim);
    inwards.tail(dim - 1) = -s.tail(dim - 1).normalized();
    expect_monotone_response(m, stick, inwards);
    const int slip = find_contact(m, ContactStatus::kSlip);
    inwards.tail(dim - 1) = -m.s.segment(slip * dim + 1, dim - 1).normalized();
    expect_monotone_response(m, slip, inwards);
  }
}

TEST(ContactError, RespondsToAViolationOfTheConeThroughItsProjection) {
  for (int dim = 2; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 12, 10, 3);
    const int slip = find_contact(m, ContactStatus::kSlip);
    Vector outwards = Vector::Zero(dim);
    outwards.tail(dim - 1) = m.s.segment(slip * dim + 1, dim - 1).normalized();
    expect_monotone_response(m, slip, outwards);
    Vector below = Vector::Zero(dim);
    below[0] = -1;  // s_n too small for its s_t
    expect_monotone_response(m, slip, below);
    // The projected impulse is the one that is judged.
    Vector outside = m.s;
    outside.segment(slip * dim, dim) += outwards;
    ContactErrorEvaluator evaluate(m.problem);
    const double error = evaluate(outside).guarded();
    const Vector projected = evaluate.impulse();
    EXPECT_LE(projected.segment(slip * dim + 1, dim - 1).norm(),
              m.problem.mu[slip] * projected[slip * dim] * (1 + 1e-15));
    EXPECT_NEAR(evaluate(projected).guarded(), error, 1e-12 * error);
  }
}

TEST(ContactError, IsZeroOnTheLaw) {
  // W = 1, numbers without rounding. Stick: u = 0, s inside the cone.
  const Vector w = vec({1, 1});
  EXPECT_EQ(contact_error(one_contact(w, vec({-1, -0.25}), 0.5), vec({1, 0.25})).guarded(), 0);
  // Slip: u = (0, 1), s = (1, -0.5).
  const ContactError slip = contact_error(one_contact(w, vec({-1, 1.5}), 0.5), vec({1, -0.5}));
  EXPECT_EQ(slip.epsilon, 0);
  EXPECT_LT(slip.eta, 1e-15);
  EXPECT_EQ(slip.raw42, 0);
  EXPECT_EQ(slip.friction_power, 0.5);
  // Take-off.
  EXPECT_EQ(contact_error(one_contact(w, vec({1, 3}), 0.5), vec({0, 0})).guarded(), 0);
  // Wrong in each way: not on the law, not zero.
  EXPECT_GT(contact_error(one_contact(w, vec({-1, 1.5}), 0.5), vec({1, 0.5})).guarded(), 0.1);
  EXPECT_GT(contact_error(one_contact(w, vec({-1, 0}), 0.5), vec({2, 0})).guarded(), 0.1);
  EXPECT_GT(contact_error(one_contact(w, vec({-1, 0}), 0.5), vec({0, 0})).guarded(), 0.1);
}

TEST(ContactError, SeesPenetrationThatThePapersFormClips) {
  // Slides as Coulomb wants, but sinks with u_n = -2: s = (1, -0.5), u = (-2, 1), W = 1.
  // D = 0.5, G = 0 + 1 * 2, V = ½ * 4, E = max(½ * 1.25, ½ * 9) = 4.5.
  const ContactError e =
      contact_error(one_contact(vec({1, 1}), vec({-3, 1.5}), 0.5), vec({1, -0.5}));
  EXPECT_EQ(e.raw42, 0);
  EXPECT_DOUBLE_EQ(e.energy, 4.5);
  EXPECT_DOUBLE_EQ(e.friction_power, 0.5);
  EXPECT_DOUBLE_EQ(e.epsilon, 4.0 / 0.5);
  // û = (-1.5, 1): tau = (2.5, -1.5) -> s_n = (2.5 + 0.75)/1.25 = 2.6, s_t = -1.3: |N|² = 3.2.
  EXPECT_DOUBLE_EQ(e.eta, std::sqrt(1.6 / 0.5));
}

TEST(ContactError, StaticPileHasNoRawError) {
  const ContactError e = contact_error(one_contact(vec({1, 3}), vec({-1, 0}), 0.5), vec({1, 0}));
  EXPECT_TRUE(std::isnan(e.raw42));
  EXPECT_EQ(e.guarded(), 0);
  EXPECT_EQ(e.natural_map, 0);
}

TEST(ContactError, NothingToDoIsNoError) {
  ContactProblem empty;
  empty.u_free = empty.mu = Vector();
  const ContactError none = contact_error(empty, Vector());
  EXPECT_EQ(none.guarded(), 0);
  EXPECT_TRUE(std::isnan(none.raw42));
  EXPECT_EQ(none.worst_epsilon, -1);
  const ContactProblem opening = one_contact(vec({1, 3}), vec({0, 5}), 0.5);
  EXPECT_EQ(contact_error(opening, vec({0, 0})).guarded(), 0);
  EXPECT_EQ(contact_error(opening, vec({0, 0})).natural_map, 0);
}

TEST(ContactError, WorkWithoutAnyEnergyToCompareItWithIsInfinite) {
  // A disk between two jaws that both recede: s = (1, 1) is in the kernel of W, moves nothing, and
  // still presses where the contacts open.
  Eigen::MatrixXd W(2, 2);
  W << 1, -1, -1, 1;
  const Vector mu = Vector::Zero(2);
  const ContactError e = contact_error(delassus_problem(1, W, vec({0.5, 0.5}), mu), vec({1, 1}));
  EXPECT_EQ(e.energy, 0);
  EXPECT_EQ(e.epsilon, kInfinity);
  EXPECT_EQ(e.eta, kInfinity);
  EXPECT_EQ(e.guarded(), kInfinity);
  // The same self-stress at rest is on the law: 0/0 = 0.
  EXPECT_EQ(contact_error(delassus_problem(1, W, vec({0, 0}), mu), vec({1, 1})).guarded(), 0);
}

TEST(ContactError, NotANumberIsNotAnError) {
  for (int dim = 1; dim <= 3; ++dim) {
    const ContactProblem p = one_contact(Vector::Ones(dim), -Vector::Ones(dim), 0.5);
    Vector s = Vector::Ones(dim);
    s[dim - 1] = std::numeric_limits<double>::quiet_NaN();
    const ContactError e = contact_error(p, s);
    EXPECT_TRUE(std::isnan(e.guarded())) << "d = " << dim;
    EXPECT_FALSE(std::signbit(e.epsilon) || std::signbit(e.eta)) << "printed as -nan";
  }
}

TEST(ContactError, RestitutionIsJudgedInPhysicalVariables) {
  // W = diag(2, 6), e_n = 1, e_t = 0, mu = 0.5; physical s = (1, -0.5), mean velocity u = (0, 1):
  // slip on the law. In the problem's variables r = (√2, 1).
  const double r = std::sqrt(2.0);
  ContactProblem p = one_contact(vec({2 / (r * r), 6}), vec({-1 * r, 4}), 0.5 / r);
  p.row_scale = vec({r, 1});
  // u_phys = D (W s) + b: b_n = 0 - ½ * 2 = -1 (times r in the problem), b_t = 1 + 6 * 0.5 = 4.
  const ContactError e = contact_error(p, vec({r, -0.5}));
  EXPECT_LT(e.guarded(), 1e-15);
  EXPECT_DOUBLE_EQ(e.friction_power, 0.5);  // 0.5 * 1 * 1; the scaled variables would say the same
  EXPECT_DOUBLE_EQ(e.energy, 1.75);         // ½ (2 * 1 + 6 * 0.25)
  // Twice the normal impulse: projected physically s = (2, -0.5), u = (1, 1), W_nn = 2:
  // G = 1 - 0.5 + 2 = 2.5, D = 1, E = ½ (8 + 1.5) = 4.75.
  const ContactError wrong = contact_error(p, vec({2 * r, -0.5}));
  EXPECT_DOUBLE_EQ(wrong.epsilon, 2.5);
  EXPECT_DOUBLE_EQ(wrong.energy, 4.75);
  // û = (1.5, 1), tau = s - û/2 = (1.25, -1): s_n = 1.4, s_t = -0.7: N² = 0.36 + 0.04.
  EXPECT_DOUBLE_EQ(wrong.eta, std::sqrt(0.4));
}

TEST(ContactError, NamesTheWorstContact) {
  // Three contacts that do not see each other; the error is in the second.
  const ContactProblem p = delassus_problem(2, Eigen::MatrixXd::Identity(6, 6),
                                            vec({-1, 0, -1, 0, -1, 0}), Vector::Constant(3, 0.5));
  const ContactError e = contact_error(p, vec({1, 0, 1.5, 0, 1.1, 0}));
  EXPECT_EQ(e.worst_epsilon, 1);
  EXPECT_EQ(e.worst_eta, 1);
}

TEST(ContactError, CountsContactsByStatus) {
  const ContactProblem p = delassus_problem(2, Eigen::MatrixXd::Identity(8, 8), Vector::Zero(8),
                                            Vector::Constant(4, 0.5));
  const ContactCount count = count_contacts(p, vec({0, 0, 1, 0.2, 1, -0.5, 2, 1}));
  EXPECT_EQ(count.take_off, 1);
  EXPECT_EQ(count.stick, 1);
  EXPECT_EQ(count.slip, 2);
}

/// What an evaluator lets go of comes back with the next evaluation, with the same bits.
TEST(ContactErrorEvaluator, RestsBetweenEvaluations) {
  for (const int dim : {2, 3}) {
    const Manufactured made = manufactured_problem(dim, 7, 12, 3);
    ContactErrorEvaluator evaluate(made.problem);
    const Vector s = 0.9 * made.s;
    const ContactError before = evaluate(s);
    const Vector u = evaluate.velocity(), impulse = evaluate.impulse();
    evaluate.release_scratch();
    EXPECT_EQ(evaluate.velocity().size(), 0);
    ContactErrorEvaluator copy(evaluate, {});
    for (ContactErrorEvaluator* again : {&evaluate, &copy}) {
      EXPECT_EQ((*again)(s).guarded(), before.guarded());
      EXPECT_EQ(again->velocity(), u);
      EXPECT_EQ(again->impulse(), impulse);
    }
  }
}

}  // namespace
}  // namespace bipot
