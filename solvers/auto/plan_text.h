#pragma once

#include <string_view>

namespace bipot {

/// The bytes of solvers/auto/plan.toml.
std::string_view shipped_plan_text();

}  // namespace bipot
