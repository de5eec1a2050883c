#pragma once

#include "core/files/hdf5_file.h"
#include "core/motion/state.h"

namespace bipot {

/// Writes the definition of width, height and offset of a periodic cell (3D: width and depth):
/// motion, stress and mass of each. Throws FileError.
void write_cell_definition(Hdf5File& file, const PeriodicCell& cell);

/// Writes the cell of a state, its outline as lines, and the places of the bodies. The bodies must
/// lie in the cell (wrapped_state). Throws FileError.
template <int D>
void write_cell(Hdf5File& frame, const State<D>& inside);

}  // namespace bipot
