#include "solvers/methods/newton_snes.h"

#include <fmt/format.h>
#include <petscsnes.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/linear/dense_turn.h"
#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/petsc/newton_system.h"
#include "solvers/petsc/petsc_session.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

static_assert(std::is_same_v<PetscScalar, double>, "PETSc with real double scalars is needed");

constexpr const char* kPrefix = "bipot_newton_";

/// Data of the callbacks.
struct NewtonRun {
  NewtonSystem* system = nullptr;
  SolveRun* solve = nullptr;
  DenseTurn* turn = nullptr;   // of the running proximal step
  int iterations = 0;          // Newton steps of all proximal steps
  std::vector<Vector> recent;  // last iterates of this proximal step, the oldest is overwritten
  bool stop = false;           // the solve is over
  double first_norm = 0;       // residual at the start of the proximal step
};

// Residual of one proximal step, relative to the effect of its proximal term.
constexpr double kForcing = 0.1;
// Residuals are of size one; below this only rounding remains.
constexpr double kResidualFloor = 1e-15;
// Nonsmooth Newton cycles between active sets; longest period that is recognised.
constexpr std::size_t kLongestCycle = 6;
// Rows up to which PETSc's LU (nested dissection, no pivoting) is used in place of UMFPACK, which
// is quicker beyond.
constexpr int kDenseRows = 4000;
// Rows up to which UMFPACK uses AMD in place of METIS.
constexpr int kNestedRows = 200000;
// Two iterates that differ by less, relative, count as equal.
constexpr double kSame = 1e-13;
// A repeated iterate with a residual this small, relative to the first one or to the impulses, is a
// solution at round-off.
constexpr double kSolvedAtRoundOff = 1e-8, kRounding = 1e-13;

PetscErrorCode form_function(SNES, ::Vec z, ::Vec f, void* context) {
  const auto* run = static_cast<NewtonRun*>(context);
  const PetscScalar* in = nullptr;
  PetscScalar* out = nullptr;
  PetscCall(VecGetArrayRead(z, &in));
  PetscCall(VecGetArray(f, &out));
  run->system->residual(in, out);
  PetscCall(VecRestoreArray(f, &out));
  PetscCall(VecRestoreArrayRead(z, &in));
  return 0;
}

