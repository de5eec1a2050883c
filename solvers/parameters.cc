#include "solvers/parameters.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "core/base/nearest_name.h"
#include "core/base/number_text.h"

namespace bipot {

Parameters::Parameters(const std::map<std::string, std::string>& given,
                       std::span<const ParameterSpec> specs)
    : given_(given), specs_(specs) {
  for (const auto& [name, value] : given) find_named("parameter", name, specs);
  for (const ParameterSpec& s : specs) {  // every given value is checked, used or not
    if (s.kind == ParameterSpec::Kind::kChoice) {
      choice(s.name);
    } else if (s.kind != ParameterSpec::Kind::kText) {
      number(s.name);
    }
  }
}

const ParameterSpec& Parameters::spec(std::string_view name) const {
  for (const ParameterSpec& s : specs_) {
    if (s.name == name) return s;
  }
  throw std::logic_error(fmt::format("parameter '{}' is not in the solver's specification", name));
}

std::string Parameters::text(std::string_view name) const {
  const auto it = given_.find(std::string(name));
  return it != given_.end() ? it->second : std::string(spec(name).default_value);
}

double Parameters::number(std::string_view name) const {
  const ParameterSpec& s = spec(name);
  const std::string value = text(name);
  const auto x = whole_number<double>(value);
  const bool integer = s.kind == ParameterSpec::Kind::kInteger;
  if (!(x >= s.minimum && x <= s.maximum) || (integer && *x != std::floor(*x))) {
    throw std::invalid_argument(fmt::format(
        "parameter {} = '{}': expected {} in [{}, {}]", name, value,
        s.kind == ParameterSpec::Kind::kInteger ? "an integer" : "a number", s.minimum, s.maximum));
  }
  return *x;
}

int Parameters::integer(std::string_view name) const { return static_cast<int>(number(name)); }

std::string Parameters::choice(std::string_view name) const {
  const ParameterSpec& s = spec(name);
  std::string value = text(name);
  std::string_view rest = s.choices;
  while (!rest.empty()) {
    const std::size_t bar = rest.find('|');
    if (rest.substr(0, bar) == value) return value;
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
  throw std::invalid_argument(
      fmt::format("parameter {} = '{}': expected one of {}", name, value, s.choices));
}

}  // namespace bipot
