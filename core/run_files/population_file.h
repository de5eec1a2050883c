#pragma once

#include <string>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/motion/population.h"

namespace bipot {

/// What a frame has besides in scenes with outlets or inlets: number, radius, mass, inertia, material and wall of
/// each body, for they differ from frame to frame, and what has gone through each gate. Throws
/// FileError.
template <int D>
void write_population(Hdf5File& frame, const State<D>& state);

/// The same back; false, and nothing set, where a frame has no such entries. `bodies`: as many as the frame has,
/// but for place and motion. Throws FileError.
template <int D>
bool read_population(const Hdf5File& frame, std::vector<Body<D>>& bodies,
                     Population<D>& population);

/// Stands in run.h5 for the bodies of a frame that has none: one of radius 0 at x, at rest. Readers
/// of run.xdmf stumble over nothing.
template <int D>
void write_no_body(Hdf5File& file, const Vec<D>& x);

/// gates.csv: names and units of its columns, and the row of a state.
template <int D>
std::string gates_header(const Scene<D>& scene);
template <int D>
std::string gates_row(const Scene<D>& scene, const State<D>& state);

}  // namespace bipot
