#include "solvers/kernels/predictor_steps.h"

#include "solvers/parameters.h"

namespace bipot {

PredictorSteps paper_steps(ContactSpace& space) {
  const ContactProblem& p = space.problem();
  const Vector diagonal = space.diagonal();
  PredictorSteps steps{physical_scaling(p, diagonal), Vector(p.num_contacts())};
  for (int c = 0; c < p.num_contacts(); ++c) steps.rho[c] = 1 / diagonal[c * p.dim];
  return steps;
}

PredictorSteps stable_steps(ContactSpace& space, bool jacobi) {
  const ContactProblem& p = space.problem();
  PredictorSteps steps{equilibrated_scaling(p, space.diagonal()), {}};
  steps.rho = Vector::Constant(p.num_contacts(),
                               jacobi ? 1.9 / space.norm_bound(steps.scaling.velocity) : 1.0);
  return steps;
}

Parallel jacobi_in_parallel(const Parameters& parameters) {
  return parameters.choice("refresh") == "jacobi" ? Parallel::kReproducible : Parallel::kNo;
}

}  // namespace bipot
