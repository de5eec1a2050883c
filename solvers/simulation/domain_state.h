#pragma once

#include <vector>

#include "core/motion/state.h"
#include "solvers/parallel/cell_tree.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// One process's part of a distributed state. A body belongs to the cell of its centre, a contact
/// to the process of its body i.
template <int D>
struct DomainState {
  int bodies = 0;            ///< of all processes
  std::vector<int> numbers;  ///< of the bodies here in the whole, ascending
  /// Bodies and contacts of this process. Contacts have the numbers of their bodies in the whole, j
  /// = bodies + wall for walls, sorted by (i, j). Time, walls and work are those of the whole.
  State<D> here;
};

/// A position in the dimensions of the cells.
template <int D>
Vec3 in_space(const Vec<D>& x) {
  Vec3 place = Vec3::Zero();
  place.template head<D>() = x;
  return place;
}

/// Cells for the bodies of a whole state, one for each process. Each body has weight 1 plus the
/// number of contacts whose first body it is. (Weights of contacts alone would put all flying
/// bodies, which also cost detection and motion, on the process beside the few contacts.)
template <int D>
CellTree cut_cells(const State<D>& whole, int processes);

/// The bodies and contacts of one cell. `whole` may be deleted afterwards.
template <int D>
DomainState<D> cut_state(const State<D>& whole, const CellTree& cells, int rank);

/// The whole on the root process, elsewhere a state without bodies and contacts; without clusters,
/// cells and populations. Collective. Throws CommonFailure if bodies are missing or doubled.
template <int D>
State<D> gather_state(const DomainState<D>& state, ProcessGroup& group);

/// New cells for the present bodies, the same on all processes: the root process gathers the
/// positions. Weights as above. Collective.
template <int D>
CellTree cut_cells_again(const DomainState<D>& state, ProcessGroup& group);

/// Moves bodies whose centres lie in other cells there, with their contacts. Returns the number
/// that left. Collective.
template <int D>
int migrate(const CellTree& cells, ProcessGroup& group, DomainState<D>& state);

}  // namespace bipot
