#include "core/base/triplets.h"
#include "core/motion/time_stepping.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "solvers/disks/contact_order.h"
#include "solvers/disks/rolling_bodies.h"
#include "solvers/disks/symmetric_sweep.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/gradient_iteration.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/spectral_estimate.h"
#include "tests/support/bit_hash.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

constexpr SimdPath kPaths[] = {SimdPath::kPortable, SimdPath::kAvx2, SimdPath::kAvx512};

ContactProblem packing(int dim, bool square = false, int side = 30) {
  LatticeOptions o{.dim = dim, .tilt = 0.2, .e_n = 0.2, .e_t = dim == 1 ? 0 : 0.7};
  if (dim == 3) return cubic_lattice(side, o);
  return square ? square_lattice(side, o) : triangular_lattice(side, o);
}

/// On a floor that forces drive.
ContactProblem pressed(const ContactProblem& lattice) {
  return with_driven_wall(lattice, Vector::Unit(lattice.dim == 3 ? 3 : 2, lattice.dim == 3 ? 2 : 1),
                          0.05, 0.01);
}

/// With rolling friction, one contact without, arms of three lengths, and free spins that differ.
ContactProblem rolling_packing(bool square, int side) {
  Scene<2> scene = make_family_scene(square ? "square" : "triangular", side,
                                     {.e_n = 0.2, .e_t = 0.7, .tilt_degrees = 11});
  for (ContactLaw& law : scene.laws) law.mu_r = 0.02;
  ContactProblem p = step_problem(scene, initial_state(scene));
  p.mu_r[0] = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    for (SparseMatrix::InnerIterator it(p.H, 3 * c + 1); it; ++it) {
      if (it.row() % 3 == 2) it.valueRef() *= 1 + 0.1 * static_cast<double>(it.row() / 3 % 3);
    }
    p.u_free[3 * c + 2] += 0.1 * (c % 7 - 3);
  }
  return p;
}

/// The same of spheres. Moments about the tangents and the normal of `plain`, with another factor
/// in each contact.
ContactProblem rolling_spheres(ContactProblem plain) {
  for (int row = 0; row < plain.num_rows(); ++row) {
    for (SparseMatrix::InnerIterator it(plain.H, row); it; ++it) {
      if (it.row() % 6 > 2) it.valueRef() *= 1 + 0.1 * static_cast<double>(it.row() / 6 % 3);
    }
  }
  const SphereStructure spheres = *sphere_structure(plain);
  ContactProblem p{.dim = 6, .A = plain.A, .v_free = plain.v_free, .mu = plain.mu};
  p.mu_r = p.mu_spin = Vector::Constant(plain.num_contacts(), 0.02);
  p.mu_spin *= 0.5;
  p.mu_r[0] = 0;
  p.u_free = Vector::Zero(2 * plain.num_rows());
  Triplets entries;
  for (int c = 0; c < plain.num_contacts(); ++c) {
    const SphereStructure::Contact& contact = spheres.contacts[to_size(c)];
    for (int k = 0; k < 3; ++k) {
      for (SparseMatrix::InnerIterator it(plain.H, 3 * c + k); it; ++it) {
        entries.emplace_back(it.row(), 6 * c + k, it.value());
      }
      p.u_free[6 * c + k] = plain.u_free[3 * c + k];
      p.u_free[6 * c + 3 + k] = 0.1 * ((c + 2 * k) % 7 - 3);
      const double* const axis = contact.frame[(k + 1) % 3];
      for (int x = 0; x < 3; ++x) {
        const double moment = (1 + 0.2 * (c % 4)) * axis[x];
        entries.emplace_back(6 * contact.i + 3 + x, 6 * c + 3 + k, moment);
        if (contact.j == spheres.surroundings()) continue;
        entries.emplace_back(6 * contact.j + 3 + x, 6 * c + 3 + k, -moment);
      }
    }
  }
  p.H = from_triplets(plain.num_dofs(), p.num_rows(), entries);
  return p;
}

