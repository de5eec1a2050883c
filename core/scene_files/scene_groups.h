#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "core/scene/generators.h"
#include "core/scene_files/position_file.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// `radii` [m] and `fractions` of a random filling. Throws SceneFileError.
std::vector<RadiusClass> read_radius_classes(const SceneTable& table);

/// The radii of a filling of `count` bodies: classes, or quantiles (k + ½)/count of a distribution by
/// number. That is `lognormal` = [median, σ of the logarithm], or `passing`, rows of a radius and
/// the share of bodies up to it, linear in between. Throws SceneFileError.
std::vector<RadiusClass> read_radii(const SceneTable& table, int count);

/// Refuses a number of bodies that would exhaust the memory: `count` bodies of the kind named, as
/// the value of `key` asks for. Throws SceneFileError.
void require_possible(const SceneTable& table, std::string_view key, double count,
                      std::string_view bodies);

/// The rows of the file that the key `file` names, at least one; `caution`: what of it is left out
/// is added. Throws SceneFileError.
std::vector<PositionRow> read_named_positions(const SceneTable& table, int dim,
                                              std::string& caution);

/// Masses of a group of bodies.
struct GroupMass {
  std::optional<double> mass;     ///< of each body                                    [kg]
  std::optional<double> density;  ///< where no mass is given                          [kg/m³]
  std::optional<double> inertia;  ///< of each body, instead of that of a homogeneous one  [kg m²]
};

/// `mass` or `density`, one of them, and `inertia` where it is a number. Throws SceneFileError.
GroupMass read_group_mass(const SceneTable& table, bool with_inertia = true);

}  // namespace bipot
