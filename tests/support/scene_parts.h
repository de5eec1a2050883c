#pragma once

#include "core/scene/scene.h"

namespace bipot {

/// The solid side lies behind the line through `point`; `normal` is a unit vector.
Wall half_plane(const Vec2& point, const Vec2& normal);

/// A homogeneous cylinder of unit length.
Disk cylinder(const Vec2& x, double radius, const Vec2& v = Vec2::Zero(), double mass = 2,
              double spin = 0);

/// A scene without bodies and gravity whose one material has this law.
Scene one_law(const ContactLaw& law);

}  // namespace bipot