struct Setting {
  ContactProblem problem;
  DelassusOperator delassus{problem};
  ContactScaling scaling = equilibrated_scaling(problem, delassus.diagonal());
  const DiskStructure& disks() const { return *delassus.disks(); }
  std::optional<DiskStructure> rolling = rolling_bodies<kRollingDisks>(problem);
  std::optional<SphereStructure> rolling_in_space = rolling_bodies<kRollingSpheres>(problem);
  template <int D>
  const BodiesOf<D>& bodies() const {
    if constexpr (D == kRollingDisks) {
      return *rolling;
    } else if constexpr (D == kRollingSpheres) {
      return *rolling_in_space;
    } else {
      return *delassus.bodies<D>();
    }
  }
  Vector zero() const { return Vector::Zero(problem.num_rows()); }
  double largest_eigenvalue() const {
    WholeSpace space(problem);
    return spectral_estimate(space, scaling.velocity);
  }
};

template <int D>
Vector swept(const Setting& at, double omega, const Execution& execution,
             const std::vector<int>& portions) {
  TiledSweep<D> sweep(at.problem, at.bodies<D>(), at.scaling, omega, execution);
  sweep.reset(at.zero());
  for (const int sweeps : portions) sweep.advance(sweeps);
  return sweep.impulse();
}

template <int D>
Vector descended(const Setting& at, GradientMap map, const Execution& execution,
                 const std::vector<int>& portions) {
  TiledGradient<D> gradient(at.problem, at.bodies<D>(), at.scaling, execution);
  gradient.reset(at.zero());
  GradientKernel::Control control;
  // Too small on purpose: it is raised on the way.
  control.lambda = 0.8 * at.largest_eigenvalue();
  control.map = map;
  for (const int iterations : portions) gradient.advance(iterations, control);
  if (map == GradientMap::kFollowed) {
    gradient.follow(0.7);
    for (const int iterations : portions) gradient.advance(iterations, control);
  }
  return gradient.impulse();
}

const std::vector<int> kOneByOne(40, 1), kTogether{40}, kMixed{1, 2, 20, 7, 10};

/// Of few bodies a side many lanes are empty. Cannonballs have normals along no axis.
template <int D>
std::vector<ContactProblem> packings() {
  if constexpr (D == 3) {
    return {packing(3, true, 9),          packing(3, true, 2),
            packing(3, true, 1),          packing(3, true, 4),
            pressed(packing(3, true, 6)), shipped_file("3d_sphere_pyramid_4.hdf5")};
  } else if constexpr (D == kRollingSpheres) {
    return {rolling_spheres(packing(3, true, 9)), rolling_spheres(packing(3, true, 2)),
            rolling_spheres(packing(3, true, 1)),
            rolling_spheres(shipped_file("3d_sphere_pyramid_4.hdf5"))};
  } else if constexpr (D == kRollingDisks) {
    return {rolling_packing(false, 20), rolling_packing(true, 20), rolling_packing(true, 2),
            rolling_packing(false, 5)};
  } else {
    return {packing(D),           packing(D, true),    packing(D, true, 2),
            packing(D, false, 5), packing(D, true, 7), pressed(packing(D, true, 12))};
  }
}

template <int D>
void check_bits() {
  for (const ContactProblem& problem : packings<D>()) {
    const Setting at{problem};
    ASSERT_TRUE(at.delassus.is_packed() || at.rolling || at.rolling_in_space);
    const Vector sweep = swept<D>(at, 1, {1, SimdPath::kPortable}, kOneByOne);
    const Vector relaxed = swept<D>(at, 1.5, {1, SimdPath::kPortable}, kOneByOne);
    const Vector split = descended<D>(at, GradientMap::kSplit, {1, SimdPath::kPortable}, kOneByOne);
    const Vector followed =
        descended<D>(at, GradientMap::kFollowed, {1, SimdPath::kPortable}, kOneByOne);
    ASSERT_GT(split.norm(), 0);
    for (const SimdPath path : kPaths) {
      if (!has_path(path)) continue;
      for (int threads = 1; threads <= 4; ++threads) {
        const Execution e{threads, path};
        const std::string where = std::string(to_string(path)) + ", threads " +
                                  std::to_string(threads) + ", contacts " +
                                  std::to_string(problem.num_contacts());
        const std::vector<int>& portions = threads % 2 == 0 ? kMixed : kTogether;
        EXPECT_TRUE(same_bits(swept<D>(at, 1, e, portions), sweep)) << where;
        EXPECT_TRUE(same_bits(swept<D>(at, 1.5, e, portions), relaxed)) << where;
        EXPECT_TRUE(same_bits(descended<D>(at, GradientMap::kSplit, e, portions), split)) << where;
        EXPECT_TRUE(same_bits(descended<D>(at, GradientMap::kFollowed, e, portions), followed))
            << where;
      }
    }
  }
}

TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsWithFriction) { check_bits<2>(); }
TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsWithoutFriction) { check_bits<1>(); }
TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsOfSpheres) { check_bits<3>(); }
TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsOfRollingDisks) {
  check_bits<kRollingDisks>();
}
TEST(TiledKernels, SameBitsForAllThreadsPathsAndPortionsOfRollingSpheres) {
  check_bits<kRollingSpheres>();
}

/// Updates of the impulses of contacts one by one, by W: the normal one, then the slip, then the
/// rolling and the spin, each with the velocities that the one before left in its own contact; ω
/// alike. `back`: the slip comes last. The normal row is not coupled to the others of its contact.
class OneByOne {
 public:
  OneByOne(const ContactProblem& p, double omega)
      : p_(p),
        omega_(omega),
        W_(Eigen::MatrixXd(assemble_delassus(p.A, p.H, p.dim))),
        s_(Vector::Zero(p.num_rows())) {}
  void relax(int c, bool back = false) {
    if (c < 0) return;
    const int first = p_.dim * c, slips = p_.plain_dim() - 1;
    s_[first] = std::max(moved(first, 1)[0], 0.0);
    const auto slide = [&] { cut(first, 1, slips, p_.mu[c]); };
    if (!back) slide();
    cut(first, 1 + slips, slips, p_.mu_r[c]);
    if (p_.dim == 6) cut(first, 5, 1, p_.mu_spin[c]);
    if (back) slide();
  }
  const Vector& impulse() const { return s_; }

 private:
  Vector moved(int row, int count) const {
    const Vector u = W_.middleRows(row, count) * s_ + p_.u_free.segment(row, count);
    return s_.segment(row, count) - omega_ / W_(row, row) * u;
  }
  void cut(int first, int row, int count, double mu) {
    const Vector trial = moved(first + row, count);
    const double bound = mu * s_[first];
    s_.segment(first + row, count) = trial * std::min(1.0, bound / std::max(trial.norm(), 1e-300));
  }

  const ContactProblem& p_;
  double omega_;
  Eigen::MatrixXd W_;
  Vector s_;
};

/// Relaxes the contacts of all tiles so many times, from both ends to the middle.
template <class Relax>
void sweep_in_order(const ContactTiles& tiles, int sweeps, const Relax& relax) {
  const auto each_of = [&](int tile) {
    const ContactTiles::Tile& of = tiles.tiles[to_size(tile)];
    for (int lane = of.first_batch * kLanes; lane < of.last_batch * kLanes; ++lane) {
      const int c = tiles.contact[to_size(lane)];
      if (c >= 0) relax(c);
    }
  };
  const auto num_tiles = static_cast<int>(tiles.tiles.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (int tile = 0; tile < num_tiles / 2; ++tile) each_of(tile);
    for (int tile = num_tiles - 1; tile >= num_tiles / 2; --tile) each_of(tile);
  }
}

template <int D>
void check_tiled_sweep(const ContactProblem& problem) {
  for (const double omega : {1.0, 1.4}) {
    const Setting at{problem};
    const ContactTiles tiles = tile_contacts(at.bodies<D>());
    OneByOne sweep_of(at.problem, omega);
    sweep_in_order(tiles, 20, [&](int c) { sweep_of.relax(c); });
    const Vector tiled = swept<D>(at, omega, {}, {20});
    EXPECT_LT((tiled - sweep_of.impulse()).norm(), 1e-11 * tiled.norm()) << omega;
  }
}
TEST(TiledKernels, ATiledSweepWithRollingFrictionIsThatOnWInItsOrder) {
  check_tiled_sweep<kRollingDisks>(rolling_packing(false, 8));
  check_tiled_sweep<kRollingSpheres>(rolling_spheres(packing(3, true, 4)));
}

