#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/scene/scene.h"

namespace bipot {

/// Region that a picture of disks and walls should show: the disks, the nearby parts of walls that
/// no half-plane covers, and walls about as near as the disks are wide. Never empty.
Box<2> view_box(std::span<const Disk> disks, std::span<const Wall<2>> walls);

/// The two ends of each wall as it is drawn. A segment has its own ends. The line of a half-plane
/// extends as far as the box in its direction, except where another half-plane covers it. Circles
/// and absent walls have no line: both ends are one point.
std::vector<std::pair<Vec2, Vec2>> wall_lines(std::span<const Wall<2>> walls, const Box<2>& box);

}  // namespace bipot
