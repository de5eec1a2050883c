#pragma once

#include "core/scene/scene.h"

namespace bipot {

/// Of the tests' scenes [m/s²].
inline constexpr double kGravity = 9.81;

/// The solid side lies behind the line through `point`; `normal` is a unit vector.
Wall<2> half_plane(const Vec2& point, const Vec2& normal);

/// A homogeneous cylinder of unit length.
Disk cylinder(const Vec2& x, double radius, const Vec2& v = Vec2::Zero(), double mass = 2,
              double spin = 0);

/// The solid side lies behind the plane through `point`; `normal` is a unit vector.
Wall<3> half_space(const Vec3& point, const Vec3& normal);

/// A homogeneous sphere.
Sphere ball(const Vec3& x, double radius, const Vec3& v = Vec3::Zero(), double mass = 2,
            const Vec3& spin = Vec3::Zero());

/// A scene of spheres without bodies and gravity whose one material has this law.
Scene<3> one_law_in_space(const ContactLaw& law);

/// A scene without bodies and gravity whose one material has this law.
Scene<2> one_law(const ContactLaw& law);

}  // namespace bipot