// The sweep back is the sweep forth in the reverse order, the rows of friction and rolling too; so
// that an iteration of one sweep each way has these two.
template <int D>
void check_symmetric_sweep(const ContactProblem& problem) {
  const Setting at{problem};
  const ContactTiles tiles = symmetric_order(at.bodies<D>());
  OneByOne sweep_of(at.problem, 1.3);
  const auto lanes = static_cast<int>(tiles.contact.size());
  for (int sweep = 0; sweep < 10; ++sweep) {
    for (int k = 0; k < lanes; ++k) sweep_of.relax(tiles.contact[to_size(k)], false);
    for (int k = lanes - 1; k >= 0; --k) sweep_of.relax(tiles.contact[to_size(k)], true);
  }
  SymmetricSweep<D> kernel(at.problem, at.bodies<D>(), at.scaling, 1.3, 1, {});
  kernel.reset(at.zero());
  for (int k = 0; k < 10; ++k) kernel.iterate(0);
  EXPECT_LT((kernel.impulse() - sweep_of.impulse()).norm(), 1e-11 * kernel.impulse().norm());
}
TEST(TiledKernels, ASymmetricSweepWithRollingFrictionIsThatOnW) {
  check_symmetric_sweep<kRollingDisks>(rolling_packing(true, 6));
  check_symmetric_sweep<kRollingSpheres>(rolling_spheres(packing(3, true, 4)));
}

// The tiled sweep is a Gauss-Seidel sweep in its own order: the scalar sweep in that order does the
// same to rounding.
TEST(TiledKernels, ATiledSweepIsTheScalarSweepInItsOrder) {
  const Setting at{packing(2)};
  const ContactTiles tiles = tile_contacts(at.disks());
  DiskSweep<2> scalar(at.problem, at.disks());
  const Vector diagonal = at.delassus.diagonal();
  scalar.reset(at.zero());
  for (int c = 0; c < at.problem.num_contacts(); ++c) {
    scalar.set_steps(c, Local<2>(1.2 / diagonal[2 * c], 1.2 / diagonal[2 * c + 1]),
                     at.problem.mu[c]);
  }
  sweep_in_order(tiles, 20, [&](int c) { scalar.relax(c); });
  const Vector s = swept<2>(at, 1.2, {}, {20});
  EXPECT_LT((s - scalar.impulse()).norm(), 1e-12 * s.norm());
}

// The given order in vectors is that of contact after contact: a body meets its contacts in turn.
TEST(TiledKernels, TheGivenOrderIsContactAfterContact) {
  const Setting at{packing(3, true, 6)};
  TwoPassSweep<3, 6> general(at.problem);
  general.reset(at.zero());
  LocalUpdates<3> update(at.problem, at.delassus, {});
  for (int sweep = 0; sweep < 40; ++sweep) {
    for (int c = 0; c < at.problem.num_contacts(); ++c) update(c, general);
  }
  TiledSweep<3> sweep(at.problem, at.bodies<3>(), at.scaling, 1, {}, given_order(at.bodies<3>()));
  sweep.reset(at.zero());
  sweep.advance(40);
  const Vector& s = sweep.impulse();
  EXPECT_LT((s - general.impulse()).norm(), 1e-10 * s.norm());
}

// For spheres, contact after contact by the general sweep: the block of W of a contact is diagonal,
// so that one round of projections is the same as the kernel's exact solution.
void check_sweep_of_spheres(const ContactProblem& problem) {
  const Setting at{problem};
  const ContactTiles tiles = tile_contacts(at.bodies<3>());
  TwoPassSweep<3, 6> general(at.problem);
  general.reset(at.zero());
  LocalUpdates<3> update(at.problem, at.delassus, {.omega = 1.2});
  ASSERT_GT(tiles.tiles.size(), 1u);
  sweep_in_order(tiles, 40, [&](int c) { update(c, general); });
  const Vector s = swept<3>(at, 1.2, {}, {40});
  EXPECT_LT((s - general.impulse()).norm(), 1e-10 * s.norm());
}
TEST(TiledKernels, ATiledSweepOfSpheresIsTheGeneralSweepInItsOrder) {
  check_sweep_of_spheres(packing(3, true, 6));
  check_sweep_of_spheres(pressed(packing(3, true, 6)));
}

