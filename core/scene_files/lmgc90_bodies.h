#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/scene_files/position_file.h"

namespace bipot {

/// The disks (contactor DISKx) or spheres (SPHER) of a file BODIES.DAT of LMGC90. Displacements and
/// velocities are those of DOF.INI in the same folder, where there is one. Bodies whose degrees of
/// freedom DRV_DOF.DAT there all holds or drives at constant velocities are `driven`. Bodies with
/// other contactors alone, walls mostly, are left out; `left_out` counts their contactors by kind.
/// Throws SceneFileError with the line; also for a body of several contactors with a disk or sphere
/// among them, and for other driven degrees.
std::vector<PositionRow> read_lmgc90_bodies(const std::filesystem::path& path, int dim,
                                            std::map<std::string, int>* left_out = nullptr);

}  // namespace bipot
