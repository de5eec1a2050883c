#include "solvers/kernels/predictor_steps.h"

#include "solvers/kernels/spectral_estimate.h"

namespace bipot {

PredictorSteps paper_steps(const ContactProblem& p, const DelassusOperator& delassus) {
  const Vector diagonal = delassus.diagonal();
  PredictorSteps steps{physical_scaling(p), Vector(p.num_contacts())};
  for (int c = 0; c < p.num_contacts(); ++c) steps.rho[c] = 1 / diagonal[c * p.dim];
  return steps;
}

PredictorSteps stable_steps(const ContactProblem& p, const DelassusOperator& delassus,
                            bool jacobi) {
  PredictorSteps steps{equilibrated_scaling(p, delassus.diagonal()), {}};
  steps.rho = Vector::Constant(p.num_contacts(),
                               jacobi ? 1.9 / spectral_bound(p, steps.scaling.velocity) : 1.0);
  return steps;
}

}  // namespace bipot
