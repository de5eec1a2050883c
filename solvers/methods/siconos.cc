#include "solvers/methods/siconos.h"

#include <CSparseMatrix.h>
#include <FrictionContactProblem.h>
#include <Friction_cst.h>
#include <NonSmoothDrivers.h>
#include <NumericsMatrix.h>
#include <NumericsSparseMatrix.h>
#include <NumericsVerbose.h>
#include <SolverOptions.h>
#include <SparseBlockMatrix.h>
#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <mutex>
#include <stdexcept>

#include "core/problem/delassus.h"
#include "solvers/petsc/mpi_session.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

enum class Storage { kDense, kBlocks, kTriplets };

/// Request to Siconos of one row of the registry.
struct Method {
  std::string_view name;
  int planar_id;   // fc2d solver, 0: none
  int spatial_id;  // fc3d solver, 0: none
  Storage storage;
  int first_calls_iterations;
  int inner_iterations = 0;  // of Siconos' inner solver; 0: its default
  bool can_be_cut = false;   // the next call iterates on from where this one stopped
  int lost_factors = 0;      // of an iteration at most, which Siconos 4.4 does not free
};
constexpr Method kMethods[] = {
    {"NSGS", SICONOS_FRICTION_2D_NSGS, SICONOS_FRICTION_3D_NSGS, Storage::kBlocks, 1000, 0, true},
    {"NSN_AC", 0, SICONOS_FRICTION_3D_NSN_AC, Storage::kTriplets, 200, 0, false, 1},
    {"ADMM", 0, SICONOS_FRICTION_3D_ADMM, Storage::kTriplets, 1000},
    {"PROX", 0, SICONOS_FRICTION_3D_PROX, Storage::kTriplets, 10, 200, false, 500},
    {"LEMKE", SICONOS_FRICTION_2D_LEMKE, 0, Storage::kDense, 10000}};

// Least tolerance requested of Siconos.
constexpr double kSmallestTolerance = 1e-16;
// Contacts times iterations between two questions for an end, where a call may be cut.
constexpr int kContactsOfCut = 100000;
// Communicators that Siconos may leave behind; beyond 2^15 Open MPI ends the process.
constexpr int kMostCommunicators = 30000;
// Number of calls in a row without a better best iterate at which the solver ends.
constexpr int kIdleCalls = 5;

double* copy_to_c(const Vector& x) {
  auto* out = static_cast<double*>(
      std::malloc(sizeof(double) * to_size(std::max<Eigen::Index>(x.size(), 1))));
  if (out == nullptr) throw std::bad_alloc();
  std::copy(x.data(), x.data() + x.size(), out);
  return out;
}

/// The problem in Siconos' form, in its dimension and scaled units.
class SiconosProblem {
 public:
  SiconosProblem(const ContactProblem& p, int dim, Storage storage)
      : d_(p.dim), dim_(dim), contacts_(p.num_contacts()) {
    mobility_ = 0;
    for (int c = 0; c < contacts_; ++c) mobility_ += p.W.coeff(c * d_, c * d_) / contacts_;
    speed_ = p.u_free.cwiseAbs().maxCoeff();

    const int n = rows();
    NumericsMatrix* matrix = NM_create(NM_SPARSE, n, n);
    NM_triplet_alloc(matrix, static_cast<CS_INT>(p.W.nonZeros() + n));
    matrix->matrix2->origin = NSM_TRIPLET;
    for (int i = 0; i < p.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
        CSparseMatrix_entry(matrix->matrix2->triplet, row(i), row(static_cast<int>(it.col())),
                            it.value() / mobility_);
      }
    }
    for (int c = 0; c < contacts_; ++c) {
      const int model = c * d_ + d_ - 1;  // the last row that the contact has
      for (int k = d_; k < dim_; ++k) {
        CSparseMatrix_entry(matrix->matrix2->triplet, c * dim_ + k, c * dim_ + k,
                            p.W.coeff(model, model) / mobility_);
      }
    }
    if (storage == Storage::kBlocks) {
      NumericsMatrix* blocked = NM_create(NM_SPARSE_BLOCK, n, n);
      blocked->matrix1 = SBM_new();
      if (SBM_from_csparse(dim_, NM_csc(matrix), blocked->matrix1) != 0) {
        throw std::runtime_error("Siconos: SBM_from_csparse failed");
      }
      NM_free(matrix);
      matrix = blocked;
    } else if (storage == Storage::kDense) {
      NumericsMatrix* dense = NM_create(NM_DENSE, n, n);
      NM_to_dense(matrix, dense);
      NM_free(matrix);
      matrix = dense;
    }
    problem_ = frictionContactProblem_new_with_data(dim_, contacts_, matrix,
                                                    copy_to_c(velocity(p.u_free)), copy_to_c(p.mu));
  }
  ~SiconosProblem() {
    if (problem_ != nullptr) frictionContactProblem_free(problem_);
  }
  SiconosProblem(const SiconosProblem&) = delete;
  SiconosProblem& operator=(const SiconosProblem&) = delete;

  FrictionContactProblem* get() const { return problem_; }
  bool planar() const { return dim_ == 2; }
  int rows() const { return contacts_ * dim_; }

  Vector reaction(const Vector& s) const { return in_rows(s * mobility_ / speed_); }
  Vector velocity(const Vector& u) const { return in_rows(u / speed_); }
  Vector impulse(const Vector& reaction) const {
    Vector s(contacts_ * d_);
    for (int i = 0; i < contacts_ * d_; ++i) s[i] = reaction[row(i)] * speed_ / mobility_;
    return s;
  }

 private:
  int row(int i) const { return i / d_ * dim_ + i % d_; }
  Vector in_rows(const Vector& x) const {
    Vector out = Vector::Zero(rows());
    for (int i = 0; i < contacts_ * d_; ++i) out[row(i)] = x[i];
    return out;
  }

  int d_, dim_, contacts_;
  double mobility_ = 1, speed_ = 1;
  FrictionContactProblem* problem_ = nullptr;
};

