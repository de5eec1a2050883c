// Compares all available factorisations of the linear systems of the interior point. The systems
// are K = A + H R Hᵀ of early, middle and late iterations, the same for all. Columns: analysis,
// factor and one solve in CPU seconds of one thread (median of --repeat); numbers kept; the
// backward error of the solution, ‖K x - b‖ / (‖K‖ ‖x‖ + ‖b‖), for Cholesky that of leaving out the
// unsymmetric part (and, for `admm`, of single precision). Prints tables in Markdown
// (data/manual/results/performance.md).
//   factor_bench [--family=triangular,square] [--side=83] [--at=2,6,10] [--repeat=3]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#ifdef BIPOT_WITH_PETSC
#include <petscksp.h>

#include "solvers/petsc/petsc_session.h"
#endif

#include "bench/command/blas_kernels.h"
#include "bench/measure/iteration_growth.h"
#include "core/linear/frontal_cholesky.h"
#include "core/linear/frontal_lu.h"
#include "core/linear/sparse_factor.h"
#include "solvers/interior/equal_product_start.h"
#include "solvers/interior/interior_run.h"
#include "solvers/interior/interior_state.h"
#include "solvers/interior/proximal_interior_point.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

/// A matrix of an interior point, and the same without the coupling of the tangent to the normal
/// (the lower left of each block of R), which is symmetric.
struct System {
  SparseMatrix K, symmetric;
  int iterations = 0;
  double error = 0;
};

/// The system after `iterations` of the proximal interior point from its own start.
System system_of(const ContactProblem& p, int iterations) {
  const SolverOptions options{.tol = 1e-14, .max_iterations = iterations};
  SolveRun solve(p, options);
  solve.judge_every_iteration();
  InteriorSystem<2> system(p, solve.delassus(), ShiftedDelassus::Form::kBody);
  EqualProductStart starts{system};
  InteriorRun run(solve);
  ProximalInteriorPointOptions stage{.far_iterations = iterations};
  InteriorState<2> z = starts.cold(starts.spring_energy(), 1), best = z;
  (void)ProximalInteriorPoint{system, run}(z, stage, best);
  if (!system.linearise(z, 0)) throw std::runtime_error("the matrix is singular");
  System out{
      .K = system.shifted().matrix(), .iterations = run.iteration, .error = solve.last_error()};
  std::vector<double> R = system.shifted().blocks();
  for (std::size_t k = 0; k < R.size(); k += 4) R[k + 1] = R[k + 2] = 0;
  if (!system.shifted().factor(R)) throw std::runtime_error("the symmetric matrix is singular");
  out.symmetric = system.shifted().matrix();
  return out;
}

/// One way to factor. If `analyse` is empty the first factor() analyses as well. solve: x of b.
struct Method {
  std::string name;
  std::function<bool()> analyse, factor;
  std::function<void(const Vector&, Vector&)> solve;
  std::function<std::size_t()> entries;
};

double backward_error(const SparseMatrix& K, const Vector& x, const Vector& b) {
  return (K * x - b).norm() / (K.norm() * x.norm() + b.norm());
}

