#include "solvers/methods/uzawa.h"

#include "solvers/kernels/contact_iteration.h"
#include "solvers/kernels/predictor_steps.h"

namespace bipot {

void solve_uzawa(SolveRun& run) {
  const bool jacobi = run.parameters().choice("refresh") == "jacobi";
  const PredictorSteps steps = run.parameters().choice("rho") == "paper"
                                   ? paper_steps(run.space())
                                   : stable_steps(run.space(), jacobi);
  run.end_setup();
  dispatch_rows(run.problem(), [&](auto d) {
    const BipotentialCorrector<d()> update{steps};
    if (jacobi) {
      iterate_jacobi<d()>(run, steps.first(), update);
    } else {
      iterate_gauss_seidel<d()>(run, steps.first(), update);
    }
  });
}

}  // namespace bipot
