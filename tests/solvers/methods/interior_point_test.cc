#include "solvers/methods/interior_point.h"

#include <Eigen/LU>

#include "core/motion/time_stepping.h"
#include "core/scene/generators.h"
#include "core/scene/scene_parts.h"
#include "solvers/interior/interior_state.h"
#include "solvers/systems/shifted_delassus.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolverOptions with(std::map<std::string, std::string> parameters, double tol = 1e-8) {
  return SolverOptions{.tol = tol, .parameters = std::move(parameters)};
}

/// The problem of the first step of a scene at rest.
ContactProblem first_problem(const Scene<2>& scene) {
  return step_problem(scene, initial_state(scene));
}

Scene<2> heap_of(std::vector<Disk> disks, double mu, double tilt_degrees) {
  const double tilt = tilt_degrees * std::numbers::pi / 180;
  Scene<2> scene = one_law<2>({.mu = mu});
  scene.gravity = kGravity * Vec2(std::sin(tilt), -std::cos(tilt));
  scene.bodies = std::move(disks);
  for (Disk& d : scene.bodies) give_density(d, 1000);
  scene.walls = {flat_floor<2>()};
  scene.step = 1e-3;
  scene.contact_distance = 1e-8;
  return scene;
}

/// The same between upright walls, this far apart.
Scene<2> boxed(Scene<2> scene, double width) {
  scene.walls.push_back(half_space<2>(Vec2::Zero(), Vec2(1, 0), "left"));
  scene.walls.push_back(half_space<2>(Vec2(width, 0), Vec2(-1, 0), "right"));
  return scene;
}

constexpr double kRadius = 0.01;

ContactProblem lattice(bool triangular, int n, double mu, double tilt) {
  const auto disks = triangular ? triangular_lattice(n, n, kRadius, Vec2::Zero())
                                : rectangular_lattice(n, n, kRadius, Vec2::Zero());
  return first_problem(boxed(heap_of(disks, mu, tilt), 2 * kRadius * n));
}

ContactProblem free_pyramid(int rows, double mu) {
  return first_problem(heap_of(pyramid(rows, kRadius, Vec2::Zero()), mu, 0));
}

TEST(ShiftedDelassus, BothFormsSolveTheDenseSystemAndAgreeOnTheSign) {
  for (int dim = 1; dim <= 3; ++dim) {
    const ContactProblem p = manufactured_problem(dim, 6, 9, 3).problem;
    const DelassusOperator delassus(p);
    const int m = p.num_rows();
    bool seen[3] = {false, false, false};
    for (unsigned seed = 1; seed <= 6; ++seed) {
      const Vector values = 3 * random_vector(p.num_contacts() * dim * dim, seed);
      const std::vector<double> R(values.begin(), values.end());
      Eigen::MatrixXd dense = Eigen::MatrixXd::Identity(m, m);
      for (int c = 0; c < p.num_contacts(); ++c) {
        for (int a = 0; a < dim; ++a) {
          for (int b = 0; b < dim; ++b) {
            dense.row(c * dim + a) +=
                R[(c * dim + a) * dim + b] * Eigen::MatrixXd(p.W).row(c * dim + b);
          }
        }
      }
      const Vector g = random_vector(m, seed + 100);
      const Vector expected = dense.lu().solve(g);
      const int sign = dense.determinant() > 0 ? 1 : -1;
      seen[sign + 1] = true;
      for (const auto form : {ShiftedDelassus::Form::kBody, ShiftedDelassus::Form::kContact}) {
        ShiftedDelassus system(p, form);
        ASSERT_TRUE(system.factor(R));
        const bool body = form == ShiftedDelassus::Form::kBody;
        EXPECT_EQ(system.matrix().rows(), body ? p.num_dofs() : m);
        Vector x;
        system.solve(g, x);
        EXPECT_LT((x - expected).norm(), 1e-9 * expected.norm()) << dim << seed;
        EXPECT_EQ(system.determinant_sign(), sign) << dim << seed;
      }
    }
    EXPECT_TRUE(seen[0] && seen[2]) << "both signs must occur";
  }
}

