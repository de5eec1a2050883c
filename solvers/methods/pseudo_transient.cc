#include "solvers/methods/pseudo_transient.h"

#include <fmt/format.h>

#include <limits>

#include "solvers/interior/proximal_newton.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

void solve_pseudo_transient(SolveRun& run) {
  const ContactProblem& p = run.problem();
  const Vector weights = mean_diagonal(p, run.delassus().diagonal());
  ShiftedDelassus system(p, ShiftedDelassus::Form::kAuto, run.factor(), run.factor_stop());
  const Vector start = run.start();
  run.end_setup();
  if (run.stop(0, start)) return;
  run.judge_every_iteration();
  InteriorRun steps(run);
  const StageEnd end = proximal_newton(p, run.delassus(), system, weights, start, steps,
                                       std::numeric_limits<int>::max());
  if (end == StageEnd::kStop) return;
  run.end(SolveStatus::kStalled,
          fmt::format("{} after {} factorisations, best error {:.2e}",
                      end == StageEnd::kFailed ? "singular or not finite" : "no step helps",
                      steps.iteration, run.best_error()));
}

}  // namespace bipot