PetscErrorCode form_jacobian(SNES, ::Vec z, ::Mat, ::Mat J, void* context) {
  const auto* run = static_cast<NewtonRun*>(context);
  const PetscScalar* in = nullptr;
  PetscScalar* values = nullptr;
  PetscCall(VecGetArrayRead(z, &in));
  PetscCall(MatSeqAIJGetArray(J, &values));
  run->system->jacobian(in, values);
  PetscCall(MatSeqAIJRestoreArray(J, &values));
  PetscCall(VecRestoreArrayRead(z, &in));
  PetscCall(MatAssemblyBegin(J, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(J, MAT_FINAL_ASSEMBLY));
  return 0;
}

PetscErrorCode test_convergence(SNES snes, PetscInt iteration, PetscReal, PetscReal, PetscReal norm,
                                SNESConvergedReason* reason, void* context) {
  auto* run = static_cast<NewtonRun*>(context);
  *reason = SNES_CONVERGED_ITERATING;
  if (!std::isfinite(norm)) {
    *reason = SNES_DIVERGED_FNORM_NAN;
    return 0;
  }
  ::Vec z = nullptr;
  const PetscScalar* values = nullptr;
  PetscCall(SNESGetSolution(snes, &z));
  PetscCall(VecGetArrayRead(z, &values));
  const double target = kForcing * run->system->proximal_residual(values);
  const double size = run->system->scaled_impulse(values).norm();
  Vector s = run->system->impulse(values);
  PetscCall(VecRestoreArrayRead(z, &values));
  if (iteration == 0) {
    run->first_norm = norm;
    run->recent.clear();
  } else {
    ++run->iterations;
    // A repeated iterate goes to the outer loop, which changes kappa: to the run it would be the
    // end.
    bool repeated = false;
    for (const Vector& old : run->recent) repeated |= (s - old).norm() <= kSame * s.norm();
    if (repeated) {
      *reason = norm <= std::max({kSolvedAtRoundOff * run->first_norm, target, kRounding * size})
                    ? SNES_CONVERGED_SNORM_RELATIVE
                    : SNES_DIVERGED_LOCAL_MIN;
      return 0;
    }
    if (run->turn->outside(
            [&] { return run->solve->stop(run->iterations, s, run->system->kappa()); })) {
      run->stop = true;
      *reason = SNES_CONVERGED_FNORM_ABS;
      return 0;
    }
    if (norm <= target) *reason = SNES_CONVERGED_FNORM_RELATIVE;
  }
  if (norm <= kResidualFloor) *reason = SNES_CONVERGED_FNORM_ABS;
  if (run->recent.size() < kLongestCycle) {
    run->recent.push_back(std::move(s));
  } else {
    run->recent[to_size(iteration) % kLongestCycle] = std::move(s);
  }
  return 0;
}

/// A SystemFactor as PETSc's preconditioner. PETSc is C: exceptions of the factor are kept, and
/// PETSc gets an error code.
class FactorElsewhere {
 public:
  explicit FactorElsewhere(SystemFactor& factor) : factor_(factor) {}

  void attach_to(PC pc) {
    BIPOT_PETSC(PCSetType, pc, PCSHELL);
    BIPOT_PETSC(PCShellSetContext, pc, this);
    BIPOT_PETSC(PCShellSetSetUp, pc, set_up);
    BIPOT_PETSC(PCShellSetApply, pc, apply);
  }
  void rethrow() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  static FactorElsewhere& of(PC pc) {
    void* self = nullptr;
    PCShellGetContext(pc, &self);
    return *static_cast<FactorElsewhere*>(self);
  }
  static PetscErrorCode set_up(PC pc) {
    ::Mat J = nullptr;
    PetscCall(PCGetOperators(pc, nullptr, &J));
    PetscInt n = 0;
    const PetscInt *starts = nullptr, *columns = nullptr;
    const PetscScalar* values = nullptr;
    PetscBool done = PETSC_FALSE;
    PetscCall(MatGetRowIJ(J, 0, PETSC_FALSE, PETSC_FALSE, &n, &starts, &columns, &done));
    PetscCall(MatSeqAIJGetArrayRead(J, &values));
    const int failed = of(pc).guarded([&](FactorElsewhere& self) {
      self.columns_ = Eigen::Map<const SparseRows>(n, n, starts[n], starts, columns, values);
      self.factored_ = self.factor_.factor(self.columns_);
      PCSetFailedReason(pc, self.factored_ ? PC_NOERROR : PC_FACTOR_NUMERIC_ZEROPIVOT);
    });
    PetscCall(MatSeqAIJRestoreArrayRead(J, &values));
    PetscCall(MatRestoreRowIJ(J, 0, PETSC_FALSE, PETSC_FALSE, &n, &starts, &columns, &done));
    return failed;
  }
  static PetscErrorCode apply(PC pc, ::Vec right, ::Vec solution) {
    const PetscScalar* in = nullptr;
    PetscScalar* out = nullptr;
    PetscCall(VecGetArrayRead(right, &in));
    PetscCall(VecGetArray(solution, &out));
    const int failed = of(pc).guarded([&](FactorElsewhere& self) {
      const Eigen::Index n = self.columns_.rows();
      if (!self.factored_) {  // PETSc applies first and asks for the reason afterwards
        Eigen::Map<Vector>(out, n).setConstant(kInfinity);
        return;
      }
      self.right_ = Eigen::Map<const Vector>(in, n);
      self.factor_.solve(self.right_, self.solution_);
      Eigen::Map<Vector>(out, n) = self.solution_;
    });
    PetscCall(VecRestoreArray(solution, &out));
    PetscCall(VecRestoreArrayRead(right, &in));
    return failed;
  }

  template <class Work>
  PetscErrorCode guarded(const Work& work) {
    try {
      work(*this);
      return 0;
    } catch (...) {
      thrown_ = std::current_exception();
      return PETSC_ERR_LIB;
    }
  }

  SystemFactor& factor_;
  SparseMatrix columns_;
  Vector right_, solution_;
  bool factored_ = false;
  std::exception_ptr thrown_;
};

/// Owns the PETSc objects of one solve.
class Snes {
 public:
  /// `elsewhere`: null if PETSc solves the systems.
  Snes(NewtonRun& run, NewtonSystem::Residual residual, const std::string& linear,
       const std::string& line_search, int inner_iterations, SystemFactor* elsewhere)
      : Snes(run) {  // delegated: the destructor cleans up after a failure below, too
    const NewtonSystem& system = *run.system;
    const PetscInt n = system.size();
    BIPOT_PETSC(VecCreateSeq, PETSC_COMM_SELF, n, &z_);
    BIPOT_PETSC(VecDuplicate, z_, &f_);
    BIPOT_PETSC(MatCreate, PETSC_COMM_SELF, &J_);
    BIPOT_PETSC(MatSetSizes, J_, n, n, n, n);
    BIPOT_PETSC(MatSetType, J_, MATSEQAIJ);
    const std::vector<PetscInt> starts(system.row_start().begin(), system.row_start().end());
    const std::vector<PetscInt> columns(system.columns().begin(), system.columns().end());
    BIPOT_PETSC(MatSeqAIJSetPreallocationCSR, J_, starts.data(), columns.data(), nullptr);
    BIPOT_PETSC(MatSetOption, J_, MAT_NEW_NONZERO_LOCATIONS, PETSC_FALSE);

    BIPOT_PETSC(SNESCreate, PETSC_COMM_SELF, &snes_);
    BIPOT_PETSC(SNESSetOptionsPrefix, snes_, kPrefix);
    BIPOT_PETSC(SNESSetType, snes_,
                residual == NewtonSystem::Residual::kInequality ? SNESVINEWTONRSLS : SNESNEWTONLS);
    BIPOT_PETSC(SNESSetFunction, snes_, f_, form_function, &run_);
    BIPOT_PETSC(SNESSetJacobian, snes_, J_, J_, form_jacobian, &run_);
    BIPOT_PETSC(SNESSetConvergenceTest, snes_, test_convergence, &run_, nullptr);
    BIPOT_PETSC(SNESSetTolerances, snes_, 0, 0, 0, inner_iterations, PETSC_MAX_INT);
    if (residual == NewtonSystem::Residual::kInequality) {
      BIPOT_PETSC(VecDuplicate, z_, &lower_);
      BIPOT_PETSC(VecDuplicate, z_, &upper_);
      BIPOT_PETSC(VecSet, lower_, 0);
      BIPOT_PETSC(VecSet, upper_, PETSC_INFINITY);
      BIPOT_PETSC(SNESVISetVariableBounds, snes_, lower_, upper_);
    }
    SNESLineSearch search = nullptr;
    BIPOT_PETSC(SNESGetLineSearch, snes_, &search);
    BIPOT_PETSC(SNESLineSearchSetType, search, line_search.c_str());

    if (elsewhere != nullptr) elsewhere_.emplace(*elsewhere);
    choose_linear_solver(linear);
    BIPOT_PETSC(SNESSetFromOptions, snes_);
  }
  ~Snes() {
    SNESDestroy(&snes_);
    MatDestroy(&J_);
    VecDestroy(&z_);
    VecDestroy(&f_);
    VecDestroy(&lower_);
    VecDestroy(&upper_);
  }
  Snes(const Snes&) = delete;
  Snes& operator=(const Snes&) = delete;

  /// One regularised problem from its anchor.
  InnerReport solve(double kappa, const Vector& anchor, int inner_iterations) {
    InnerReport report;
    run_.system->set_proximal(kappa, anchor);
    const Vector start = run_.system->unknowns(anchor);
    set(start);
    const int before = run_.iterations;
    DenseTurn turn;
    run_.turn = &turn;
    const int failed = SNESSolve(snes_, nullptr, z_);
    if (elsewhere_) elsewhere_->rethrow();
    check_petsc(failed, "SNESSolve");
    SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
    BIPOT_PETSC(SNESGetConvergedReason, snes_, &reason);
    const PetscScalar* values = nullptr;
    BIPOT_PETSC(VecGetArrayRead, z_, &values);
    report.s = run_.system->impulse(values);
    BIPOT_PETSC(VecRestoreArrayRead, z_, &values);
    const int steps = run_.iterations - before;
    if (run_.stop) {
      report.outcome = InnerReport::Outcome::kStop;
    } else if (reason > 0) {
      report.outcome = InnerReport::Outcome::kSolved;
      report.effort = static_cast<double>(steps) / inner_iterations;
    } else {
      report.reason =
          fmt::format("SNES: {} after {} Newton steps", SNESConvergedReasons[reason], steps);
    }
    return report;
  }

 private:
  explicit Snes(NewtonRun& run) : run_(run) {}

  void choose_linear_solver(const std::string& linear) {
    KSP ksp = nullptr;
    PC pc = nullptr;
    BIPOT_PETSC(SNESGetKSP, snes_, &ksp);
    BIPOT_PETSC(KSPGetPC, ksp, &pc);
    if (elsewhere_) {
      BIPOT_PETSC(KSPSetType, ksp, KSPPREONLY);
      elsewhere_->attach_to(pc);
    } else if (linear == "gmres") {
      BIPOT_PETSC(KSPSetType, ksp, KSPGMRES);
      BIPOT_PETSC(KSPGMRESSetRestart, ksp, 100);
      BIPOT_PETSC(KSPSetTolerances, ksp, 1e-10, 0, PETSC_DEFAULT, 1000);
      BIPOT_PETSC(PCSetType, pc, PCILU);
      BIPOT_PETSC(PCFactorSetLevels, pc, 2);
      BIPOT_PETSC(PCFactorSetShiftType, pc, MAT_SHIFT_NONZERO);
    } else {
      BIPOT_PETSC(KSPSetType, ksp, KSPPREONLY);
      BIPOT_PETSC(PCSetType, pc, PCLU);
      BIPOT_PETSC(PCFactorSetMatSolverType, pc,
                  linear == "umfpack" ? MATSOLVERUMFPACK
                  : linear == "mumps" ? MATSOLVERMUMPS
                                      : MATSOLVERPETSC);
      if (linear == "petsc") {
        BIPOT_PETSC(PCFactorSetMatOrderingType, pc, MATORDERINGND);
        BIPOT_PETSC(PCFactorSetShiftType, pc, MAT_SHIFT_NONZERO);
      }
    }
  }

  void set(const Vector& start) {
    PetscScalar* values = nullptr;
    BIPOT_PETSC(VecGetArray, z_, &values);
    Eigen::Map<Vector>(values, start.size()) = start;
    BIPOT_PETSC(VecRestoreArray, z_, &values);
  }

  NewtonRun& run_;
  SNES snes_ = nullptr;
  ::Mat J_ = nullptr;
  ::Vec z_ = nullptr, f_ = nullptr, lower_ = nullptr, upper_ = nullptr;
  std::optional<FactorElsewhere> elsewhere_;
};

/// The solver's own parameters, resolved.
struct Settings {
  std::string residual_name, linear, line_search;
  NewtonSystem::Residual residual = NewtonSystem::Residual::kAlartCurnier;
  bool mixed = false;
  int start_sweeps = 0, inner_iterations = 0;
  ProximalOptions loop;
};

/// Throws std::invalid_argument for a combination that the problem does not allow.
Settings settings_for(const ContactProblem& p, const Parameters& parameters) {
  using Residual = NewtonSystem::Residual;
  Settings s;
  s.residual_name = parameters.choice("residual");
  s.residual = s.residual_name == "alart-curnier"        ? Residual::kAlartCurnier
               : s.residual_name == "fischer-burmeister" ? Residual::kFischerBurmeister
                                                         : Residual::kInequality;
  s.linear = parameters.choice("linear");
  if (s.linear == "auto") s.linear = p.num_rows() <= kDenseRows ? "petsc" : "umfpack";
  s.line_search = parameters.choice("line_search");
  s.start_sweeps = parameters.integer("start_sweeps");
  s.inner_iterations = parameters.integer("inner_iterations");
  s.loop = {.kappa = parameters.number("kappa"), .kappa_max = parameters.number("kappa_max")};

  const std::string form = parameters.choice("form");
  const bool inequality = s.residual == Residual::kInequality;
  if (inequality && p.dim != 1) {
    throw std::invalid_argument(
        fmt::format("residual snesvi is for dimension 1, the problem has {}", p.dim));
  }
  if (s.residual == Residual::kFischerBurmeister && p.rolls()) {
    throw std::invalid_argument("residual fischer-burmeister has no rolling friction");
  }
  if (form == "mixed" && inequality) {
    throw std::invalid_argument("residual snesvi has the contact form only");
  }
  if (form == "mixed" && !p.has_velocities()) {
    throw std::invalid_argument("form mixed needs A and H, the problem has W alone");
  }
  s.mixed = form == "mixed" ||
            (form == "auto" && p.has_velocities() && !inequality && s.linear != "gmres");
  return s;
}

/// Start sweeps, then the proximal loop around SNES; returns an addition to the message.
std::string iterate(SolveRun& solve, const Settings& settings, NewtonRun& run, Snes& snes) {
  const SolverOptions& options = solve.options();
  const SolveResult swept = solve.nested("pgs", options.tol, settings.start_sweeps, solve.start());
  ProximalReport report;
  if (solve.meets(swept.s)) {
    solve.end(SolveStatus::kConverged, "stop test met by the start sweeps");
  } else if (!solve.end_if_out_of_time(0)) {
    const auto inner = [&](double kappa, const Vector& anchor) {
      InnerReport r = snes.solve(kappa, anchor, settings.inner_iterations);
      if (r.outcome == InnerReport::Outcome::kSolved && solve.meets(r.s)) {
        // Between two judgements of the cadence, a proximal step ends on the solution.
        solve.end(SolveStatus::kConverged, fmt::format("{} test met after {} iterations",
                                                       to_string(options.stop), run.iterations));
        r.outcome = InnerReport::Outcome::kStop;
      } else if (r.outcome != InnerReport::Outcome::kStop &&
                 solve.end_if_out_of_time(run.iterations)) {
        r.outcome = InnerReport::Outcome::kStop;
      }
      return r;
    };
    try {
      report =
          proximal_point(settings.loop, mean_diagonal(solve.problem(), solve.delassus().diagonal()),
                         swept.s, inner, solve);
    } catch (const PetscFailure& e) {
      solve.end(SolveStatus::kNumericalFailure,
                fmt::format("{}; best error {:.2e}", e.what(), solve.best_error()));
    }
  }
  return fmt::format(
      "; {}, {} form, {}: {} start sweeps, {} Newton steps in {} proximal steps ({} failed), "
      "last kappa {:.1e}",
      settings.residual_name, settings.mixed ? "mixed" : "contact", settings.linear,
      swept.iterations, run.iterations, report.steps, report.failed, report.kappa);
}

/// On a problem with W, if the contact form needs it.
void run_newton(SolveRun& solve, const Settings& settings, PetscOptions petsc_options,
                SystemFactor* factor) {
  // Workspace of MUMPS in per cent; its default of 200 can run out.
  petsc_options.add_default("mat_mumps_icntl_14", "1000");
  const ContactProblem& p = solve.problem();
  if (settings.linear != "mumps") {
    const bool many = (settings.mixed ? p.num_dofs() : 0) + p.num_rows() > kNestedRows;
    petsc_options.add_default("mat_umfpack_ordering", many ? "METIS" : "AMD");
  }
  const PetscSession session(std::move(petsc_options));

  NewtonSystem system(p, solve.delassus().diagonal(), settings.residual, settings.mixed);
  NewtonRun run{.system = &system, .solve = &solve};
  Snes snes(run, settings.residual, settings.linear, settings.line_search,
            settings.inner_iterations, factor);
  solve.end_setup();

  if (solve.stop(0, solve.start())) return;
  solve.remark(iterate(solve, settings, run, snes));
  const std::string unused = session.unused_options();
  if (!unused.empty()) solve.remark(fmt::format("; PETSc did not use the options {}", unused));
}

/// On the same problem with W. Time of the assembly is set-up.
void run_with_delassus(SolveRun& solve, SystemFactor* factor) {
  ContactProblem p = solve.problem();
  p.W = assemble_delassus(p.A, p.H, p.dim);
  const double before = solve.seconds();
  SolverOptions options = solve.options();
  options.time_limit = solve.remaining_seconds();
  options.on_iteration = history_after(solve.options(), 0, before, /*with_start=*/true);
  WholeSpace space(p, options.execution.threads);
  SolveResult result = run_solver(solve.entry(), space, options, solve.whole().share(), factor);
  result.setup_seconds += before;
  solve.take(std::move(result));
}

}  // namespace

void solve_newton_snes(SolveRun& solve) {
  const ContactProblem& p = solve.problem();
  Settings settings;
  std::optional<PetscOptions> petsc_options;
  try {
    settings = settings_for(p, solve.parameters());
    petsc_options.emplace(kPrefix, solve.parameters().text("petsc"));
  } catch (const std::invalid_argument& e) {
    return solve.end(SolveStatus::kInvalidInput, e.what());
  }
  const std::string linear = solve.parameters().choice("linear");
  const bool can_share = (linear == "auto" || linear == "mumps") &&
                         settings.residual != NewtonSystem::Residual::kInequality;
  SystemFactor* const factor = can_share ? solve.factor() : nullptr;
  if (!settings.mixed && !p.has_delassus()) return run_with_delassus(solve, factor);
  if (factor != nullptr) settings.linear = "mumps";
  run_newton(solve, settings, std::move(*petsc_options), factor);
}

}  // namespace bipot