/// The same iterates as through the Delassus operator, restarts and raised eigenvalues among them.
template <ContactRows D>
void check_gradient(const ContactProblem& problem) {
  for (const GradientMap map : {GradientMap::kSplit, GradientMap::kFollowed}) {
    const Setting at{problem};
    WholeSpace space(at.problem);
    SpaceSums sums{space};
    GradientIteration<D, SpaceSums> plain(at.problem, sums, at.scaling);
    plain.reset(at.zero());
    GradientKernel::Control control{.lambda = 0.8 * at.largest_eigenvalue(), .map = map};
    plain.advance(40, control);
    if (map == GradientMap::kFollowed) {
      plain.follow(0.7);
      plain.advance(40, control);
    }
    const Vector s = descended<kKernelOf<D>>(at, map, {}, {40});
    EXPECT_LT((s - plain.impulse()).norm(), 1e-10 * s.norm());
  }
}

TEST(TiledKernels, ATiledGradientStepIsThatOfTheDelassusOperator) {
  check_gradient<2>(packing(2, false, 7));
  check_gradient<2>(pressed(packing(2, false, 7)));
}
TEST(TiledKernels, ATiledGradientStepOfRollingDisksIsThatOfTheDelassusOperator) {
  check_gradient<ContactRows(3, true)>(rolling_packing(false, 7));
  check_gradient<ContactRows(3, true)>(rolling_packing(true, 7));
}
TEST(TiledKernels, ATiledGradientStepOfRollingSpheresIsThatOfTheDelassusOperator) {
  check_gradient<ContactRows(6, true)>(rolling_spheres(packing(3, true, 5)));
  check_gradient<ContactRows(6, true)>(rolling_spheres(shipped_file("3d_sphere_pyramid_4.hdf5")));
}
TEST(TiledKernels, ATiledGradientStepOfSpheresIsThatOfTheDelassusOperator) {
  check_gradient<3>(packing(3, true, 5));
  check_gradient<3>(pressed(packing(3, true, 5)));
  check_gradient<3>(shipped_file("3d_sphere_pyramid_4.hdf5"));
}

// Whole solves. Few iterations: on a busy machine threads wait for each other at every wave.
TEST(TiledKernels, SolversReturnTheSameBitsForAllThreads) {
  const ContactProblem p = packing(2);
  for (const auto& [solver, parameters] :
       std::vector<std::pair<std::string, std::map<std::string, std::string>>>{
           {"pgs", {{"order", "tiled"}, {"omega", "1.7"}}}, {"apgd", {}}}) {
    SolverOptions options{.tol = 1e-6, .max_iterations = 50, .parameters = parameters};
    const SolveResult one = ended(SolveStatus::kIterationLimit, solve(solver, p, options));
    for (options.execution.threads = 2; options.execution.threads <= 4;
         ++options.execution.threads) {
      const SolveResult many = solve(solver, p, options);
      EXPECT_TRUE(same_bits(many.s, one.s)) << solver << options.execution.threads;
      EXPECT_EQ(many.iterations, one.iterations);
    }
  }
}

TEST(TiledKernels, TheTiledOrderNeedsAsManySweepsAsTheGivenOne) {
  for (const bool square : {false, true}) {
    const ContactProblem p = packing(2, square);
    SolverOptions options{.tol = 1e-6};
    const SolveResult given = solve("pgs", p, options);
    options.parameters = {{"order", "tiled"}};
    const SolveResult tiled = solve("pgs", p, options);
    ASSERT_EQ(given.status, SolveStatus::kConverged) << given.message;
    ASSERT_EQ(tiled.status, SolveStatus::kConverged) << tiled.message;
    EXPECT_LT(tiled.iterations, 1.15 * given.iterations) << square;
  }
}

}  // namespace
}  // namespace bipot
