#pragma once

#include "solvers/kernels/contact_sweep.h"
#include "solvers/monitor.h"

namespace bipot {

/// Jacobi sweeps: s_c <- update(c, s_c, u_c) for all contacts, with the velocities of the iterate
/// before. `step` goes into the history.
template <int D, class Update>
void iterate_jacobi(const ContactProblem& p, const DelassusOperator& delassus, Vector s,
                    double step, IterationMonitor& monitor, const Update& update) {
  Vector u(p.num_rows());
  for (int iteration = 0; !monitor.stop(iteration, s, step); ++iteration) {
    delassus.velocity(s, u);
    for (int c = 0; c < p.num_contacts(); ++c) {
      s.segment<D>(c * D) = update(c, local<D>(s, c), local<D>(u, c));
    }
  }
}

/// Gauss-Seidel sweeps: the same with velocities updated after each contact.
template <int D, class Update>
void iterate_gauss_seidel(const ContactProblem& p, const Vector& s0, double step,
                          IterationMonitor& monitor, const Update& update) {
  with_sweep<D>(p, [&](auto sweep) {
    sweep.reset(s0);
    int iteration = 0;
    while (!(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), step))) {
      for (int c = 0; c < p.num_contacts(); ++c) {
        sweep.set(c, update(c, sweep.impulse(c), sweep.velocity(c)));
      }
      ++iteration;
    }
  });
}

}  // namespace bipot
