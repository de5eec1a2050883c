#pragma once

#include "solvers/kernels/contact_sweep.h"
#include "solvers/solve_run.h"

namespace bipot {

/// Jacobi sweeps: s_c <- update(c, s_c, u_c) for all contacts, with the velocities of the iterate
/// before. `step` goes into the history.
template <int D, class Update>
void iterate_jacobi(SolveRun& run, double step, const Update& update) {
  const ContactProblem& p = run.problem();
  Vector s = run.start(), u(p.num_rows());
  for (int iteration = 0; !run.stop(iteration, s, step); ++iteration) {
    run.space().velocity(s, u);
    for (int c = 0; c < p.num_contacts(); ++c) {
      s.segment<D>(c * D) = update(c, local<D>(s, c), local<D>(u, c));
    }
  }
}

/// Gauss-Seidel sweeps: the same with velocities updated after each contact.
template <int D, class Update>
void iterate_gauss_seidel(SolveRun& run, double step, const Update& update) {
  const ContactProblem& p = run.problem();
  with_sweep<D>(p, run.delassus(), [&](auto sweep) {
    sweep.reset(run.start());
    int iteration = 0;
    while (!(run.due(iteration) && run.stop(iteration, sweep.impulse(), step))) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        sweep.set(c, update(c, sweep.impulse(c), sweep.velocity(c)));
      }
      ++iteration;
    }
  });
}

}  // namespace bipot