/// A chain of hubs, each with two leaves, masses 1, K = I + H R Hᵀ. One leaf's contact has r = -1 +
/// 1e-13: its diagonal 1 + r is 1e-13 beside a coupling of 1 to its hub. A hub shares its front
/// with the last of its leaves at most (a front is a chain of the elimination tree), which is the
/// other one at every second hub: there the leaf is a front by itself with a multiplier of 1e13,
/// though K with its pairs [1e-13, 1; 1, k] is as regular as [0, 1; 1, k].
TEST(ShiftedDelassus, TakesUmfpackWherePivotsOfTheFrontsAreSmall) {
  ContactProblem p{.dim = 1};
  const int hubs = 60, contacts = 3 * hubs - 1;
  p.A.resize(3 * hubs, 3 * hubs);
  p.A.setIdentity();
  p.H.resize(3 * hubs, contacts);
  std::vector<double> R;
  const auto join = [&](int a, int b, double r) {
    const int c = static_cast<int>(R.size());
    p.H.insert(a, c) = -1;
    p.H.insert(b, c) = 1;
    R.push_back(r);
  };
  for (int k = 0; k < hubs; ++k) {
    join(3 * k, 3 * k + 1, k % 2 == 0 ? -1 + 1e-13 : 0.5);
    join(3 * k, 3 * k + 2, k % 2 == 1 ? -1 + 1e-13 : 0.5);
    if (k > 0) join(3 * k, 3 * k - 3, 0.5);
  }
  p.H.makeCompressed();
  p.v_free = Vector::Zero(3 * hubs);
  p.u_free = Vector::Zero(contacts);
  p.mu = Vector::Zero(contacts);
  ShiftedDelassus system(p, ShiftedDelassus::Form::kBody);
  ASSERT_TRUE(system.factor(R));
  EXPECT_FALSE(system.by_fronts());
  const Vector g = random_vector(contacts, 3);
  Vector x;
  system.solve(g, x);
  const Vector wx = p.H.transpose() * (p.H * x);
  const Vector back = x + Eigen::Map<const Vector>(R.data(), contacts).cwiseProduct(wx);
  EXPECT_LT((back - g).norm(), 1e-9 * (g.norm() + x.norm()));
  ASSERT_TRUE(system.factor(std::vector<double>(to_size(contacts), 0.5)));
  EXPECT_TRUE(system.by_fronts()) << "a positive definite K needs no other";
}

TEST(ShiftedDelassus, RefusesTheBodyFormWithoutBodies) {
  const ContactProblem p = local_form(manufactured_problem(2, 6, 9, 3).problem);
  const DelassusOperator delassus(p);
  EXPECT_THROW(ShiftedDelassus(p, ShiftedDelassus::Form::kBody), std::invalid_argument);
}

template <int D>
void expect_algebra_consistent() {
  using Jordan = ContactJordan<D>;
  constexpr unsigned parts = D > 1 ? 1 : 0;
  using Pairs = typename Jordan::Pairs;
  Pairs x = random_vector(Jordan::P, 5), z = random_vector(Jordan::P, 6);
  if constexpr (D == 3) x[1] = 2;
  x[0] = 1;
  const Pairs y = Jordan::divide(z, x, parts);
  EXPECT_LT((Jordan::product(x, y, parts) - z).norm(), 1e-14);
  EXPECT_LT((Jordan::product(y, x, parts) - z).norm(), 1e-14) << "the product commutes";
  // On the path x and its multiple inverse have the identity as product.
  const Pairs unit =
      Jordan::product(x, Jordan::divide(Jordan::identity(0.3, parts), x, parts), parts);
  for (int k = 0; k < Jordan::kEigenvalues; ++k) {
    EXPECT_NEAR(Jordan::eigenvalues(unit, parts)[k], 0.3, 1e-14);
  }
  EXPECT_NEAR(Jordan::trace(z, parts),
              Jordan::eigenvalues(z, parts).head(Jordan::rank(parts)).sum(), 1e-14);
}

