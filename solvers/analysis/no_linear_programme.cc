// In place of linear_programme.cc where the program is built without CLP.
#include "solvers/analysis/linear_programme.h"

namespace bipot {

LinearProgramme::Optimum solve(const LinearProgramme&, const std::function<bool()>&) {
  return {.message = "this program was built without CLP (-DBIPOT_WITH_CLP=OFF)"};
}

}  // namespace bipot
