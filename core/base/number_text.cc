#include "core/base/number_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace bipot {

std::string tolerance_label(double tol) {
  if (!std::isfinite(tol)) return "–";
  if (tol >= 1e-2) return fmt::format("{:g}", tol);
  std::string text = fmt::format("{:e}", tol);
  const std::size_t e = text.find('e');
  const double mantissa = number_at(std::string_view(text).substr(0, e));
  return fmt::format("{:g}e{}", mantissa, std::strtol(text.c_str() + e + 1, nullptr, 10));
}

}  // namespace bipot