TEST(ContactJordan, DivisionInvertsTheProduct) {
  expect_algebra_consistent<1>();
  expect_algebra_consistent<2>();
  expect_algebra_consistent<3>();
}

TEST(ContactJordan, TheLongestStepEndsOnTheBoundary) {
  using Jordan = ContactJordan<3>;
  const Jordan::Pairs x(1, 1, 0.3, -0.2);
  int bounded = 0;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    Jordan::Pairs dx = random_vector(4, seed);
    const double t = Jordan::longest_step(x, dx, true);
    const double reach = std::isinf(t) ? 1e6 : t;
    EXPECT_GT(Jordan::eigenvalues(x + 0.999 * reach * dx, true).minCoeff(), 0) << seed;
    if (std::isinf(t)) continue;
    ++bounded;
    EXPECT_NEAR(Jordan::eigenvalues(x + t * dx, true).minCoeff(), 0, 1e-9 * (1 + t)) << seed;
  }
  EXPECT_GT(bounded, 10);
}

TEST(ContactJordan, ThePairsCarryTheExactLaw) {
  // x·y = mu s_n |u_t| + s_t·u_t where gamma = |u_t|, and u_n = w.
  const double mu = 0.4;
  const Local<2> s2(2.0, -0.5), u2(0.3, 0.7);
  using J2 = ContactJordan<2>;
  const J2::Pairs x2 = J2::pairs_of_impulse(s2, mu, true);
  EXPECT_LT((J2::impulse_of_pairs(x2, true) - s2).norm(), 1e-15);
  const J2::Pairs y2(0.3, 0.0, 0.7);  // la = max(-u_t, 0), lc = max(u_t, 0)
  EXPECT_LT((J2::velocity_of_pairs(y2, true) - u2).norm(), 1e-15);
  EXPECT_NEAR(J2::trace(J2::product(x2, y2, true), true) - s2[0] * u2[0],
              mu * s2[0] * std::abs(u2[1]) + s2[1] * u2[1], 1e-14);
  using J3 = ContactJordan<3>;
  const Local<3> s3(2.0, -0.5, 0.2), u3(0.3, 0.7, -0.1);
  const J3::Pairs y3(0.3, u3.tail<2>().norm(), 0.7, -0.1);
  const J3::Pairs x3 = J3::pairs_of_impulse(s3, mu, true);
  EXPECT_LT((J3::velocity_of_pairs(y3, true) - u3).norm(), 1e-15);
  EXPECT_NEAR(J3::trace(J3::product(x3, y3, true), true) - s3[0] * u3[0],
              mu * s3[0] * u3.tail<2>().norm() + s3.tail<2>().dot(u3.tail<2>()), 1e-14);
}

template <int D>
void expect_direction_solves_the_linearised_system() {
  using Jordan = ContactJordan<D>;
  constexpr int P = Jordan::P;
  ContactProblem p = manufactured_problem(D, 8, 12, 11).problem;
  if (D > 1) p.mu[3] = 0;  // no friction: the tangential pairs drop out
  const DelassusOperator delassus(p);
  InteriorSystem<D> system(p, delassus, ShiftedDelassus::Form::kAuto);
  const double delta = 0.1;
  const InteriorState<D> z =
      system.central_state(Vector::Constant(12, 0.7), Vector::Constant(12, 0.2));
  Vector r = random_vector(12 * P, 1), q = random_vector(12 * D, 2);
  ASSERT_TRUE(system.linearise(z, delta));
  PairDirection d;
  system.direction(z, r, q, d);
  Vector wds;
  delassus.apply(d.ds, wds);
  for (int c = 0; c < 12; ++c) {
    const unsigned f = system.parts(c);
    const typename Jordan::Pairs left =
        Jordan::product(system.pairs(z.X, c), system.pairs(d.dY, c), f) +
        Jordan::product(system.pairs(z.Y, c), system.pairs(d.dX, c), f);
    const int count = f || D == 1 ? P : 1;
    EXPECT_LT((left - system.pairs(r, c)).head(count).norm(), 1e-12) << c;
    const Local<D> kinematic =
        local<D>(wds, c) + delta * local<D>(system.mobility(), c).cwiseProduct(local<D>(d.ds, c)) -
        Jordan::velocity_of_pairs(system.pairs(d.dY, c), f) + local<D>(q, c);
    EXPECT_LT(kinematic.head(f ? D : 1).norm(), 1e-11) << c;
    if (!f) {
      EXPECT_EQ(local<D>(d.ds, c).tail(D - 1).norm(), 0);
    }
  }
}

