#include "solvers/methods/newton_snes.h"

#include <fmt/format.h>
#include <petscsnes.h>

#include <cmath>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "core/problem/delassus.h"
#include "core/problem/sparse_factor.h"
#include "solvers/kernels/contact_residual.h"
#include "solvers/methods/gauss_seidel.h"
#include "solvers/methods/mpi_session.h"
#include "solvers/methods/proximal_point.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

static_assert(std::is_same_v<PetscScalar, double>, "PETSc with real double scalars is needed");

// ---------------------------------------------------------------------------------- PETSc session

/// A PETSc call that failed, with PETSc's text.
class PetscFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

void check(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw PetscFailure(fmt::format("PETSc: {} failed: {} (error {})", what,
                                 text != nullptr ? text : "unknown error", static_cast<int>(code)));
}

/// Initialises PETSc once, and finalises it at the end of the process if it was
/// initialised here.
class PetscSession {
 public:
  static void ensure() {
    static PetscSession session;
    PetscBool alive = PETSC_FALSE;
    PetscInitialized(&alive);
    if (!alive) throw PetscFailure("PETSc: initialisation failed, or it is already finalised");
  }

 private:
  PetscSession() {
    PetscBool alive = PETSC_FALSE;
    PetscInitialized(&alive);
    if (alive) return;  // the host program uses PETSc itself
    ensure_mpi();
    PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
    PetscOptionsSetValue(nullptr, "-skip_petscrc", "true");
    owned_ = PetscInitializeNoArguments() == 0;
    PETSC_STDOUT = stderr;  // monitors and views must not mix with a program's own output
  }
  ~PetscSession() {
    PetscBool finalised = PETSC_FALSE;
    PetscFinalized(&finalised);
    if (owned_ && !finalised) PetscFinalize();
  }
  bool owned_ = false;
};

/// While alive, PETSc's errors are returned instead of printed and aborted on.
class QuietErrors {
 public:
  QuietErrors() { PetscPushErrorHandler(PetscReturnErrorHandler, nullptr); }
  ~QuietErrors() { PetscPopErrorHandler(); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
};

constexpr const char* kPrefix = "bipot_newton_";

/// The user's options string in PETSc's database, removed at the end of the solve.
class ScopedOptions {
 public:
  explicit ScopedOptions(const std::string& text) {
    std::istringstream in(text);
    std::string token;
    while (in >> token) {
      const bool is_name = token.size() > 1 && token[0] == '-' &&
                           std::isalpha(static_cast<unsigned char>(token[1])) != 0;
      if (is_name) {
        std::string name = token.substr(1);
        if (name.rfind(kPrefix, 0) == 0) name.erase(0, std::string_view(kPrefix).size());
        options_.emplace_back(std::move(name), "");
      } else if (options_.empty() || !options_.back().second.empty()) {
        throw std::invalid_argument(
            fmt::format("parameter petsc: '{}' follows no option name", token));
      } else {
        options_.back().second = token;
      }
    }
  }
  /// Defaults of this solver that the user has not set.
  void add_default(const std::string& name, const std::string& value) {
    for (const auto& [given, unused] : options_) {
      if (given == name) return;
    }
    defaults_.emplace_back(name, value);
  }
  void insert() {
    for (const auto& list : {options_, defaults_}) {
      for (const auto& [name, value] : list) {
        check(PetscOptionsSetValue(nullptr, key(name).c_str(),
                                   value.empty() ? nullptr : value.c_str()),
              "PetscOptionsSetValue");
      }
    }
    inserted_ = true;
  }
  /// Names of the user's options that PETSc never asked for.
  std::string unused() const {
    std::string names;
    for (const auto& [name, value] : options_) {
      PetscBool used = PETSC_TRUE;
      if (PetscOptionsUsed(nullptr, key(name).c_str() + 1, &used) == 0 && !used) {
        names += (names.empty() ? "-" : ", -") + name;
      }
    }
    return names;
  }
  ~ScopedOptions() {
    if (!inserted_) return;
    for (const auto& list : {options_, defaults_}) {
      for (const auto& [name, value] : list) PetscOptionsClearValue(nullptr, key(name).c_str());
    }
  }
  ScopedOptions(const ScopedOptions&) = delete;
  ScopedOptions& operator=(const ScopedOptions&) = delete;