double seconds_of(int repeat, const std::function<bool()>& run, bool& fine) {
  std::vector<double> seconds;
  for (int k = 0; k < repeat; ++k) {
    const std::clock_t before = std::clock();
    fine = run() && fine;
    seconds.push_back(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
  }
  std::nth_element(seconds.begin(), seconds.begin() + repeat / 2, seconds.end());
  return seconds[static_cast<std::size_t>(repeat / 2)];
}

void row(const Method& method, const System& system, int repeat) {
  bool fine = true;
  double analysis = method.analyse ? seconds_of(1, method.analyse, fine) : 0;
  // The first call allocates memory too.
  const double first = fine ? seconds_of(1, method.factor, fine) : 0;
  const double factor = fine ? seconds_of(repeat, method.factor, fine) : 0;
  if (!fine) {
    fmt::print("| {} | | fails | | | |\n", method.name);
    return;
  }
  if (!method.analyse) analysis = first - factor;
  const Vector b = system.K * Vector::LinSpaced(system.K.cols(), -1, 1);
  Vector x;
  const double solve = seconds_of(
      std::max(repeat, 5),
      [&] {
        method.solve(b, x);
        return true;
      },
      fine);
  fmt::print("| {} | {:.3f} | {:.4f} | {:.4f} | {:.1f} | {:.0e} |\n", method.name, analysis, factor,
             solve, 1e-6 * static_cast<double>(method.entries()), backward_error(system.K, x, b));
  std::fflush(stdout);
}

/// One of this project's factorisations; the fronts analyse in a step of their own.
template <class Factor, class... Arguments>
Method by(std::string name, const SparseMatrix& K, bool fronts, Arguments... arguments) {
  auto factor = std::make_shared<Factor>(arguments...);
  Method method{.name = std::move(name),
                .factor = [&K, factor] { return factor->factor(K); },
                .entries = [factor] { return factor->num_entries(); }};
  if (fronts)
    method.analyse = [&K] {
      FrontalTree::analyse(K);
      return true;
    };
  method.solve = [factor](const Vector& b, Vector& x) {
    if constexpr (requires { factor->solve(b, x); }) {
      factor->solve(b, x);
    } else {
      x = factor->solve(b);
    }
  };
  return method;
}

#ifdef BIPOT_WITH_PETSC
/// MUMPS through PETSc, in METIS's order.
struct Mumps {
  SparseRows rows;
  ::Mat matrix = nullptr, factor = nullptr;
  ::Vec b = nullptr, x = nullptr;
  MatFactorInfo info;

  explicit Mumps(const SparseMatrix& K) : rows(K) {
    const auto n = static_cast<PetscInt>(rows.rows());
    check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, rows.outerIndexPtr(),
                                          rows.innerIndexPtr(), rows.valuePtr(), &matrix),
                "MatCreateSeqAIJWithArrays");
    check_petsc(MatCreateVecs(matrix, &x, &b), "MatCreateVecs");
    check_petsc(MatFactorInfoInitialize(&info), "MatFactorInfoInitialize");
  }
  ~Mumps() {
    MatDestroy(&factor);
    MatDestroy(&matrix);
    VecDestroy(&b);
    VecDestroy(&x);
  }
  Mumps(const Mumps&) = delete;
  Mumps& operator=(const Mumps&) = delete;

  bool analyse() {
    check_petsc(MatGetFactor(matrix, MATSOLVERMUMPS, MAT_FACTOR_LU, &factor), "MatGetFactor");
    check_petsc(MatMumpsSetIcntl(factor, 7, 5), "MatMumpsSetIcntl");     // METIS
    check_petsc(MatMumpsSetIcntl(factor, 14, 200), "MatMumpsSetIcntl");  // room for exchanges
    check_petsc(MatLUFactorSymbolic(factor, matrix, nullptr, nullptr, &info),
                "MatLUFactorSymbolic");
    return true;
  }
  bool numeric() {
    check_petsc(MatLUFactorNumeric(factor, matrix, &info), "MatLUFactorNumeric");
    PetscInt status = 0;
    check_petsc(MatMumpsGetInfog(factor, 1, &status), "MatMumpsGetInfog");
    return status == 0;
  }
  void solve(const Vector& right, Vector& out) {
    PetscScalar* data = nullptr;
    check_petsc(VecGetArray(b, &data), "VecGetArray");
    std::copy(right.begin(), right.end(), data);
    check_petsc(VecRestoreArray(b, &data), "VecRestoreArray");
    check_petsc(MatSolve(factor, b, x), "MatSolve");
    check_petsc(VecGetArray(x, &data), "VecGetArray");
    out = Eigen::Map<const Vector>(data, right.size());
    check_petsc(VecRestoreArray(x, &data), "VecRestoreArray");
  }
  std::size_t entries() {
    PetscInt millions = 0;
    check_petsc(MatMumpsGetInfog(factor, 29, &millions), "MatMumpsGetInfog");
    return millions < 0 ? to_size(-millions) * 1000000 : to_size(millions);
  }
};

Method by_mumps(const SparseMatrix& K) {
  auto mumps = std::make_shared<Mumps>(K);
  return {"MUMPS through PETSc, METIS", [mumps] { return mumps->analyse(); },
          [mumps] { return mumps->numeric(); },
          [mumps](const Vector& b, Vector& x) { mumps->solve(b, x); },
          [mumps] { return mumps->entries(); }};
}
#endif

void table(const std::string& family, int side, int at, int repeat) {
  const GrowthScene::Problem made =
      make_growth_problem({.family = family, .tilt_degrees = 10}, side);
  const System system = system_of(made.problem, at);
  fmt::print(
      "\n**{} {}**, {} contacts, {} unknowns, {} numbers in K, after {} iterations (error {:.0e})\n\n",
      family, side, made.problem.num_contacts(), system.K.cols(), system.K.nonZeros(),
      system.iterations, system.error);
  fmt::print(
      "| | analysis [s] | factor [s] | solve [s] | numbers kept [10⁶] | backward error |\n"
      "| --- | --- | --- | --- | --- | --- |\n");
  row(by<FrontalLU>("fronts (`ipm`)", system.K, true), system, repeat);
  row(by<SparseLU>(SparseLU::library(), system.K, false, SparseLU::Strategy::kSymmetric), system,
      repeat);
#ifdef BIPOT_WITH_PETSC
  row(by_mumps(system.K), system, repeat);
#endif
  row(by<FrontalCholesky>("fronts (`admm`), Cholesky of the symmetric part", system.symmetric,
                          true),
      system, repeat);
  row(by<SparseCholesky>("CHOLMOD of the symmetric part", system.symmetric, false), system, repeat);
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  using namespace bipot;
  std::vector<std::string> families{"triangular", "square"};
  std::vector<int> sides{83}, at{2, 6, 10};
  int repeat = 3;
  CLI::App app{"The interior point's matrices by every factorisation at hand"};
  app.add_option("--family", families, "Scene families in the plane, pile among them")
      ->delimiter(',');
  app.add_option("--side", sides, "Disks along a side")->delimiter(',');
  app.add_option("--at", at, "Iterations of the interior point before")->delimiter(',');
  app.add_option("--repeat", repeat, "Factorisations of which the median is taken")
      ->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  try {
#ifdef BIPOT_WITH_PETSC
    const PetscSession session(bipot::PetscOptions("", ""));
#endif
    for (const std::string& family : families) {
      for (const int side : sides) {
        for (const int k : at) table(family, side, k, repeat);
      }
    }
  } catch (const std::exception& e) {
    fmt::print(stderr, "factor_bench: {}\n", e.what());
    return 4;
  }
  return 0;
}
