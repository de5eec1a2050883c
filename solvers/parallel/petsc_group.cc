#include "solvers/parallel/petsc_group.h"

#include <petscsf.h>
#include <sched.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "core/base/types.h"
#include "solvers/parallel/parallel_factor.h"
#include "solvers/petsc/petsc_session.h"

namespace bipot {
namespace {

/// Items of `block` doubles.
class BlockType {
 public:
  explicit BlockType(int block) {
    BIPOT_MPI(MPI_Type_contiguous, block, MPI_DOUBLE, &type_);
    BIPOT_MPI(MPI_Type_commit, &type_);
  }
  ~BlockType() { MPI_Type_free(&type_); }
  BlockType(const BlockType&) = delete;
  BlockType& operator=(const BlockType&) = delete;
  MPI_Datatype get() const { return type_; }

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

class ForestExchange : public ProcessGroup::Exchange {
 public:
  ForestExchange(int originals, std::span<const ProcessGroup::RemoteItem> copies,
                 std::shared_ptr<ProcessGroup::Traffic> traffic)
      : traffic_(std::move(traffic)) {
    BIPOT_PETSC(PetscSFCreate, PETSC_COMM_WORLD, &forest_);
    std::vector<PetscSFNode> remote;
    for (const ProcessGroup::RemoteItem& item : copies)
      remote.push_back({item.owner, item.original});
    BIPOT_PETSC(PetscSFSetGraph, forest_, originals, static_cast<PetscInt>(remote.size()), nullptr,
                PETSC_COPY_VALUES, remote.data(), PETSC_COPY_VALUES);
    BIPOT_PETSC(PetscSFSetUp, forest_);
    int rank = 0;
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
    const PetscMPIInt* ranks = nullptr;
    const PetscInt* offsets = nullptr;
    PetscMPIInt count = 0;
    BIPOT_PETSC(PetscSFGetLeafRanks, forest_, &count, &ranks, &offsets, nullptr);
    for (int k = 0; k < count; ++k) {
      if (ranks[k] == rank || offsets[k + 1] == offsets[k]) continue;
      ++messages_;
      items_ += offsets[k + 1] - offsets[k];
    }
  }
  ~ForestExchange() override { PetscSFDestroy(&forest_); }

  void copy(std::span<const double> originals, std::span<double> copies, int block) override {
    const MPI_Datatype type = type_of(block);
    BIPOT_PETSC(PetscSFBcastBegin, forest_, type, originals.data(), copies.data(), MPI_REPLACE);
    BIPOT_PETSC(PetscSFBcastEnd, forest_, type, originals.data(), copies.data(), MPI_REPLACE);
    traffic_->messages += messages_;
    traffic_->bytes += items_ * block * static_cast<std::int64_t>(sizeof(double));
  }

 private:
  /// The forest keeps the packing of each type that it has seen.
  MPI_Datatype type_of(int block) {
    if (block == 1) return MPI_DOUBLE;
    while (types_.size() < to_size(block)) {
      types_.push_back(std::make_unique<BlockType>(static_cast<int>(types_.size()) + 1));
    }
    return types_[to_size(block) - 1]->get();
  }

  PetscSF forest_ = nullptr;
  std::shared_ptr<ProcessGroup::Traffic> traffic_;
  std::int64_t messages_ = 0, items_ = 0;  // that leave here with each copy
  std::vector<std::unique_ptr<BlockType>> types_;
};

/// Cores that the processes of this machine may use. mpirun mostly binds each to one.
class MachineCores {
 public:
  /// Collective.
  MachineCores() {
    MPI_Comm machine = MPI_COMM_NULL;
    BIPOT_MPI(MPI_Comm_split_type, PETSC_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL,
              &machine);
    known_ = sched_getaffinity(0, sizeof own_, &own_) == 0;
    if (!known_) CPU_ZERO(&own_);
    BIPOT_MPI(MPI_Allreduce, &own_, &all_, sizeof own_, MPI_BYTE, MPI_BOR, machine);
    int processes = 1;
    MPI_Comm_size(machine, &processes);
    MPI_Comm_free(&machine);
    threads_ = std::max(1, std::min(processes, CPU_COUNT(&all_)));
  }
  /// One for each process, if there are so many cores.
  int threads() const { return threads_; }

  /// During its life, this thread and those that it starts may use the cores of all.
  class Borrowed {
   public:
    explicit Borrowed(const MachineCores& of) : of_(of) { allow(of.all_); }
    ~Borrowed() { allow(of_.own_); }
    Borrowed(const Borrowed&) = delete;
    Borrowed& operator=(const Borrowed&) = delete;

   private:
    /// Without permission all stays as it is, and is slower.
    void allow(const cpu_set_t& cores) const {
      if (of_.known_) (void)sched_setaffinity(0, sizeof cores, &cores);
    }
    const MachineCores& of_;
  };

 private:
  cpu_set_t own_, all_;
  bool known_ = false;
  int threads_ = 1;
};

class PetscGroup : public ProcessGroup {
 public:
  PetscGroup() {
    MPI_Comm_rank(PETSC_COMM_WORLD, &rank_);
    MPI_Comm_size(PETSC_COMM_WORLD, &size_);
  }
  int rank() const override { return rank_; }
  int size() const override { return size_; }

