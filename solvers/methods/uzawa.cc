#include "solvers/methods/uzawa.h"

#include "core/problem/coulomb_cone.h"
#include "solvers/kernels/predictor_steps.h"

namespace bipot {
namespace {

template <ContactRows D>
struct TwoCorrectors {
  const PredictorSteps& steps;

  Local<D> operator()(int c, const Local<D>& s, const Local<D>& u) const {
    const ContactScaling& scaling = steps.scaling;
    const Local<D> to_x = scaling.impulse.segment<D>(c * D);
    const double rho = steps.rho[c];
    Local<D> x =
        s.cwiseProduct(to_x) - rho * u.cwiseProduct(Local<D>(scaling.velocity.segment<D>(c * D)));
    x[0] = positive_part(x[0]);
    cut_off_parts<D>(x, friction_of<D>(scaling, c));
    return x.cwiseQuotient(to_x);
  }
};

}  // namespace

void solve_uzawa(SolveRun& run) { iterate_correctors<BipotentialCorrector>(run); }
void solve_classical(SolveRun& run) { iterate_correctors<TwoCorrectors>(run); }

}  // namespace bipot
