#include "solvers/parallel/parallel_factor.h"

#include <petscmat.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "solvers/petsc/petsc_session.h"

namespace bipot {
namespace {

static_assert(std::is_same_v<PetscInt, int>, "PETSc with 32-bit indices is needed");

constexpr auto kNap = std::chrono::microseconds(20);
// MUMPS's workspace beyond its estimate, per cent, and the largest one tried.
constexpr int kFirstWorkspace = 50, kMostWorkspace = 1600;
constexpr int kWorkspaceTooSmall = -9, kIndicesTooMany = -8;  // MUMPS's INFOG(1)

/// Request of the root process to the others.
struct Order {
  enum Kind : int { kFactor, kSolve, kDone, kFailed };
  int kind = kDone;
  int size = 0;   ///< kFactor: unknowns; kFailed: length of the text
  int fresh = 0;  ///< kFactor: 1 if the pattern is a new one
};

/// The part of each process in factorisations and solves. PETSc has the matrix Aᵀ: a column of A is
/// a row of its own.
class FactorGroup {
 public:
  explicit FactorGroup(ProcessGroup::Traffic& traffic) : traffic_(traffic) {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    MPI_Comm_size(PETSC_COMM_WORLD, &processes_);
  }
  ~FactorGroup() { clear(); }
  FactorGroup(const FactorGroup&) = delete;
  FactorGroup& operator=(const FactorGroup&) = delete;

  int rank() const { return rank_; }

  /// From the root process to all. The others wait without using a core.
  Order give(Order order) {
    MPI_Request request = MPI_REQUEST_NULL;
    BIPOT_MPI(MPI_Ibcast, &order, 3, MPI_INT, 0, PETSC_COMM_WORLD, &request);
    for (int over = 0; over == 0;) {
      BIPOT_MPI(MPI_Test, &request, &over, MPI_STATUS_IGNORE);
      if (over == 0 && rank_ != 0) std::this_thread::sleep_for(kNap);
    }
    count(sizeof(Order));
    return order;
  }
  std::string give_text(std::string text, int size) {
    text.resize(to_size(size));
    BIPOT_MPI(MPI_Bcast, text.data(), size, MPI_CHAR, 0, PETSC_COMM_WORLD);
    return text;
  }

  /// `A`: on the root process alone.
  bool factor(const Order& order, const SparseMatrix* A) {
    if (order.fresh != 0) take_pattern(order.size, A);
    const int mine = starts_.back();
    values_.resize(to_size(mine));
    scatter(A == nullptr ? nullptr : A->valuePtr(), entry_counts_, entry_firsts_,
            std::span(values_));
    const auto finite = [](double x) { return std::isfinite(x); };
    int good = std::all_of(values_.begin(), values_.end(), finite) ? 1 : 0;
    BIPOT_MPI(MPI_Allreduce, MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, PETSC_COMM_WORLD);
    if (good == 0) return false;
    if (matrix_ == nullptr) {
      BIPOT_PETSC(MatCreateMPIAIJWithArrays, PETSC_COMM_WORLD, rows(), rows(), size_, size_,
                  starts_.data(), rows_.data(), values_.data(), &matrix_);
      BIPOT_PETSC(MatCreateVecs, matrix_, &right_, &left_);
    } else {
      BIPOT_PETSC(MatUpdateMPIAIJWithArray, matrix_, values_.data());
    }
    while (true) {
      if (factor_ == nullptr) analyse();
      if (!analysed_) return false;
      MatFactorInfo info;
      BIPOT_PETSC(MatFactorInfoInitialize, &info);
      BIPOT_PETSC(MatLUFactorNumeric, factor_, matrix_, &info);
      PetscInt said = 0;
      BIPOT_PETSC(MatMumpsGetInfog, factor_, 1, &said);
      if (said >= 0) break;
      if (said != kWorkspaceTooSmall && said != kIndicesTooMany) return drop_factor();
      if (workspace_ >= kMostWorkspace) return drop_factor();
      workspace_ *= 2;
      drop_factor();
    }
    PetscReal determinant = 0;  // its mantissa
    BIPOT_PETSC(MatMumpsGetRinfog, factor_, 12, &determinant);
    sign_ = determinant < 0 ? -1 : 1;
    return determinant != 0 && std::isfinite(determinant);
  }
  int determinant_sign() const { return sign_; }

