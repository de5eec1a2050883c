#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/scene/cell.h"
#include "core/scene/observable_choice.h"
#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// Index of the material that the key names; without the key, of the first one.
template <int D>
int material_index(const Scene<D>& scene, const SceneTable& table, std::string_view key);

/// The keys times, factors, frequency and phase of a table. Throws SceneFileError.
TimeFactor read_time_factor(const SceneTable& table);

/// Reads one table of [[walls]], with this index. Throws SceneFileError.
template <int D>
Wall<D> read_wall(const SceneTable& table, const Scene<D>& scene, std::size_t index);

/// The table [cell]; without it no cell. In 3D: width along x, depth along y, both fixed. Throws
/// SceneFileError.
PeriodicCell read_cell(const SceneTable& root, int dim);

/// Reads the tables [[disks]] or [[spheres]], then [[clusters]]. Walls must have been read; a file may
/// add some. Throws SceneFileError.
template <int D>
void read_bodies(const SceneTable& root, Scene<D>& scene);

/// Reads the tables [[clusters]] of a scene and appends their bodies. Materials and other bodies must
/// have been read. Throws SceneFileError.
template <int D>
void read_clusters(const SceneTable& root, Scene<D>& scene);

/// Reads the tables [[outlets]] and [[inlets]] of a scene, whose materials must have been read.
/// `turned`: the scene as a whole is turned, which excludes boxes along the axes. Throws
/// SceneFileError.
template <int D>
void read_gates(const SceneTable& root, bool turned, Scene<D>& scene);

/// Reads the tables [[pins]] and [[ropes]] of a scene, whose bodies must have been read and not been
/// turned. Throws SceneFileError.
template <int D>
void read_joints(const SceneTable& root, Scene<D>& scene);

/// The table [observables]; empty without it. In 3D windows, profiles and faces lie in the cell.
/// Throws SceneFileError.
template <int D>
std::optional<ObservableChoice<D>> read_observables(const SceneTable& root,
                                                    const PeriodicCell& cell);

}  // namespace bipot
