#pragma once

#include <type_traits>

#include "solvers/kernels/local_updates.h"
#include "solvers/parallel/distributed_space.h"
#include "solvers/solve_run.h"

namespace bipot {

// Gauss-Seidel sweeps over the contacts of this process. In parallel all processes sweep at once
// over their contacts, with the velocities that the others left. A body shared by n processes
// counts in each sweep with 1/n of its mass (mass splitting: Tonge, Benevolenski and Voroshilov,
// ACM Trans. Graph. 31, 2012). For mu = 0 that converges whenever Gauss-Seidel does
// (data/manual/explanation/parallel.md). With friction it is not proved, as on one process. The
// iterates depend on the number of processes; one sweep is one exchange.

/// True if sweeps can follow the velocities of these contacts: disks, or at most two bodies each.
template <int D>
bool can_sweep(const ContactProblem& split) {
  constexpr int kPlanar = D == 1 ? 2 : 3;
  return split.num_contacts() == 0 || TwoPassSweep<D, kPlanar>::fits(split) ||
         TwoPassSweep<D, 6>::fits(split);
}

/// The contacts of this process, with the masses of their bodies divided among the processes that
/// share them.
inline ContactProblem split_masses(const ProblemPiece& piece) {
  ContactProblem split = piece.own;
  for (int dof = 0; dof < split.num_dofs(); ++dof) {
    split.A.coeffRef(dof, dof) /= piece.sharers[to_size(dof)];
  }
  return split;
}

/// Calls f(sweep, visit, meet) with the sweep of this process: as with_local_updates(), and meet()
/// reads the velocities of the other processes.
template <ContactRows D, class F>
void with_split_sweep(DistributedSpace& space, const LocalSettings& settings, F&& f) {
  const ContactProblem split = split_masses(space.piece());
  space.group().fail_where_any(
      can_sweep<D>(split) ? "" : "sweeps on several processes need contacts of one or two bodies");
  if (split.num_contacts() == 0) {
    // An empty sweep: the others wait for this process's part in sums and exchanges.
    DiskSweep<D> nothing(split, DiskStructure{{}, {DiskStructure::Body{}}});
    Vector u;
    f(
        nothing, [](int) {}, [&] { space.velocity(nothing.impulse(), u); });
    return;
  }
  const DelassusOperator delassus(split, DelassusOperator::Form::kTwoPass);
  with_local_updates<D>(split, delassus, settings, false, [&](auto& sweep, auto visit) {
    // can_sweep() excludes the explicit form.
    if constexpr (!std::is_same_v<std::decay_t<decltype(sweep)>, ExplicitSweep<D>>) {
      Vector u;
      f(sweep, visit, [&] {
        space.velocity(sweep.impulse(), u);
        for (int c = 0; c < split.num_contacts(); ++c) {
          sweep.shift(c, local<D>(u, c) - sweep.velocity(c));
        }
      });
    }
  });
}

/// Calls f(sweep, visit, meet) with the fastest sweep that the run's problem allows.
template <ContactRows D, class F>
void with_sweep_of(SolveRun& run, const LocalSettings& settings, bool explicit_delassus, F&& f) {
  if (DistributedSpace* const parts = run.space().parts()) {
    return with_split_sweep<D>(*parts, settings, f);
  }
  with_local_updates<D>(run.problem(), run.delassus(), settings, explicit_delassus,
                        [&](auto& sweep, auto visit) { f(sweep, visit, [] {}); });
}

}  // namespace bipot