 private:
  static std::string key(const std::string& name) { return fmt::format("-{}{}", kPrefix, name); }
  std::vector<std::pair<std::string, std::string>> options_, defaults_;
  bool inserted_ = false;
};

// -------------------------------------------------------------------------------------- equations

enum class Residual { kAlartCurnier, kFischerBurmeister, kInequality };

/// The regularised problem as a square system of equations with a fixed sparsity pattern.
///
///   contact form, unknown x:      f_c(x_c, w_c) = 0,  w = W' x + b' + (x - x_k) / kappa
///   mixed form, unknown (y, x):   A' y - H' x = 0,  f_c(x_c, w_c) = 0,
///                                 w = H'ᵀ y + b' + (x - x_k) / kappa
///
/// W' = D^{-1/2} W D^{-1/2}, A' = S A S, H' = S H D^{-1/2}, S = diag(A)^{-1/2}, b' = D^{-1/2}
/// u_free / unit. kInequality: f = w, for a solver that keeps x >= 0 by itself.
class NewtonSystem {
 public:
  NewtonSystem(const ContactProblem& p, const Vector& diagonal, Residual residual, bool mixed)
      : d_(p.dim), contacts_(p.num_contacts()), residual_(residual), mixed_(mixed) {
    root_ = proximal_weights(p, diagonal).cwiseSqrt();
    const Vector inverse = root_.cwiseInverse();
    b_ = p.u_free.cwiseProduct(inverse);
    unit_ = b_.norm();
    b_ /= unit_;
    mu_ = p.mu;
    for (int c = 0; c < contacts_ && d_ > 1; ++c) mu_[c] *= root_[c * d_ + 1] / root_[c * d_];
    anchor_ = Vector::Zero(rows());
    if (mixed_) {
      const Vector s = p.A.diagonal().cwiseSqrt().cwiseInverse();
      dofs_ = p.num_dofs();
      A_ = s.asDiagonal() * p.A * s.asDiagonal();
      H_ = SparseMatrix(s.asDiagonal() * p.H * inverse.asDiagonal());
      H_.makeCompressed();
      H_rows_ = H_;
      diagonal_mass_ = is_diagonal(p.A);
      if (!diagonal_mass_ && !mass_factor_.factor(SparseMatrix(A_))) {
        throw std::runtime_error("the mass matrix A is not positive definite");
      }
      build_mixed_pattern();
    } else {
      W_ = SparseRows(inverse.asDiagonal() * p.W * inverse.asDiagonal());
      build_contact_pattern();
    }
  }

  int rows() const { return contacts_ * d_; }
  int size() const { return dofs_ + rows(); }
  int offset() const { return dofs_; }
  const std::vector<PetscInt>& row_start() const { return row_start_; }
  const std::vector<PetscInt>& columns() const { return columns_; }

  void set_proximal(double kappa, const Vector& anchor_impulse) {
    kappa_ = kappa;
    anchor_ = anchor_impulse.cwiseProduct(root_) / unit_;
  }
  double kappa() const { return kappa_; }

  /// Unknowns at the impulse s, dynamics exact.
  Vector unknowns(const Vector& s) const {
    Vector z(size());
    z.tail(rows()) = s.cwiseProduct(root_) / unit_;
    if (mixed_) {
      const Vector wrench = H_ * z.tail(rows());
      z.head(dofs_) = diagonal_mass_ ? wrench : mass_factor_.solve(wrench);
    }
    return z;
  }
  Eigen::Map<const Vector> scaled_impulse(const double* z) const {
    return Eigen::Map<const Vector>(z + dofs_, rows());
  }
  Vector impulse(const double* z) const { return unit_ * scaled_impulse(z).cwiseQuotient(root_); }
  /// ‖x - x_k‖ / kappa: what the proximal term still changes.
  double proximal_residual(const double* z) const {
    return (scaled_impulse(z) - anchor_).norm() / kappa_;
  }

