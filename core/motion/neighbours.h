#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/motion/midpoint.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// What a time step asks of other processes where the bodies of a state lie on several
/// (solvers/simulation/domain.h). Each process detects, assembles and moves its own bodies and
/// contacts. One process is the case without neighbours. Everything but problem(), number(),
/// body_number() and counts_walls() is collective.
template <int D>
class Neighbours {
 public:
  virtual ~Neighbours() = default;

  /// Detects. Bodies of the midpoint are those of this process, and copies of others within reach.
  virtual Midpoint<D> midpoint() = 0;
  /// Assembles the problem of this process's contacts, and puts them into the midpoint. All but the
  /// problem is in the result, which holds until the next call.
  virtual const AssembledStep& assemble(Midpoint<D>& mid) = 0;
  virtual const ContactProblem& problem() const = 0;
  /// Solves it together with the problems of the others, from a start of its rows, or of size 0.
  virtual StepSolution solve(const Vector& s0) = 0;
  /// The bodies of this process and the walls after the step that was solved; `v`: velocities in
  /// the degrees of freedom of problem().
  virtual State<D> move(const Midpoint<D>& mid, Vector& v) = 0;
  /// Number in the whole of a body of this process, by its index in the state.
  virtual int body_number(int index) const = 0;
  /// Puts the numbers that its bodies have in the whole into a contact of the midpoint.
  virtual void number(Contact<D>& contact) const = 0;
  /// Sends bodies to the processes in whose cells they are after the step.
  virtual void settle() = 0;

  /// Walls stand on all processes; one of them counts what they add to sums.
  virtual bool counts_walls() const = 0;
  virtual bool all(bool mine) = 0;
  virtual void sum(std::span<double> values) = 0;
  virtual void largest(std::span<double> values) = 0;
  /// The numbers of all processes, one process after the other.
  virtual std::vector<double> gather(std::span<const double> mine) = 0;
  /// The text of the first process that has one; empty if none has.
  virtual std::string first_text(const std::string& mine) = 0;
};

}  // namespace bipot
