#include "bench/compare/extreme_case.h"

namespace bipot {

std::vector<ExtremeCase> extreme_cases() {
  std::vector<ExtremeCase> cases;
  add_mass_cases(cases);
  add_friction_cases(cases);
  add_restitution_cases(cases);
  add_unit_cases(cases);
  add_hyperstatic_cases(cases);
  add_contradictory_cases(cases);
  add_violent_cases(cases);
  return cases;
}

}  // namespace bipot
