#pragma once

#include <functional>

#include "solvers/simulation/domain_stepper.h"
#include "solvers/simulation/run_folder.h"

namespace bipot {

template <int D>
struct DomainRunOptions {
  int steps = 0;
  typename DomainStepper<D>::Solver solver;
  std::function<bool()> cancelled;  ///< the same on all; polled before each step
  std::function<void(const DomainReport<D>&)> on_step;  ///< on all
  /// On the first process: a step that did not converge, with the whole of it; the first one alone.
  std::function<void(const SceneStep<D>&)> on_unsolved;
  RunFolderOptions folder;  ///< the first process writes there; empty: nobody does
};

/// run_scene_into() for a state that lies on several processes: the same files, the same totals.
/// `state`: the whole on all processes; at the end that of the last whole step on the first one,
/// and elsewhere without bodies and contacts, as on all in between. It is gathered where a frame, a row of the ledger or of the
/// trajectories is due. `counts`: of all processes. Collective; the first process alone may throw FileError.
template <int D>
SceneRun<D> run_domains(const Scene<D>& scene, State<D>& state, const DomainRunOptions<D>& options,
                        ProcessGroup& group, DomainCounts& counts);

}  // namespace bipot
