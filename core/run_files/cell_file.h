#pragma once

#include "core/files/hdf5_file.h"
#include "core/motion/state.h"

namespace bipot {

/// Width, height and offset of a periodic cell (in space width and depth): how each moves, the stress on it, its
/// mass. Throws FileError.
void write_cell_definition(Hdf5File& file, const PeriodicCell& cell);

/// The cell of a state whose bodies are in it (wrapped_state), its outline as lines, and the places of the bodies.
/// Throws FileError.
template <int D>
void write_cell(Hdf5File& frame, const State<D>& inside);

}  // namespace bipot
