#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/linear/system_factor.h"
#include "solvers/contact_space.h"

namespace bipot {

/// What one process sent and how often all of them met. Counted, not measured: the same on every
/// machine.
struct Traffic {
  std::int64_t messages = 0;       ///< to single other processes
  std::int64_t bytes = 0;          ///< in these
  std::int64_t reductions = 0;     ///< in which all take part
  std::int64_t reduced_bytes = 0;  ///< what this process put into them

  /// Adds what came between two readings.
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

/// Numbers for one process, or from one: as many as there are.
using Parcel = std::vector<double>;

/// Items of which each has one original, with its owner, and copies wherever they are needed.
/// Collective: every process of the group calls, with the same block.
class Exchange {
 public:
  virtual ~Exchange() = default;
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  /// Each copy becomes what its original is. `block` values an item.
  virtual void copy(std::span<const double> originals, std::span<double> copies, int block) = 0;
  /// Each copy is added to its original; in an order that depends on the graph alone.
  virtual void add(std::span<const double> copies, std::span<double> originals, int block) = 0;

 protected:
  Exchange() = default;
};

/// The processes that work on one problem. One implementation for a lone process, which does
/// nothing (lone_process()), one on MPI through PETSc (petsc_group.h): nobody else knows MPI.
/// Everything but rank(), size() and traffic() is collective. Sums of doubles are taken by rank, so
/// that the same processes get the same bits again, all of them the same.
class ProcessGroup {
 public:
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
  /// Parcel r of each process goes to process r; returned are those for this process, by sender.
  /// What a process sends itself is no message. The others are told first how much comes: one more
  /// meeting of all (Traffic::reductions), with a number for each process.
  virtual std::vector<Parcel> deliver(std::vector<Parcel> parcels) = 0;
  /// The text of the lowest rank that has one, on every process; empty where none has.
  virtual std::string first_text(const std::string& mine) = 0;
  /// `originals`: how many this process owns.
  virtual std::unique_ptr<Exchange> make_exchange(int originals,
                                                  std::span<const RemoteItem> copies) = 0;
  /// The root process (rank 0) does `work`, with a factor whose factorisations and solves run on
  /// all processes; the others serve it until the work is done. An exception of the work is a
  /// CommonFailure on all of them.
  virtual void run_on_root(const std::function<void(SystemFactor&)>& work) = 0;

  /// Whether any process says so.
  bool any(bool mine) {
    double value = mine ? 1 : 0;
    largest({&value, 1});
    return value > 0;
  }
  /// Throws CommonFailure on every process where any has a reason.
  void fail_where_any(const std::string& reason) {
    if (const std::string first = first_text(reason); !first.empty()) throw CommonFailure(first);
  }
  const Traffic& traffic() const { return *traffic_; }

 protected:
  ProcessGroup() = default;
  std::shared_ptr<Traffic> traffic_ = std::make_shared<Traffic>();
};

/// A group of one: sums are what they were, and there is nothing to copy but one's own.
std::unique_ptr<ProcessGroup> lone_process();

}  // namespace bipot
