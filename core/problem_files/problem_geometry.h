#pragma once

#include <filesystem>
#include <optional>

#include "core/motion/state.h"

namespace bipot {

/// Where the contacts of a problem lie, so that it can be drawn: what a run knows of a step besides
/// the numbers that solvers see. Contact k of the problem is state.contacts[k].contact.
struct ProblemGeometry {
  Scene<2> scene;  ///< walls, step and gravity alone; one material, with friction where dim > 1
  State<2>
      state;  ///< after the step: centres and radii of the disks, ends of the walls, contacts without impulses
};

/// Adds the group /bipot/geometry to an existing FCLIB file, which other readers pass over: disks/x,
/// disks/radius, walls/{shape,a,b,normal}, contacts/{i,j,n}, step, number, time. Throws FileError.
void write_geometry(const std::filesystem::path& path, const Scene<2>& scene,
                    const State<2>& state);

/// Nothing where the file has no such group (or is no HDF5 file). `contacts`: of the problem. Throws
/// FileError where the group does not fit them.
std::optional<ProblemGeometry> read_geometry(const std::filesystem::path& path, int contacts);

}  // namespace bipot
