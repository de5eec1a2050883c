// Prints a hash of the bits of what kernels and criterion compute. Every processor and compiler must
// print the same (arm64.sh). No HDF5, no factorisation, no functions like sin().

#include <cstdio>
#include <vector>

#include "core/criterion/contact_error.h"
#include "core/criterion/rounding_bound.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "solvers/disks/tiled_gradient.h"
#include "solvers/disks/tiled_sweep.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/local_coulomb.h"
#include "tests/support/bit_hash.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/random_vector.h"

namespace bipot {
namespace {

void print(const char* what, int dim, const BitHash& hash) {
  std::printf("%-28s d=%d %016llx\n", what, dim, static_cast<unsigned long long>(hash.value()));
}

template <int D>
void local_problems() {
  PortableRandom draw(7);
  BitHash projections, solutions, rounds;
  for (int k = 0; k < 2000; ++k) {
    const double mu = draw.uniform();
    Local<D> x, q, s;
    Eigen::MatrixXd B(D, D);
    for (int i = 0; i < D; ++i) {
      x[i] = draw.symmetric();
      q[i] = draw.symmetric();
      s[i] = 0;
      for (int j = 0; j < D; ++j) B(i, j) = draw.symmetric();
    }
    const Local<D> on_cone = onto_cone<D>(x, mu);
    Eigen::MatrixXd w(D, D);
    for (int i = 0; i < D; ++i) {
      for (int j = 0; j < D; ++j) {
        w(i, j) = i == j ? 0.1 : 0.0;
        for (int l = 0; l < D; ++l) w(i, j) += B(i, l) * B(j, l);
      }
    }
    LocalProblem<D> local = local_problem<D>(w, mu);
    local.q = q;
    Local<D> solved = s;
    (void)solve_local<D>(local, solved);
    const Local<D> improved = improve_local<D>(local, s, q, 1.0, 5);
    for (int i = 0; i < D; ++i) {
      projections.add(on_cone[i]);
      solutions.add(solved[i]);
      rounds.add(improved[i]);
    }
  }
  print("projection on the cone", D, projections);
  print("local problem, solved", D, solutions);
  print("local problem, five rounds", D, rounds);
}

void criterion(const ContactProblem& p, const Vector& s) {
  const ContactError e = contact_error(p, s);
  BitHash hash;
  for (const double x : {e.epsilon, e.eta, e.raw42, e.natural_map, e.friction_power, e.energy}) {
    hash.add(x);
  }
  print("criterion", p.dim, hash);
  BitHash bounds;
  for (const Precision precision : {Precision::kDouble, Precision::kQuadruple}) {
    const RoundingBound bound = rounding_bound(p, s, precision);
    bounds.add(bound.epsilon);
    bounds.add(bound.eta);
  }
  print("bound of its rounding", p.dim, bounds);
}

template <int D>
void sweeps(const ContactProblem& p) {
  const DelassusOperator delassus(p);
  const BodiesOf<D>& bodies = *delassus.bodies<D>();
  const ContactScaling scaling = equilibrated_scaling(p, delassus.diagonal());
  const Vector zero = Vector::Zero(p.num_rows());
  TiledSweep<D> sweep(p, bodies, scaling, 1.5, {});
  sweep.reset(zero);
  sweep.advance(40);
  BitHash swept;
  swept.add(sweep.impulse());
  print("tiled sweeps", D, swept);
  for (const GradientMap map : {GradientMap::kSplit, GradientMap::kFollowed}) {
    TiledGradient<D> gradient(p, bodies, scaling, {});
    gradient.reset(zero);
    GradientKernel::Control control{.lambda = 2, .map = map};
    gradient.advance(40, control);
    const bool followed = map == GradientMap::kFollowed;
    if (followed) {
      gradient.follow(0.7);
      gradient.advance(40, control);
    }
    BitHash hash;
    hash.add(gradient.impulse());
    print(followed ? "gradient, followed map" : "gradient, split map", D, hash);
  }
  criterion(p, sweep.impulse());
}

}  // namespace
}  // namespace bipot

int main() {
  using namespace bipot;
  local_problems<2>();
  local_problems<3>();
  LatticeOptions options;
  sweeps<2>(triangular_lattice(12, options));
  options.dim = 1;
  sweeps<1>(square_lattice(12, options));
  const ContactProblem spheres = cubic_lattice(4);
  sweeps<3>(spheres);
  criterion(spheres, random_vector(spheres.num_rows(), 5));
}