  // Gathered and summed by rank here: MPI_Allreduce may change the order from call to call.
  void sum(std::span<double> values) override {
    const int items = static_cast<int>(values.size());
    blocks_.resize(values.size() * to_size(size_));
    BIPOT_MPI(MPI_Allgather, values.data(), items, MPI_DOUBLE, blocks_.data(), items, MPI_DOUBLE,
              PETSC_COMM_WORLD);
    count(values.size_bytes());
    for (std::size_t k = 0; k < values.size(); ++k) {
      double total = 0;
      for (std::size_t r = 0; r < to_size(size_); ++r) total += blocks_[r * values.size() + k];
      values[k] = total;
    }
  }
  void sum(std::span<std::int64_t> values) override {
    BIPOT_MPI(MPI_Allreduce, MPI_IN_PLACE, values.data(), static_cast<int>(values.size()),
              MPI_INT64_T, MPI_SUM, PETSC_COMM_WORLD);
    count(values.size_bytes());
  }
  void largest(std::span<double> values) override {
    BIPOT_MPI(MPI_Allreduce, MPI_IN_PLACE, values.data(), static_cast<int>(values.size()),
              MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD);
    count(values.size_bytes());
  }
  std::vector<double> gather(std::span<const double> mine) override {
    return gather_all<std::vector<double>>(mine, MPI_DOUBLE).first;
  }
  std::vector<Buffer> deliver(std::vector<Buffer> buffers) override {
    std::vector<int> sizes(to_size(size_), 0), coming(to_size(size_), 0);
    for (std::size_t r = 0; r < sizes.size(); ++r) {
      if (buffers.at(r).size() > to_size(std::numeric_limits<int>::max())) {
        throw std::runtime_error("MPI: more than 2^31 values in a message");
      }
      sizes[r] = static_cast<int>(buffers[r].size());
    }
    BIPOT_MPI(MPI_Alltoall, sizes.data(), 1, MPI_INT, coming.data(), 1, MPI_INT, PETSC_COMM_WORLD);
    count(to_size(size_) * sizeof(int));
    std::vector<Buffer> received(to_size(size_));
    std::vector<MPI_Request> requests;
    for (int r = 0; r < size_; ++r) {
      Buffer& from = received[to_size(r)];
      if (r == rank_) {
        from = std::move(buffers[to_size(r)]);
      } else if (coming[to_size(r)] > 0) {
        from.resize(to_size(coming[to_size(r)]));
        BIPOT_MPI(MPI_Irecv, from.data(), coming[to_size(r)], MPI_DOUBLE, r, kBufferTag,
                  PETSC_COMM_WORLD, &requests.emplace_back());
      }
    }
    for (int r = 0; r < size_; ++r) {
      const Buffer& to = buffers[to_size(r)];
      if (r == rank_ || to.empty()) continue;
      BIPOT_MPI(MPI_Isend, to.data(), sizes[to_size(r)], MPI_DOUBLE, r, kBufferTag,
                PETSC_COMM_WORLD, &requests.emplace_back());
      ++traffic_->messages;
      traffic_->bytes += static_cast<std::int64_t>(to.size() * sizeof(double));
    }
    BIPOT_MPI(MPI_Waitall, static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
    return received;
  }
  std::string first_text(const std::string& mine) override {
    const auto [all, starts] = gather_all<std::string>(mine, MPI_CHAR);
    for (std::size_t r = 0; r + 1 < starts.size(); ++r) {
      const int size = starts[r + 1] - starts[r];
      if (size > 0) return all.substr(to_size(starts[r]), to_size(size));
    }
    return {};
  }
  std::unique_ptr<ProcessGroup::Exchange> make_exchange(
      int originals, std::span<const ProcessGroup::RemoteItem> copies) override {
    return std::make_unique<ForestExchange>(originals, copies, traffic_);
  }
  void run_on_root(const std::function<void(SystemFactor&)>& work) override {
    const auto led = [&](SystemFactor& factor) {
      const MachineCores::Borrowed cores(cores_);
      work(factor);
    };
    run_with_parallel_factor(led, *traffic_);
  }
  int root_threads() const override { return cores_.threads(); }

 private:
  /// The values of all processes, and the start of each one's with the end.
  template <class Values>
  std::pair<Values, std::vector<int>> gather_all(std::span<const typename Values::value_type> mine,
                                                 MPI_Datatype type) {
    const auto own = static_cast<std::int64_t>(mine.size());
    std::vector<std::int64_t> sizes(to_size(size_));
    BIPOT_MPI(MPI_Allgather, &own, 1, MPI_INT64_T, sizes.data(), 1, MPI_INT64_T, PETSC_COMM_WORLD);
    std::vector<int> counts, starts{0};
    std::int64_t end = 0;
    for (const std::int64_t size : sizes) {
      end += size;
      if (end > std::numeric_limits<int>::max()) {
        throw std::runtime_error("MPI: more than 2^31 values to gather");
      }
      counts.push_back(static_cast<int>(size));
      starts.push_back(static_cast<int>(end));
    }
    Values all(to_size(starts.back()), {});
    BIPOT_MPI(MPI_Allgatherv, mine.data(), static_cast<int>(mine.size()), type, all.data(),
              counts.data(), starts.data(), type, PETSC_COMM_WORLD);
    count(mine.size_bytes());
    return {std::move(all), std::move(starts)};
  }

  static constexpr int kBufferTag = 4711;  // PETSc takes its tags from a communicator of its own
  int rank_ = 0, size_ = 1;
  const MachineCores cores_;
  std::vector<double> blocks_;
};

}  // namespace

std::unique_ptr<ProcessGroup> petsc_group() {
  // PETSc stays initialised; the session's lock is released, for solvers that use PETSc alone.
  { const PetscSession start(PetscOptions("", "")); }
  return std::make_unique<PetscGroup>();
}

void abort_mpi(int exit_code) {
  int alive = 0, finalised = 0;
  MPI_Initialized(&alive);
  MPI_Finalized(&finalised);
  if (alive && !finalised) MPI_Abort(MPI_COMM_WORLD, exit_code);
}

}  // namespace bipot
