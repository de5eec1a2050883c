#include "core/base/number_text.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace bipot {

std::optional<double> printed_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  const std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
  if (!rest.empty()) {
    const std::string mantissa(text.substr(0, text.size() - rest.size()));
    const bool no_letter = rest.find_first_of("+-") == 0 && rest.size() == 4;
    if (rest.find_first_of("Dd") != 0 && !(no_letter && mantissa.find('.') != mantissa.npos)) {
      return std::nullopt;
    }
    return printed_number(fmt::format("{}e{}", mantissa, rest.substr(no_letter ? 0 : 1)));
  }
  if (error == std::errc::result_out_of_range) {
    const bool small = text.find_first_of("eE") < text.rfind('-') && text.rfind('-') != text.npos;
    return small ? 0 : (text.starts_with('-') ? -kInfinity : kInfinity);
  }
  return error == std::errc() ? std::optional(x) : std::nullopt;
}

std::string tolerance_label(double tol) {
  if (!std::isfinite(tol)) return "–";
  if (tol >= 1e-2) return fmt::format("{:g}", tol);
  std::string text = fmt::format("{:e}", tol);
  const std::size_t e = text.find('e');
  const double mantissa = number_at(std::string_view(text).substr(0, e));
  return fmt::format("{:g}e{}", mantissa, std::strtol(text.c_str() + e + 1, nullptr, 10));
}

}  // namespace bipot
