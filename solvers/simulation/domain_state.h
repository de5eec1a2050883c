#pragma once

#include <vector>

#include "core/motion/state.h"
#include "solvers/parallel/cell_tree.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// What one process has of a state that lies on several. A body belongs to the cell of its centre,
/// a contact to the process of its body i.
template <int D>
struct DomainState {
  int bodies = 0;            ///< of all processes
  std::vector<int> numbers;  ///< of the bodies here in the whole, ascending
  /// Bodies and contacts that are here, contacts with the numbers that their bodies have in the
  /// whole, j = bodies + wall for walls, sorted by (i, j). Time, walls and work are the whole's.
  State<D> here;
};

/// A place in as many dimensions as cells have.
template <int D>
Vec3 in_space(const Vec<D>& x) {
  Vec3 place = Vec3::Zero();
  place.template head<D>() = x;
  return place;
}

/// Cells for the bodies of a whole state, one a process; each body weighs 1 and the contacts that
/// it comes first in. (Contacts alone would leave bodies in flight, which are detected and moved
/// all the same, to whoever lies beside the few that touch.)
template <int D>
CellTree cut_cells(const State<D>& whole, int processes);

/// The bodies and contacts of one cell. `whole` may go afterwards.
template <int D>
DomainState<D> cut_state(const State<D>& whole, const CellTree& cells, int rank);

/// The whole on the first process, elsewhere a state without bodies and contacts; for clusters,
/// cells and populations there is no place. Collective. Throws CommonFailure where bodies are
/// missing or there twice.
template <int D>
State<D> gather_state(const DomainState<D>& state, ProcessGroup& group);

/// Cells for the bodies as they are now, by the first process, which gathers their places: the same
/// on all. Weights as above. Collective.
template <int D>
CellTree cut_cells_again(const DomainState<D>& state, ProcessGroup& group);

/// Bodies whose centres lie in other cells go there, with their contacts. Returns how many went
/// from here. Collective.
template <int D>
int migrate(const CellTree& cells, ProcessGroup& group, DomainState<D>& state);

}  // namespace bipot