struct DeleteOptions {
  void operator()(::SolverOptions* options) const { solver_options_delete(options); }
};
using TheirOptions = std::unique_ptr<::SolverOptions, DeleteOptions>;

TheirOptions make_options(int solver) {
  TheirOptions theirs(solver_options_create(solver));
  if (theirs == nullptr) throw std::runtime_error("Siconos: solver_options_create failed");
  return theirs;
}

/// One call from the given reaction and velocity, which become the result. Returns 0 for success.
int call_siconos(const SiconosProblem& problem, ::SolverOptions& theirs, double tol,
                 int max_iterations, Vector& reaction, Vector& velocity) {
  theirs.iparam[SICONOS_IPARAM_MAX_ITER] = max_iterations;
  theirs.iparam[SICONOS_IPARAM_ITER_DONE] = 0;
  theirs.dparam[SICONOS_DPARAM_TOL] = tol;
  numerics_set_verbose(0);
  const auto driver = problem.planar() ? &fc2d_driver : &fc3d_driver;
  return driver(problem.get(), reaction.data(), velocity.data(), &theirs);
}

/// How many communicators MUMPS has left behind. Open MPI numbers them from the lowest free number
/// on, and a factor returns a few of its own.
int lost_communicators() {
  int number = 0;
#ifdef OPEN_MPI
  MPI_Comm some[8];
  for (MPI_Comm& one : some) MPI_Comm_dup(MPI_COMM_SELF, &one);
  number = MPI_Comm_c2f(some[7]);
  for (MPI_Comm& one : some) MPI_Comm_free(&one);
#endif
  return number;
}

void run_siconos(const Method& method, SolveRun& run) {
  // Siconos and MUMPS have a state of the process.
  static std::mutex one_at_a_time;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  const ContactProblem& p = run.problem();
  const SolverOptions& options = run.options();
  const bool planar = p.dim <= 2 && method.planar_id != 0;
  const SiconosProblem problem(p, planar ? 2 : 3, method.storage);
  const TheirOptions theirs = make_options(planar ? method.planar_id : method.spatial_id);
  // Upper limit of one outer iteration: it cannot be interrupted.
  if (method.inner_iterations > 0) {
    theirs->internalSolvers[0]->iparam[SICONOS_IPARAM_MAX_ITER] = method.inner_iterations;
  }
  ensure_mpi();  // Siconos' linear solver is MUMPS, and it leaves MPI to the caller
  Vector s = run.start();
  run.end_setup();

  int iteration = 0, calls = 0, idle = 0;
  int budget = method.first_calls_iterations;
  const int cut =
      method.can_be_cut ? std::max(1, kContactsOfCut / std::max(1, p.num_contacts())) : INT_MAX;
  double tolerance = options.tol;
  if (!run.stop(0, s)) {
    Vector reaction = problem.reaction(s);
    Vector u(p.num_rows());
    run.delassus().velocity(s, u);
    Vector velocity = problem.velocity(u);
    for (;;) {
      const double best = run.best_error();
      int left = std::min(budget, options.max_iterations - iteration), info = 0;
      if (method.lost_factors > 0) {
        const int room = (kMostCommunicators - lost_communicators()) / method.lost_factors;
        if (room < 1) {
          run.end(SolveStatus::kNumericalFailure,
                  "this process has no communicators left: Siconos frees none of its factors'");
          break;
        }
        left = std::min(left, room);
      }
      do {
        info = call_siconos(problem, *theirs, tolerance, std::min(cut, left), reaction, velocity);
        // Some solvers do not count; none may loop without effect.
        const int done = std::max(1, theirs->iparam[SICONOS_IPARAM_ITER_DONE]);
        iteration += done;
        left -= done;
      } while (info != 0 && left > 0 && !run.out_of_time());
      ++calls;
      const Vector before = s;
      s = problem.impulse(reaction);
      if (!s.allFinite()) {
        run.end(SolveStatus::kNumericalFailure,
                fmt::format("Siconos returned a non-finite impulse (info {})", info));
        break;
      }
      // A call without any change has met its tolerance at once, or is stuck: the next one requests
      // more.
      if (s != before) {
        if (run.stop(iteration, s)) break;
        if (run.meets(s)) {
          run.end(SolveStatus::kConverged, fmt::format("{} test met after {} iterations",
                                                       to_string(options.stop), iteration));
          break;
        }
      }
      if (iteration >= options.max_iterations) {
        run.end(SolveStatus::kIterationLimit,
                fmt::format("iteration limit {} reached, best error {:.2e}", options.max_iterations,
                            run.best_error()));
        break;
      }
      if (run.end_if_out_of_time(iteration)) break;
      idle = run.best_error() < 0.99 * best ? 0 : idle + 1;
      const bool exhausted = info == 0 && tolerance <= kSmallestTolerance;
      if (exhausted || idle >= kIdleCalls) {
        run.end(SolveStatus::kStalled,
                fmt::format("Siconos makes no progress (info {}, its tolerance {:.0e}), best "
                            "error {:.2e}",
                            info, tolerance, run.best_error()));
        break;
      }
      if (info == 0 || idle > 0) tolerance = std::max(0.1 * tolerance, kSmallestTolerance);
      if (info != 0) budget = budget > INT_MAX / 2 ? INT_MAX : 2 * budget;
    }
  }
  run.set_iterations(iteration);
  run.remark(fmt::format("; Siconos {} ({}), {} calls, its last tolerance {:.0e}", method.name,
                         planar ? "fc2d" : "fc3d", calls, tolerance));
}

}  // namespace