  /// b and x: on the root process alone.
  void solve(const Vector* b, Vector* x) {
    PetscScalar* values = nullptr;
    const double* const source = b == nullptr ? nullptr : b->data();
    BIPOT_PETSC(VecGetArray, left_, &values);
    scatter(source, column_counts_, column_firsts_, std::span(values, to_size(rows())));
    BIPOT_PETSC(VecRestoreArray, left_, &values);
    BIPOT_PETSC(MatSolveTranspose, factor_, left_, right_);
    const PetscScalar* solved = nullptr;
    BIPOT_PETSC(VecGetArrayRead, right_, &solved);
    if (x != nullptr) x->resize(size_);
    BIPOT_MPI(MPI_Gatherv, solved, rows(), MPI_DOUBLE, x == nullptr ? nullptr : x->data(),
              column_counts_.data(), column_firsts_.data(), MPI_DOUBLE, 0, PETSC_COMM_WORLD);
    BIPOT_PETSC(VecRestoreArrayRead, right_, &solved);
    count(to_size(rank_ == 0 ? 0 : rows()) * sizeof(double));
  }

 private:
  int rows() const { return column_counts_[to_size(rank_)]; }

  /// Sets the columns and entries of each process, and the pattern of this one's.
  void take_pattern(int size, const SparseMatrix* A) {
    clear();
    size_ = size;
    column_firsts_.assign(1, 0);
    column_counts_.clear();
    for (int r = 0; r < processes_; ++r) {
      const auto next = static_cast<int>(std::int64_t{size} * (r + 1) / processes_);
      column_counts_.push_back(next - column_firsts_.back());
      column_firsts_.push_back(next);
    }
    std::vector<int> with_end = column_counts_;
    for (int& columns : with_end) ++columns;
    starts_.resize(to_size(rows() + 1));
    scatter(A == nullptr ? nullptr : A->outerIndexPtr(), with_end, column_firsts_,
            std::span(starts_));
    const int first = starts_.front();
    for (int& start : starts_) start -= first;
    entry_counts_.assign(to_size(processes_), 0);
    entry_firsts_.assign(to_size(processes_), 0);
    const int mine = starts_.back();
    BIPOT_MPI(MPI_Gather, &mine, 1, MPI_INT, entry_counts_.data(), 1, MPI_INT, 0, PETSC_COMM_WORLD);
    for (std::size_t r = 1; r < entry_firsts_.size(); ++r) {
      entry_firsts_[r] = entry_firsts_[r - 1] + entry_counts_[r - 1];
    }
    rows_.resize(to_size(mine));
    scatter(A == nullptr ? nullptr : A->innerIndexPtr(), entry_counts_, entry_firsts_,
            std::span(rows_));
  }

  template <class T>
  void scatter(const T* all, const std::vector<int>& counts, const std::vector<int>& firsts,
               std::span<T> mine) {
    const MPI_Datatype type = std::is_same_v<T, int> ? MPI_INT : MPI_DOUBLE;
    BIPOT_MPI(MPI_Scatterv, all, counts.data(), firsts.data(), type, mine.data(),
              static_cast<int>(mine.size()), type, 0, PETSC_COMM_WORLD);
    std::size_t sent = 0;
    if (rank_ == 0) {
      for (std::size_t r = 1; r < counts.size(); ++r) sent += to_size(counts[r]);
      traffic_.messages += processes_ - 1;
    }
    traffic_.bytes += static_cast<std::int64_t>(sent * sizeof(T));
  }
  void count(std::size_t bytes) {
    ++traffic_.reductions;
    traffic_.reduced_bytes += static_cast<std::int64_t>(bytes);
  }

