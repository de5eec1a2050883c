#include "solvers/methods/uzawa.h"

#include "solvers/kernels/predictor_steps.h"

namespace bipot {

void solve_uzawa(SolveRun& run) { iterate_correctors<BipotentialCorrector>(run); }

}  // namespace bipot
