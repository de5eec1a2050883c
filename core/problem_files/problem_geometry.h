#pragma once

#include <filesystem>
#include <optional>

#include "core/motion/state.h"

namespace bipot {

/// Positions of the contacts of a problem, for drawings. Contact k of the problem is
/// state.contacts[k].contact.
struct ProblemGeometry {
  Scene<2> scene;  ///< walls, step and gravity alone; one material, with friction where dim > 1
  /// After the step: centres and radii of disks, ends of walls, contacts without impulses.
  State<2> state;
};

/// Adds the group /bipot/geometry to an existing FCLIB file; other readers ignore it. Entries:
/// disks/x, disks/radius, walls/{shape,a,b,normal}, contacts/{i,j,n}, step, number, time. Throws
/// FileError.
void write_geometry(const std::filesystem::path& path, const Scene<2>& scene,
                    const State<2>& state);

/// Empty if the file has no such group (or is no HDF5 file). `contacts`: number of contacts of the
/// problem. Throws FileError if the group does not match it.
std::optional<ProblemGeometry> read_geometry(const std::filesystem::path& path, int contacts);

}  // namespace bipot
