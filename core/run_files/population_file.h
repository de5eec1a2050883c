#pragma once

#include <string>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/motion/population.h"

namespace bipot {

/// Writes the additional entries of a frame in scenes with outlets or inlets. They are number,
/// radius, mass, inertia, material and wall of each body, and what has gone through each gate.
/// Throws FileError.
template <int D>
void write_population(Hdf5File& frame, const State<D>& state);

/// Reads them; false, and nothing set, if the frame has none. `bodies`: one for each body of the
/// frame, whose place and motion are set already. Throws FileError.
template <int D>
bool read_population(const Hdf5File& frame, std::vector<Body<D>>& bodies,
                     Population<D>& population);

/// Writes the body in run.h5 for frames without bodies: radius 0, at x, at rest. Readers of
/// run.xdmf need at least one.
template <int D>
void write_no_body(Hdf5File& file, const Vec<D>& x);

/// Names and units of the columns of gates.csv, and the row of a state.
template <int D>
std::string gates_header(const Scene<D>& scene);
template <int D>
std::string gates_row(const Scene<D>& scene, const State<D>& state);

}  // namespace bipot
