#pragma once

#include <optional>
#include <vector>

#include "core/criterion/rounding_bound.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/distributed_space.h"
#include "solvers/proved_claim.h"

namespace bipot {

/// The whole of a distributed problem: for solvers that run on the root process, and for the proof
/// of a claim if double precision is not enough. All is collective.
class WholeProblem {
 public:
  virtual ~WholeProblem() = default;
  WholeProblem(const WholeProblem&) = delete;
  WholeProblem& operator=(const WholeProblem&) = delete;

  /// On the root process; not valid on others.
  virtual const ContactProblem& on_first() = 0;
  /// The rows of all processes in the order of the whole, on the root process.
  virtual Vector join(const Vector& part) = 0;
  /// The rows of each process, from those of the whole on the root process.
  virtual Vector part(const Vector& whole) = 0;
  /// prove_claim() of the impulse s, in the rows of this process: the same result on all processes.
  virtual ProvedClaim claim(const SolverOptions& options, const Vector& s,
                            const ContactError& error) = 0;

 protected:
  WholeProblem() = default;
};

/// If every process has the whole. join() leaves it on all of them, and all prove a claim.
class KnownWhole : public WholeProblem {
 public:
  /// Keeps references.
  KnownWhole(const ContactProblem& whole, const ContactOwners& owners, ProcessGroup& group)
      : whole_(whole), owners_(owners), group_(group) {}

  const ContactProblem& on_first() override { return whole_; }
  Vector join(const Vector& part) override;
  Vector part(const Vector& whole) override;
  ProvedClaim claim(const SolverOptions& options, const Vector& s,
                    const ContactError& error) override {
    return prove_claim(whole_, options, join(s), error);
  }
  /// The rows of this process, from those of the whole on all of them.
  Vector mine(const Vector& whole) const;

 private:
  const ContactProblem& whole_;
  const ContactOwners& owners_;
  ProcessGroup& group_;
};

/// If no process has the whole: the root process gathers it at the first request. A claim is proved
/// in double precision by all, each with the bound of its contacts
/// (core/criterion/rounding_bound.h). The whole is gathered only if that is not enough.
class GatheredWhole : public WholeProblem {
 public:
  /// Keeps the reference.
  explicit GatheredWhole(DistributedSpace& space) : space_(space) {}

  const ContactProblem& on_first() override;
  Vector join(const Vector& part) override;
  Vector part(const Vector& whole) override;
  ProvedClaim claim(const SolverOptions& options, const Vector& s,
                    const ContactError& error) override;

 private:
  DistributedSpace& space_;
  std::optional<ContactProblem> whole_;   // empty problem on all but the first process
  std::vector<std::vector<int>> number_;  // on the first: of each process's contacts
};

/// Gathers the whole of these parts for its own sake: on the root process, elsewhere an empty
/// problem. Collective.
ContactProblem gather_problem(const ProblemPiece& piece, ProcessGroup& group);

/// rounding_bound() in double precision of the impulse s, in the rows of this process. Collective.
RoundingBound distributed_rounding_bound(DistributedSpace& space, const Vector& s);

}  // namespace bipot