TEST(InteriorSystem, DirectionsSolveTheLinearisedSystem) {
  expect_direction_solves_the_linearised_system<1>();
  expect_direction_solves_the_linearised_system<2>();
  expect_direction_solves_the_linearised_system<3>();
}

TEST(InteriorPoint, ReachesManufacturedSolutionsInEveryDimension) {
  for (int dim = 1; dim <= 3; ++dim) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      Manufactured m = manufactured_problem(dim, 30, 40, seed);
      const SolveResult r = solve("ipm", m.problem);
      EXPECT_EQ(r.status, SolveStatus::kConverged) << dim << " " << seed << ": " << r.message;
      EXPECT_LT((r.u - m.u).norm(), 1e-6 * m.u.norm()) << dim << " " << seed;
      EXPECT_LE(r.iterations, 40);
    }
  }
}

TEST(InteriorPoint, SolvesLocalProblemsWithUnsymmetricOperators) {
  for (int dim = 2; dim <= 3; ++dim) {
    Manufactured m = manufactured_problem(dim, 30, 40, 4);
    ContactProblem p = local_form(m.problem);
    // Rounded data of other codes: relative perturbations that differ between W_ij and W_ji.
    double asymmetry = 0;
    for (int k = 0; k < p.W.outerSize(); ++k) {
      for (SparseRows::InnerIterator it(p.W, k); it; ++it) {
        if (it.row() != it.col()) it.valueRef() *= 1 + 1e-4 * std::sin(3.0 * it.row() + it.col());
      }
    }
    for (int k = 0; k < p.W.outerSize(); ++k) {
      for (SparseRows::InnerIterator it(p.W, k); it; ++it) {
        asymmetry = std::max(asymmetry, std::abs(it.value() - p.W.coeff(it.col(), it.row())));
      }
    }
    ASSERT_GT(asymmetry, 1e-6);
    converged(solve("ipm", p), dim);
  }
}

TEST(InteriorPoint, HandlesContactsWithoutFrictionAmongOthers) {
  for (int dim = 2; dim <= 3; ++dim) {
    ContactProblem p = manufactured_problem(dim, 30, 40, 8).problem;
    for (int c = 0; c < 40; c += 3) p.mu[c] = 0;
    const SolveResult r = converged(solve("ipm", p), dim);
    for (int c = 0; c < 40; c += 3) EXPECT_EQ(r.s.segment(c * dim + 1, dim - 1).norm(), 0);
  }
}

TEST(InteriorPoint, BothLinearSystemsReachTheSameVelocities) {
  const ContactProblem p = lattice(true, 6, 0.3, 10);
  const SolveResult body = converged(solve("ipm", p, with({{"linear_system", "body"}}, 1e-10)));
  const SolveResult contact =
      converged(solve("ipm", p, with({{"linear_system", "contact"}}, 1e-10)));
  EXPECT_LT((body.u - contact.u).norm(), 1e-8 * p.u_free.norm());
}

TEST(InteriorPoint, LatticesTakeFewIterationsFromStartsOfAnyScale) {
  for (const int n : {10, 30}) {
    for (const bool triangular : {false, true}) {
      const ContactProblem p = lattice(triangular, n, 0.3, triangular ? 10 : 0);
      for (const char* scale : {"0.1", "1", "10"}) {
        const SolveResult r = solve("ipm", p, with({{"start_scale", scale}}));
        EXPECT_EQ(r.status, SolveStatus::kConverged) << n << " " << scale << ": " << r.message;
        EXPECT_LE(r.iterations, 25) << n << " " << scale;
      }
    }
  }
}