  void residual(const double* z, double* f) const {
    const Vector w = velocity(z);
    const Eigen::Map<const Vector> x = scaled_impulse(z);
    if (mixed_) {
      const Eigen::Map<const Vector> y(z, dofs_);
      Eigen::Map<Vector>(f, dofs_) = A_ * y - H_rows_ * x;
    }
    if (residual_ == Residual::kInequality) {
      Eigen::Map<Vector>(f + dofs_, rows()) = w;
      return;
    }
    dispatch_dim(d_, [&](auto d) {
      constexpr int D = d();
      for (int c = 0; c < contacts_; ++c) {
        Eigen::Map<Local<D>>(f + dofs_ + c * D) = equation<D>(c, x, w).f;
      }
      return 0;
    });
  }

  /// Values of the Jacobian in the order of the pattern.
  void jacobian(const double* z, double* values) const {
    const Vector w = velocity(z);
    const Eigen::Map<const Vector> x = scaled_impulse(z);
    if (mixed_) std::copy(fixed_values_.begin(), fixed_values_.end(), values);
    dispatch_dim(d_, [&](auto d) {
      constexpr int D = d();
      for (int c = 0; c < contacts_; ++c) {
        LocalResidual<D> r;
        if (residual_ == Residual::kInequality) {
          r.Q.setIdentity();
        } else {
          r = equation<D>(c, x, w);
        }
        fill_contact<D>(c, r, values);
      }
      return 0;
    });
  }

 private:
  Vector velocity(const double* z) const {
    const Eigen::Map<const Vector> x = scaled_impulse(z);
    Vector w = b_ + (x - anchor_) / kappa_;
    if (mixed_) {
      w += H_.transpose() * Eigen::Map<const Vector>(z, dofs_);
    } else {
      w += W_ * x;
    }
    return w;
  }

  template <int D>
  LocalResidual<D> equation(int c, const Eigen::Map<const Vector>& x, const Vector& w) const {
    const Local<D> xc = x.segment<D>(c * D), wc = w.segment<D>(c * D);
    return residual_ == Residual::kAlartCurnier ? alart_curnier<D>(xc, wc, mu_[c])
                                                : fischer_burmeister<D>(xc, wc, mu_[c]);
  }

  /// Row block of contact c: Q G on the columns of `coupling` (G = rows of W' or of H'ᵀ), then
  /// P + Q / kappa on the contact's own columns.
  template <int D>
  void fill_contact(int c, const LocalResidual<D>& r, double* values) const {
    const int begin = coupling_start_[c], width = coupling_start_[c + 1] - begin;
    const typename LocalResidual<D>::Block own = r.P + r.Q / kappa_;
    for (int a = 0; a < D; ++a) {
      double* row = values + row_start_[dofs_ + c * D + a];
      for (int k = 0; k < width; ++k) {
        double sum = 0;
        for (int b = 0; b < D; ++b) sum += r.Q(a, b) * coupling_[(begin + k) * D + b];
        row[k] = sum;
      }
      if (mixed_) {
        for (int b = 0; b < D; ++b) row[width + b] = own(a, b);
      } else {
        for (int b = 0; b < D; ++b) row[own_position_[c] + b] += own(a, b);
      }
    }
  }

