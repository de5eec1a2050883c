#pragma once

#include <string>
#include <vector>

#include "core/files/hdf5_file.h"
#include "core/motion/population.h"
#include "core/motion/state.h"

namespace bipot {

/// Writes the definition of width, height and offset of a periodic cell (3D: width and depth):
/// motion, stress and mass of each. Throws FileError.
void write_cell_definition(Hdf5File& file, const PeriodicCell& cell);

/// Writes the cell of a state, its outline as lines, and the places of the bodies. The bodies must
/// lie in the cell (wrapped_state). Throws FileError.
template <int D>
void write_cell(Hdf5File& frame, const State<D>& inside);

/// Writes the clusters of a state and their bodies: /clusters/*, /bodies/cluster, /bodies/arm of a
/// frame. Throws FileError.
template <int D>
void write_clusters(Hdf5File& frame, const State<D>& state);

/// Reads them into a state that has its bodies; nothing if the frame has no clusters. Throws
/// FileError.
template <int D>
void read_clusters(const Hdf5File& frame, State<D>& state);

/// Writes radius, mass, inertia and material of the bodies, and their walls if `any_glued`. Throws
/// FileError.
template <int D>
void write_body_constants(Hdf5File& file, const std::vector<Body<D>>& bodies, bool any_glued);

/// Reads them. Throws FileError.
template <int D>
void read_body_constants(const Hdf5File& file, std::vector<Body<D>>& bodies);

/// Writes the additional entries of a frame in scenes with outlets or inlets. They are number,
/// radius, mass, inertia, material and wall of each body, and what has gone through each gate.
/// Throws FileError.
template <int D>
void write_population(Hdf5File& frame, const State<D>& state);

/// Reads them; false, and nothing set, if the frame has none. Throws FileError.
template <int D>
bool read_population(const Hdf5File& frame, std::vector<Body<D>>& bodies,
                     Population<D>& population);

/// Writes what moves walls beside their velocity: forces, spins and belts; the last two if a wall of
/// the `scene` has them. Run.h5 has those of the scene, frames those of that moment where a wall has
/// a schedule. Throws FileError.
template <int D>
void write_wall_drives(Hdf5File& file, const std::vector<Wall<D>>& walls,
                       const std::vector<Wall<D>>& scene);

/// Writes the body in run.h5 for frames without bodies: radius 0, at x, at rest. Readers of
/// run.xdmf need at least one.
template <int D>
void write_no_body(Hdf5File& file, const Vec<D>& x);

/// Names and units of the columns of gates.csv, and the row of a state.
template <int D>
std::string gates_header(const Scene<D>& scene);
template <int D>
std::string gates_row(const Scene<D>& scene, const State<D>& state);

/// Gives the datasets of run.h5 or of a frame the attribute `description`: meaning, signs, codes and
/// the rules of the indices. Each dataset with a unit has one. Throws FileError.
void add_descriptions(Hdf5File& file);

}  // namespace bipot
