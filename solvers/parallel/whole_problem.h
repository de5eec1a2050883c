#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/criterion/rounding_bound.h"
#include "solvers/parallel/contact_owners.h"
#include "solvers/parallel/distributed_space.h"
#include "solvers/proved_claim.h"

namespace bipot {

/// The whole of a problem that lies on several processes: for solvers that run on the root process,
/// and for the proof of a claim where double precision is not enough. Everything is collective.
class WholeProblem {
 public:
  virtual ~WholeProblem() = default;
  WholeProblem(const WholeProblem&) = delete;
  WholeProblem& operator=(const WholeProblem&) = delete;

  /// On the first process; what the others get is nothing to rely on.
  virtual const ContactProblem& on_first() = 0;
  /// The rows of all processes in the order of the whole, on the first process.
  virtual Vector join(const Vector& part) = 0;
  /// The rows of each process of what the first one has.
  virtual Vector part(const Vector& whole) = 0;
  /// prove_claim() of the impulse s, rows that are here: the same answer on all processes.
  virtual ProvedClaim claim(const SolverOptions& options, const Vector& s,
                            const ContactError& error) = 0;

 protected:
  WholeProblem() = default;
};

/// Where every process has the whole. Join() leaves it on all of them, and all prove a claim.
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
  /// The rows of this process of what all of them have.
  Vector mine(const Vector& whole) const;

 private:
  const ContactProblem& whole_;
  const ContactOwners& owners_;
  ProcessGroup& group_;
};

/// Where nobody has the whole: the first process gathers it when it is asked for the first time. A
/// claim is proved in double precision by all, each with the bound of its contacts (core/problem/
/// rounding_bound.h), and only what that leaves open is gathered.
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

/// Where the whole of these pieces is wanted for itself: on the first process, elsewhere an empty
/// problem. Collective.
ContactProblem gather_problem(const ProblemPiece& piece, ProcessGroup& group);

/// rounding_bound() in double precision of the impulse s, rows that are here. Collective.
RoundingBound distributed_rounding_bound(DistributedSpace& space, const Vector& s);

}  // namespace bipot