  void build_contact_pattern() {
    const int D = d_;
    row_start_.assign(1, 0);
    coupling_start_.assign(1, 0);
    own_position_.resize(contacts_);
    std::map<int, std::vector<double>> block;  // column -> D values, sorted
    for (int c = 0; c < contacts_; ++c) {
      block.clear();
      for (int b = 0; b < D; ++b) block[c * D + b].assign(D, 0.0);
      for (int a = 0; a < D; ++a) {
        for (SparseRows::InnerIterator it(W_, c * D + a); it; ++it) {
          std::vector<double>& column = block[static_cast<int>(it.col())];
          column.resize(D, 0.0);
          column[a] += it.value();
        }
      }
      for (const auto& [column, value] : block) {
        coupling_.insert(coupling_.end(), value.begin(), value.end());
      }
      coupling_start_.push_back(coupling_start_.back() + static_cast<int>(block.size()));
      own_position_[c] = static_cast<int>(std::distance(block.begin(), block.find(c * D)));
      for (int a = 0; a < D; ++a) {
        for (const auto& [column, value] : block) columns_.push_back(column);
        row_start_.push_back(static_cast<PetscInt>(columns_.size()));
      }
    }
  }

  void build_mixed_pattern() {
    const int D = d_;
    row_start_.assign(1, 0);
    for (int i = 0; i < dofs_; ++i) {
      for (SparseRows::InnerIterator it(A_, i); it; ++it) {
        columns_.push_back(static_cast<PetscInt>(it.col()));
        fixed_values_.push_back(it.value());
      }
      for (SparseRows::InnerIterator it(H_rows_, i); it; ++it) {
        columns_.push_back(dofs_ + static_cast<PetscInt>(it.col()));
        fixed_values_.push_back(-it.value());
      }
      row_start_.push_back(static_cast<PetscInt>(columns_.size()));
    }
    coupling_start_.assign(1, 0);
    std::map<int, std::vector<double>> block;
    for (int c = 0; c < contacts_; ++c) {
      block.clear();
      for (int a = 0; a < D; ++a) {
        for (SparseMatrix::InnerIterator it(H_, c * D + a); it; ++it) {
          std::vector<double>& column = block[static_cast<int>(it.row())];
          column.resize(D, 0.0);
          column[a] += it.value();
        }
      }
      for (const auto& [column, value] : block) {
        coupling_.insert(coupling_.end(), value.begin(), value.end());
      }
      coupling_start_.push_back(coupling_start_.back() + static_cast<int>(block.size()));
      for (int a = 0; a < D; ++a) {
        for (const auto& [column, value] : block) columns_.push_back(column);
        for (int b = 0; b < D; ++b) columns_.push_back(dofs_ + c * D + b);
        row_start_.push_back(static_cast<PetscInt>(columns_.size()));
      }
    }
  }

