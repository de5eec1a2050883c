#pragma once

#include <functional>

#include "bench/scenes/run_folder.h"
#include "solvers/domains/domain_stepper.h"

namespace bipot {

template <int D>
struct DomainRunOptionsIn {
  int steps = 0;
  typename DomainStepperIn<D>::Solver solver;
  std::function<bool()> cancelled;  ///< the same on all; polled before each step
  std::function<void(const DomainReportIn<D>&)> on_step;  ///< on all
  /// On the first process: a step that did not converge, with the whole of it; the first one alone.
  std::function<void(const SceneStepIn<D>&)> on_unsolved;
  RunFolderOptions folder;  ///< the first process writes there; empty: nobody does
};

/// run_scene_into() for a state that lies on several processes: the same files, the same totals.
/// `state`: the whole on all processes; at the end that of the last whole step on the first one,
/// and elsewhere without bodies and contacts, as on all in between. It is gathered where a frame, a row of the ledger or of the
/// trajectories is due. `counts`: of all processes. Collective; the first process alone may throw FileError.
template <int D>
SceneRunIn<D> run_domains(const SceneIn<D>& scene, StateIn<D>& state,
                          const DomainRunOptionsIn<D>& options, ProcessGroup& group,
                          DomainCounts& counts);

}  // namespace bipot