/// Ten iterations show it, and which of the two: ten more from the other side of the right size.
TEST(InteriorPoint, NoticesAStartThatIsFarTooSmallOrFarTooLarge) {
  const ContactProblem p = lattice(true, 60, 0.3, 10);
  for (const char* scale : {"0.01", "10", "100"}) {
    const SolveResult r = converged(solve("ipm", p, with({{"start_scale", scale}})), scale);
    EXPECT_LE(r.iterations, 25) << scale;
    EXPECT_TRUE(says(r.message, "no path")) << scale << ": ";
  }
}

TEST(InteriorPoint, FreePyramidsAreReached) {
  for (const double mu : {0.3, 0.5}) {
    EXPECT_LE(converged(solve("ipm", free_pyramid(10, mu)), mu).iterations, 150);
  }
}

TEST(InteriorPoint, RandomPilesAreReachedFromStartsOfAnyScale) {
  // A loose filling that falls and settles; then the problem of one more step.
  const auto disks = random_filling(80, {{0.7 * kRadius, 0.4}, {kRadius, 0.6}}, 20 * kRadius, 0.02,
                                    7, Vec2::Zero());
  const Scene<2> scene = boxed(heap_of(disks, 0.5, 0), 20 * kRadius);
  const StepSolver step = [](const ContactProblem& p, const Vector& s0) {
    const SolveResult r = solve("pgs", p, {.tol = 1e-4, .max_iterations = 100, .s0 = s0});
    return StepSolution{.converged = true, .s = r.s};
  };
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper(scene, step);
  for (int k = 0; k < 400; ++k) stepper.advance(state);
  ContactProblem p = stepper.problem();
  ASSERT_GT(p.num_contacts(), 100);
  for (const char* scale : {"0.1", "1", "10"}) {
    EXPECT_LE(converged(solve("ipm", p, with({{"start_scale", scale}})), scale).iterations, 150);
  }
}

/// The problem in other units: lengths are `k` times as many of the new ones, masses too.
ContactProblem in_units(const ContactProblem& si, double k) {
  ContactProblem p = si;
  Vector dof(p.num_dofs());
  for (int i = 0; i < p.num_dofs(); ++i)
    dof[i] = i % 3 == 2 ? 1 / k : 1.0;  // new over old velocity
  for (int i = 0; i < p.num_dofs(); ++i) p.A.coeffRef(i, i) *= i % 3 == 2 ? k * k * k : k;
  p.H = SparseMatrix(dof.cwiseInverse().asDiagonal() * p.H);
  p.v_free = p.v_free.cwiseProduct(dof);
  if (p.has_delassus()) p.W *= 1 / k;
  return p;
}

TEST(InteriorPoint, IterationsDoNotDependOnTheUnits) {
  // kg, m, s -> g, mm, s: numbers differ by rounding. Eight rows pass through folds, where that is
  // magnified: there units that are powers of two, of which nothing is rounded.
  const ContactProblem short_way = free_pyramid(5, 0.3), long_way = free_pyramid(8, 0.5);
  for (const auto& [si, other] : {std::pair{short_way, in_units(short_way, 1000)},
                                  std::pair{long_way, in_units(long_way, 1024)}}) {
    const SolveResult a = converged(solve("ipm", si)), b = converged(solve("ipm", other));
    EXPECT_NEAR(a.iterations, b.iterations, 1);
  }
}