  int d_, contacts_, dofs_ = 0;
  Residual residual_;
  bool mixed_, diagonal_mass_ = true;
  double unit_ = 1, kappa_ = 1;
  Vector root_, b_, mu_, anchor_;
  SparseRows W_, A_, H_rows_;
  SparseMatrix H_;
  SparseCholesky mass_factor_;
  std::vector<PetscInt> row_start_, columns_;
  std::vector<double> fixed_values_;  // rows of the dynamics, mixed form
  std::vector<int> coupling_start_;   // per contact, into coupling_ / D
  std::vector<double> coupling_;      // D values per coupled column
  std::vector<int> own_position_;     // contact form: first own column in the row
};

// ---------------------------------------------------------------------------------------- solver

/// What the callbacks share.
struct Run {
  NewtonSystem* system = nullptr;
  IterationMonitor* monitor = nullptr;
  int iterations = 0;          // Newton steps of all proximal steps
  std::vector<Vector> recent;  // last iterates of this proximal step, the oldest is overwritten
  bool stop = false;           // the monitor said so
  double first_norm = 0;       // residual at the start of the proximal step
};

// Residual of one proximal step, relative to what the step itself still changes.
constexpr double kForcing = 0.1;
// Residuals are of size one; below this there is only rounding.
constexpr double kResidualFloor = 1e-15;
// Nonsmooth Newton cycles between active sets; periods up to this are recognised.
constexpr std::size_t kLongestCycle = 6;
// PETSc's LU (nested dissection, no pivoting) takes a third to a half of UMFPACK's time on packings
// of 700 to 1400 contacts and twice as long at 7300.
constexpr int kSmall = 4000;
// Two iterates that differ by less, relative, are the same.
constexpr double kSame = 1e-13;
// A repeated iterate whose residual is this small against the first one, or against the impulses,
// is a solution at round-off.
constexpr double kSolvedAtRoundOff = 1e-8, kRounding = 1e-13;

PetscErrorCode form_function(SNES, Vec z, Vec f, void* context) {
  const auto* run = static_cast<Run*>(context);
  const PetscScalar* in = nullptr;
  PetscScalar* out = nullptr;
  PetscCall(VecGetArrayRead(z, &in));
  PetscCall(VecGetArray(f, &out));
  run->system->residual(in, out);
  PetscCall(VecRestoreArray(f, &out));
  PetscCall(VecRestoreArrayRead(z, &in));
  return 0;
}

PetscErrorCode form_jacobian(SNES, Vec z, Mat, Mat J, void* context) {
  const auto* run = static_cast<Run*>(context);
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
  auto* run = static_cast<Run*>(context);
  *reason = SNES_CONVERGED_ITERATING;
  if (!std::isfinite(norm)) {
    *reason = SNES_DIVERGED_FNORM_NAN;
    return 0;
  }
  Vec z = nullptr;
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
    // A repeated iterate is for the outer loop to judge, which changes kappa: to the monitor it
    // would be the end.
    bool repeated = false;
    for (const Vector& old : run->recent) repeated |= (s - old).norm() <= kSame * s.norm();
    if (repeated) {
      *reason = norm <= std::max({kSolvedAtRoundOff * run->first_norm, target, kRounding * size})
                    ? SNES_CONVERGED_SNORM_RELATIVE
                    : SNES_DIVERGED_LOCAL_MIN;
      return 0;
    }
    if (run->monitor->stop(run->iterations, s, run->system->kappa())) {
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
    run->recent[iteration % kLongestCycle] = std::move(s);
  }
  return 0;
}

/// Owns the PETSc objects of one solve.
class Snes {
 public:
  Snes(Run& run, Residual residual, const std::string& linear, const std::string& line_search,
       int inner_iterations)
      : Snes(run) {  // delegated: the destructor cleans up after a failure below, too
    const NewtonSystem& system = *run.system;
    const PetscInt n = system.size();
    check(VecCreateSeq(PETSC_COMM_SELF, n, &z_), "VecCreateSeq");
    check(VecDuplicate(z_, &f_), "VecDuplicate");
    check(MatCreate(PETSC_COMM_SELF, &J_), "MatCreate");
    check(MatSetSizes(J_, n, n, n, n), "MatSetSizes");
    check(MatSetType(J_, MATSEQAIJ), "MatSetType");
    check(MatSeqAIJSetPreallocationCSR(J_, system.row_start().data(), system.columns().data(),
                                       nullptr),
          "MatSeqAIJSetPreallocationCSR");
    check(MatSetOption(J_, MAT_NEW_NONZERO_LOCATIONS, PETSC_FALSE), "MatSetOption");

    check(SNESCreate(PETSC_COMM_SELF, &snes_), "SNESCreate");
    check(SNESSetOptionsPrefix(snes_, kPrefix), "SNESSetOptionsPrefix");
    check(SNESSetType(snes_, residual == Residual::kInequality ? SNESVINEWTONRSLS : SNESNEWTONLS),
          "SNESSetType");
    check(SNESSetFunction(snes_, f_, form_function, &run_), "SNESSetFunction");
    check(SNESSetJacobian(snes_, J_, J_, form_jacobian, &run_), "SNESSetJacobian");
    check(SNESSetConvergenceTest(snes_, test_convergence, &run_, nullptr),
          "SNESSetConvergenceTest");
    check(SNESSetTolerances(snes_, 0, 0, 0, inner_iterations, PETSC_MAX_INT), "SNESSetTolerances");
    if (residual == Residual::kInequality) {
      check(VecDuplicate(z_, &lower_), "VecDuplicate");
      check(VecDuplicate(z_, &upper_), "VecDuplicate");
      check(VecSet(lower_, 0), "VecSet");
      check(VecSet(upper_, PETSC_INFINITY), "VecSet");
      check(SNESVISetVariableBounds(snes_, lower_, upper_), "SNESVISetVariableBounds");
    }
    SNESLineSearch search = nullptr;
    check(SNESGetLineSearch(snes_, &search), "SNESGetLineSearch");
    check(SNESLineSearchSetType(search, line_search.c_str()), "SNESLineSearchSetType");

    KSP ksp = nullptr;
    PC pc = nullptr;
    check(SNESGetKSP(snes_, &ksp), "SNESGetKSP");
    check(KSPGetPC(ksp, &pc), "KSPGetPC");
    if (linear == "gmres") {
      check(KSPSetType(ksp, KSPGMRES), "KSPSetType");
      check(KSPGMRESSetRestart(ksp, 100), "KSPGMRESSetRestart");
      check(KSPSetTolerances(ksp, 1e-10, 0, PETSC_DEFAULT, 1000), "KSPSetTolerances");
      check(PCSetType(pc, PCILU), "PCSetType");
      check(PCFactorSetLevels(pc, 2), "PCFactorSetLevels");
      check(PCFactorSetShiftType(pc, MAT_SHIFT_NONZERO), "PCFactorSetShiftType");
    } else {
      check(KSPSetType(ksp, KSPPREONLY), "KSPSetType");
      check(PCSetType(pc, PCLU), "PCSetType");
      check(PCFactorSetMatSolverType(pc, linear == "umfpack" ? MATSOLVERUMFPACK
                                         : linear == "mumps" ? MATSOLVERMUMPS
                                                             : MATSOLVERPETSC),
            "PCFactorSetMatSolverType");
      if (linear == "petsc") {
        check(PCFactorSetMatOrderingType(pc, MATORDERINGND), "PCFactorSetMatOrderingType");
        check(PCFactorSetShiftType(pc, MAT_SHIFT_NONZERO), "PCFactorSetShiftType");
      }
    }
    check(SNESSetFromOptions(snes_), "SNESSetFromOptions");
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
    check(SNESSolve(snes_, nullptr, z_), "SNESSolve");
    SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
    check(SNESGetConvergedReason(snes_, &reason), "SNESGetConvergedReason");
    const PetscScalar* values = nullptr;
    check(VecGetArrayRead(z_, &values), "VecGetArrayRead");
    report.s = run_.system->impulse(values);
    check(VecRestoreArrayRead(z_, &values), "VecRestoreArrayRead");
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
  explicit Snes(Run& run) : run_(run) {}

  void set(const Vector& start) {
    PetscScalar* values = nullptr;
    check(VecGetArray(z_, &values), "VecGetArray");
    Eigen::Map<Vector>(values, start.size()) = start;
    check(VecRestoreArray(z_, &values), "VecRestoreArray");
  }

  Run& run_;
  SNES snes_ = nullptr;
  Mat J_ = nullptr;
  Vec z_ = nullptr, f_ = nullptr, lower_ = nullptr, upper_ = nullptr;
};

}  // namespace

SolveResult solve_newton_snes(const ContactProblem& given, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kNewtonParameters);
  const std::string residual_name = parameters.choice("residual");
  std::string linear = parameters.choice("linear");
  if (linear == "auto") linear = given.num_rows() <= kSmall ? "petsc" : "umfpack";
  const std::string form = parameters.choice("form");
  const int inner_iterations = parameters.integer("inner_iterations");
  const Residual residual = residual_name == "alart-curnier"        ? Residual::kAlartCurnier
                            : residual_name == "fischer-burmeister" ? Residual::kFischerBurmeister
                                                                    : Residual::kInequality;
  SolveResult refused;
  refused.status = SolveStatus::kInvalidInput;
  refused.s = Vector::Zero(given.num_rows());
  if (residual == Residual::kInequality && given.dim != 1) {
    refused.message =
        fmt::format("residual snesvi is for dimension 1, the problem has {}", given.dim);
    return refused;
  }
  if (form == "mixed" && (residual == Residual::kInequality || !given.has_velocities())) {
    refused.message = residual == Residual::kInequality
                          ? "residual snesvi has the contact form only"
                          : "form mixed needs A and H, the problem has W alone";
    return refused;
  }
  std::optional<ScopedOptions> petsc_options;
  try {
    petsc_options.emplace(parameters.text("petsc"));
  } catch (const std::invalid_argument& e) {
    refused.message = e.what();
    return refused;
  }
  const bool mixed = form == "mixed" || (form == "auto" && given.has_velocities() &&
                                         residual != Residual::kInequality && linear != "gmres");
  ContactProblem with_delassus;
  const ContactProblem* problem = &given;
  if (!mixed && !given.has_delassus()) {
    with_delassus = given;
    with_delassus.W = assemble_delassus(given.A, given.H, given.dim);
    problem = &with_delassus;
  }
  const ContactProblem& p = *problem;

  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  PetscSession::ensure();
  const QuietErrors quiet;
  petsc_options->add_default("mat_mumps_icntl_14", "1000");  // workspace, per cent; 200 runs out
  if (linear != "mumps") petsc_options->add_default("mat_umfpack_ordering", "METIS");
  petsc_options->insert();