std::function<void(SolveRun&)> siconos_solver(std::string_view name) {
  const Method& method = *std::find_if(std::begin(kMethods), std::end(kMethods),
                                       [&](const Method& of) { return of.name == name; });
  return [&method](SolveRun& run) { run_siconos(method, run); };
}

struct SiconosCall::Impl {
  SiconosProblem problem;
  Algorithm algorithm;
  int freezing;
  Vector reaction;
  int iterations = 0;
  double residual = kNaN;
};

SiconosCall::SiconosCall(const ContactProblem& p, Algorithm algorithm, int freezing) {
  const bool planar = algorithm == Algorithm::kPlanar;
  if (planar && p.dim > 2) throw std::invalid_argument("Siconos' planar NSGS: d = 3");
  const bool whole = algorithm == Algorithm::kAlartCurnier || algorithm == Algorithm::kAdmm;
  impl_.reset(new Impl{
      .problem = SiconosProblem(p, planar ? 2 : 3, whole ? Storage::kTriplets : Storage::kBlocks),
      .algorithm = algorithm,
      .freezing = freezing,
      .reaction = {}});
  if (whole) ensure_mpi();
}
SiconosCall::~SiconosCall() = default;

bool SiconosCall::run(double tol, int max_iterations) {
  struct Request {
    int solver, of_one_contact;  // 0: its default
  };
  constexpr Request kRequests[] = {
      {SICONOS_FRICTION_2D_NSGS, 0},
      {SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_NSN},
      {SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_NSN_GP_HYBRID},
      {SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_ProjectionOnConeWithLocalIteration},
      {SICONOS_FRICTION_3D_NSGS, SICONOS_FRICTION_3D_ONECONTACT_QUARTIC},
      {SICONOS_FRICTION_3D_NSN_AC, 0},
      {SICONOS_FRICTION_3D_ADMM, 0}};
  const Request& request = kRequests[static_cast<int>(impl_->algorithm)];
  const TheirOptions theirs = make_options(request.solver);
  if (request.of_one_contact != 0) {
    solver_options_update_internal(theirs.get(), 0, request.of_one_contact);
  }
  if (impl_->freezing > 0) {
    theirs->iparam[SICONOS_FRICTION_3D_NSGS_FREEZING_CONTACT] = impl_->freezing;
  }
  impl_->reaction = Vector::Zero(impl_->problem.rows());
  Vector velocity = impl_->reaction;
  const int info =
      call_siconos(impl_->problem, *theirs, tol, max_iterations, impl_->reaction, velocity);
  impl_->iterations = theirs->iparam[SICONOS_IPARAM_ITER_DONE];
  impl_->residual = theirs->dparam[SICONOS_DPARAM_RESIDU];
  return info == 0;
}
Vector SiconosCall::impulse() const { return impl_->problem.impulse(impl_->reaction); }
int SiconosCall::iterations() const { return impl_->iterations; }
double SiconosCall::residual() const { return impl_->residual; }

}  // namespace bipot
