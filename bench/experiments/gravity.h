#pragma once

namespace bipot {

inline constexpr double kGravity = 9.81;  ///< [m/s²]

}  // namespace bipot
