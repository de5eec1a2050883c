#include "bench/compare/extreme_case.h"

namespace bipot {

std::vector<ExtremeCase> extreme_cases() {
  std::vector<ExtremeCase> cases;
  const auto add = [&cases](const char* group, void (*part)(std::vector<ExtremeCase>&)) {
    const std::size_t before = cases.size();
    part(cases);
    for (std::size_t k = before; k < cases.size(); ++k) cases[k].group = group;
  };
  add("masses and sizes", add_mass_cases);
  add("friction", add_friction_cases);
  add("restitution", add_restitution_cases);
  add("units", add_unit_cases);
  add("more forces than equations", add_hyperstatic_cases);
  add("contradictory data", add_contradictory_cases);
  add("violent and degenerate", add_violent_cases);
  return cases;
}

}  // namespace bipot