  void analyse() {
    analysed_ = false;
    BIPOT_PETSC(MatGetFactor, matrix_, MATSOLVERMUMPS, MAT_FACTOR_LU, &factor_);
    BIPOT_PETSC(MatMumpsSetIcntl, factor_, 33, 1);  // the determinant
    BIPOT_PETSC(MatMumpsSetIcntl, factor_, 14, workspace_);
    MatFactorInfo info;
    BIPOT_PETSC(MatFactorInfoInitialize, &info);
    BIPOT_PETSC(MatLUFactorSymbolic, factor_, matrix_, nullptr, nullptr, &info);
    PetscInt said = 0;
    BIPOT_PETSC(MatMumpsGetInfog, factor_, 1, &said);
    analysed_ = said >= 0;
    if (!analysed_) drop_factor();
  }
  bool drop_factor() {
    MatDestroy(&factor_);
    return false;
  }
  void clear() {
    drop_factor();
    MatDestroy(&matrix_);
    VecDestroy(&left_);
    VecDestroy(&right_);
  }

  ProcessGroup::Traffic& traffic_;
  int rank_ = 0, processes_ = 1, size_ = 0, workspace_ = kFirstWorkspace, sign_ = 1;
  std::vector<int> column_counts_, column_firsts_, entry_counts_, entry_firsts_;
  std::vector<PetscInt> starts_, rows_;
  std::vector<double> values_;
  ::Mat matrix_ = nullptr, factor_ = nullptr;
  ::Vec left_ = nullptr, right_ = nullptr;
  bool analysed_ = false;
};

/// The factor as used by the root process.
class ParallelFactor final : public SystemFactor {
 public:
  explicit ParallelFactor(FactorGroup& group) : group_(group) {}

  [[nodiscard]] bool factor(const SparseMatrix& A) override {
    const int* const starts = A.outerIndexPtr();
    const int* const rows = A.innerIndexPtr();
    const bool same = to_size(A.cols() + 1) == starts_.size() &&
                      std::equal(starts_.begin(), starts_.end(), starts) &&
                      std::equal(rows_.begin(), rows_.end(), rows);
    if (!same) {
      starts_.assign(starts, starts + A.cols() + 1);
      rows_.assign(rows, rows + A.nonZeros());
    }
    const Order order{Order::kFactor, static_cast<int>(A.cols()), same ? 0 : 1};
    return group_.factor(group_.give(order), &A);
  }
  void solve(const Vector& b, Vector& x) override {
    group_.give({.kind = Order::kSolve});
    group_.solve(&b, &x);
  }
  int determinant_sign() const override { return group_.determinant_sign(); }

 private:
  FactorGroup& group_;
  std::vector<int> starts_, rows_;
};

void lead(FactorGroup& group, const std::function<void(SystemFactor&)>& work) {
  std::string failure;
  try {
    ParallelFactor factor(group);
    work(factor);
  } catch (const std::exception& e) {
    failure = e.what();
    if (failure.empty()) failure = "failed without a reason";
  }
  if (failure.empty()) {
    group.give({.kind = Order::kDone});
    return;
  }
  const int length = static_cast<int>(failure.size());
  group.give({.kind = Order::kFailed, .size = length});
  throw CommonFailure(group.give_text(failure, length));
}

void serve(FactorGroup& group) {
  while (true) {
    const Order order = group.give({});
    switch (order.kind) {
      case Order::kFactor:
        (void)group.factor(order, nullptr);  // the first process knows the outcome as well
        break;
      case Order::kSolve:
        group.solve(nullptr, nullptr);
        break;
      case Order::kFailed:
        throw CommonFailure(group.give_text({}, order.size));
      default:
        return;
    }
  }
}

}  // namespace

void run_with_parallel_factor(const std::function<void(SystemFactor&)>& work,
                              ProcessGroup::Traffic& traffic) {
  FactorGroup group(traffic);
  if (group.rank() == 0) {
    lead(group, work);
  } else {
    serve(group);
  }
}

}  // namespace bipot
