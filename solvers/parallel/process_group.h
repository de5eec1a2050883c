#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/number_buffer.h"
#include "core/linear/system_factor.h"
#include "solvers/contact_space.h"

namespace bipot {

/// The processes that work on one problem. There are two implementations: for a single process,
/// without effect (lone_process()), and on MPI through PETSc (petsc_group.h), the only code that
/// knows MPI. All but rank(), size() and traffic() is collective. Sums of doubles are taken by
/// rank, so that the same processes get the same bits again, all of them the same.
class ProcessGroup {
 public:
  /// Messages of one process and number of collective calls. Counted, not measured: the same on
  /// every machine.
  struct Traffic {
    std::int64_t messages = 0;       ///< to single other processes
    std::int64_t bytes = 0;          ///< in these
    std::int64_t reductions = 0;     ///< in which all take part
    std::int64_t reduced_bytes = 0;  ///< part of this process in them

    void append_to(Buffer& numbers) const {
      append(numbers, messages, bytes, reductions, reduced_bytes);
    }
    void read(BufferReader& numbers) { numbers.take(messages, bytes, reductions, reduced_bytes); }
    /// Adds the difference of two readings.
    void add_since(const Traffic& before, const Traffic& now) {
      messages += now.messages - before.messages;
      bytes += now.bytes - before.bytes;
      reductions += now.reductions - before.reductions;
      reduced_bytes += now.reduced_bytes - before.reduced_bytes;
    }
  };
  /// An item that is here as a copy of one that belongs to a process.
  struct RemoteItem {
    int owner = 0;     ///< rank
    int original = 0;  ///< the item's number among the owner's originals
  };
  /// Exchange of items that have one original each, with its owner, and copies on other processes.
  /// Collective: every process of the group calls, with the same block.
  class Exchange {
   public:
    virtual ~Exchange() = default;
    Exchange(const Exchange&) = delete;
    Exchange& operator=(const Exchange&) = delete;

    /// Each copy is set to its original. `block` values for each item.
    virtual void copy(std::span<const double> originals, std::span<double> copies, int block) = 0;

   protected:
    Exchange() = default;
  };
  virtual ~ProcessGroup() = default;
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;

  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual void sum(std::span<double> values) = 0;
  virtual void sum(std::span<std::int64_t> values) = 0;
  virtual void largest(std::span<double> values) = 0;
  /// The values of all processes, rank after rank, on every process.
  virtual std::vector<double> gather(std::span<const double> mine) = 0;
  /// Buffer r of each process goes to process r; returned are those for this process, by sender. A
  /// buffer to itself is no message. The others learn its size first: one more reduction
  /// (Traffic::reductions), with a number for each process.
  virtual std::vector<Buffer> deliver(std::vector<Buffer> buffers) = 0;
  /// The text of the lowest rank that has one, on every process; empty if none has.
  virtual std::string first_text(const std::string& mine) = 0;
  /// `originals`: number of items that this process owns.
  virtual std::unique_ptr<Exchange> make_exchange(int originals,
                                                  std::span<const RemoteItem> copies) = 0;
  /// The root process (rank 0) does `work`, with a factor whose factorisations and solves run in
  /// parallel; the others serve it until the work is done. An exception of the work is a
  /// CommonFailure on all of them.
  virtual void run_on_root(const std::function<void(SystemFactor&)>& work) = 0;
  /// Threads that the work may use: the cores of the processes of its machine, which then wait.
  virtual int root_threads() const { return 1; }

  /// True if `mine` is true on any process.
  bool any(bool mine) {
    double value = mine ? 1 : 0;
    largest({&value, 1});
    return value > 0;
  }
  /// Throws CommonFailure on every process if any has a reason.
  void fail_where_any(const std::string& reason) {
    if (const std::string first = first_text(reason); !first.empty()) throw CommonFailure(first);
  }
  const Traffic& traffic() const { return *traffic_; }

 protected:
  ProcessGroup() = default;
  /// Counts a reduction to which this process gives so many bytes.
  void count(std::size_t bytes) {
    ++traffic_->reductions;
    traffic_->reduced_bytes += static_cast<std::int64_t>(bytes);
  }
  std::shared_ptr<Traffic> traffic_ = std::make_shared<Traffic>();
};

/// A group of one: sums are unchanged, and copies are those of its own items.
std::unique_ptr<ProcessGroup> lone_process();

}  // namespace bipot