TEST(InteriorPoint, PolishRemovesTheImpulsesOfDegenerateContacts) {
  // Two bodies on the floor under gravity that also touch each other: that contact neither moves
  // nor pushes, and its impulse on the central path falls only as the square root of the product.
  // Contacts: body 1 (x, y) on the floor, body 2, and both side by side.
  const Eigen::MatrixXd H{{0, 0, -1}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const ContactProblem p = unit_masses(1, H, Eigen::Vector4d(0, -1, 0, -1), Vector::Zero(3));
  const SolveResult r = converged(solve("ipm", p, with({}, 1e-14)));
  EXPECT_NEAR(r.s[0], 1, 1e-12);
  EXPECT_LT(r.s[2], 1e-14);
}

TEST(InteriorPoint, AGoodStartCostsAFewNewtonSteps) {
  const ContactProblem p = lattice(true, 10, 0.3, 10);
  const SolveResult rough = converged(solve("ipm", p, with({}, 1e-5)));
  const SolveResult warm = converged(solve("ipm", p, {.tol = 1e-10, .s0 = rough.s}));
  EXPECT_LE(warm.iterations, 8) << warm.message;
  // A bad start: back to the cold one.
  converged(solve("ipm", p, {.tol = 1e-10, .s0 = 1.5 * rough.s}));
}

TEST(InteriorPoint, EachStageCanBeSwitchedOff) {
  const ContactProblem p = lattice(true, 8, 0.3, 10);
  for (const char* name : {"direct", "paths", "polish"}) {
    converged(solve("ipm", p, with({{name, "off"}})), name);
  }
}

TEST(InteriorPoint, FollowsTheCentralPathThroughItsFolds) {
  // The proximal interior point stops at a fold: by itself it does not arrive.
  const ContactProblem p = free_pyramid(20, 0.5);
  const SolveResult without = solve("ipm", p, with({{"paths", "off"}, {"rounds", "3"}}));
  const SolveResult with_paths = solve("ipm", p, with({{"rounds", "3"}}));
  EXPECT_EQ(without.status, SolveStatus::kStalled) << without.message;
  EXPECT_TRUE(says(without.message, "best error"));
  EXPECT_EQ(with_paths.status, SolveStatus::kConverged) << with_paths.message;
  EXPECT_TRUE(says(with_paths.message, "folds"));
}

TEST(InteriorPoint, ThePathAloneSolvesShakenSpheres) {
  // A cubic lattice whose spheres fly apart and into each other.
  const ContactProblem p = cubic_lattice(5, {.mu = 0.4});
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Vector kick = 0.05 * random_vector(p.num_dofs(), seed);
    ContactProblem shaken = p;
    shaken.v_free += kick;
    shaken.u_free += p.H.transpose() * kick;
    const SolveResult r = converged(solve("ipm", shaken, with({{"direct", "off"}}, 1e-10)));
    EXPECT_LE(contact_error(shaken, r.s).guarded(), 1e-10) << seed;
    EXPECT_TRUE(says(r.message, "on 1 paths"));
  }
}

TEST(InteriorPoint, RespectsTheLimits) {
  const ContactProblem p = free_pyramid(10, 0.5);
  const SolveResult limited =
      ended(SolveStatus::kIterationLimit, solve("ipm", p, {.max_iterations = 3}));
  EXPECT_EQ(limited.iterations, 3);
  EXPECT_EQ(solve("ipm", p, {.time_limit = 1e-9}).status, SolveStatus::kTimeLimit);
}

TEST(InteriorPoint, ReportsEveryIteration) {
  SolverOptions options;
  std::vector<int> seen;
  options.on_iteration = [&](const IterationRecord& r) { seen.push_back(r.iteration); };
  const SolveResult r = converged(solve("ipm", lattice(true, 6, 0.3, 10), options));
  ASSERT_EQ(static_cast<int>(seen.size()), r.iterations + 1);
  for (int k = 0; k <= r.iterations; ++k) EXPECT_EQ(seen[k], k);
}

TEST(InteriorPoint, TheSameInputGivesTheSameBits) {
  const ContactProblem p = free_pyramid(8, 0.3);
  EXPECT_EQ(solve("ipm", p).s, solve("ipm", p).s);
}

}  // namespace
}  // namespace bipot