  IterationMonitor monitor(p, options);
  const Vector start = start_of(p, options);
  NewtonSystem system(p, monitor.evaluator().delassus().diagonal(), residual, mixed);
  Run run;
  run.system = &system;
  run.monitor = &monitor;
  Snes snes(run, residual, linear, parameters.choice("line_search"), inner_iterations);
  monitor.end_setup();

  std::string about;
  if (!monitor.stop(0, start)) {
    SolverOptions sweeps;
    sweeps.max_iterations = parameters.integer("start_sweeps");
    sweeps.tol = options.tol;
    sweeps.s0 = start;
    sweeps.time_limit = std::max(monitor.remaining_seconds(), 1e-9);
    const SolveResult swept = solve_gauss_seidel(p, sweeps);
    ProximalReport report;
    if (monitor.meets(swept.s)) {
      monitor.end(SolveStatus::kConverged, "stop test met by the start sweeps");
    } else {
      try {
        const ProximalOptions loop{.kappa = parameters.number("kappa"),
                                   .kappa_max = parameters.number("kappa_max")};
        const auto inner = [&](double kappa, const Vector& anchor) {
          InnerReport r = snes.solve(kappa, anchor, inner_iterations);
          if (r.outcome == InnerReport::Outcome::kSolved && monitor.meets(r.s)) {
            // Between two judgements of the cadence, a proximal step ends on the solution.
            monitor.end(SolveStatus::kConverged,
                        fmt::format("{} test met after {} iterations", to_string(options.stop),
                                    run.iterations));
            r.outcome = InnerReport::Outcome::kStop;
          } else if (r.outcome != InnerReport::Outcome::kStop &&
                     monitor.end_if_out_of_time(run.iterations)) {
            r.outcome = InnerReport::Outcome::kStop;
          }
          return r;
        };
        report =
            proximal_point(loop, proximal_weights(p, monitor.evaluator().delassus().diagonal()),
                           swept.s, inner, monitor);
      } catch (const PetscFailure& e) {
        monitor.end(SolveStatus::kNumericalFailure,
                    fmt::format("{}; best error {:.2e}", e.what(), monitor.best_error()));
      }
    }
    about = fmt::format(
        "; {}, {} form, {}: {} start sweeps, {} Newton steps in {} proximal steps ({} failed), "
        "last kappa {:.1e}",
        residual_name, mixed ? "mixed" : "contact", linear, swept.iterations, run.iterations,
        report.steps, report.failed, report.kappa);
    const std::string unused = petsc_options->unused();
    if (!unused.empty()) about += fmt::format("; PETSc did not use the options {}", unused);
  }
  SolveResult result = monitor.finish();
  result.message += about;
  return result;
}

}  // namespace bipot
