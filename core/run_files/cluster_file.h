#pragma once

#include "core/files/hdf5_file.h"
#include "core/motion/state.h"

namespace bipot {

/// Writes the clusters of a state and their disks: /clusters/*, /disks/cluster, /disks/arm of a
/// frame. Throws FileError.
void write_clusters(Hdf5File& frame, const State<2>& state);

/// Reads them into a state that has its disks; nothing if the frame has no clusters. Throws
/// FileError.
void read_clusters(const Hdf5File& frame, State<2>& state);

}  // namespace bipot
