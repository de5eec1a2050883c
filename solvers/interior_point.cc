#include "solvers/interior_point.h"

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "solvers/arclength.h"
#include "solvers/interior_state.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"
#include "solvers/proximal_interior_point.h"
#include "solvers/proximal_newton.h"

namespace bipot {
namespace {

// Stiffness of the springs of the start estimate, over 1/W_nn: forces reach about its square root
// of contacts far.
constexpr double kStartStiffness = 1e4;
constexpr double kRoundScales[] = {1, 0.1, 10};  // start scale of the rounds, in turn
constexpr double kRelaxedGap = 1e-2;  // accuracy of the associated law before the exact one
constexpr double kPolishBelow = 1e-3;  // guarded error from which Newton is worth a try
constexpr int kEndgameIterations = 60;
constexpr unsigned kSeed = 1;

/// In [0, 1), the same bits on every platform.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Energy of the start. The bodies are held by normal springs of stiffness kappa / W_nn, which may
/// pull: (I + R W) s = -R u_free, R = diag(kappa / W_nn, 0). Its mean W_nn s_n² grows with the weight
/// that a packing carries, has the problem's units and costs one factorisation.
template <int D>
double start_energy(InteriorSystem<D>& system) {
  const ContactProblem& p = system.problem();
  std::vector<double> R(static_cast<std::size_t>(p.num_contacts()) * D * D, 0.0);
  Vector g = Vector::Zero(p.num_rows());
  double fallback = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double w = system.mobility()[c * D];
    R[static_cast<std::size_t>(c) * D * D] = kStartStiffness / w;
    g[c * D] = -kStartStiffness / w * p.u_free[c * D];
    fallback += p.u_free.segment<D>(c * D).squaredNorm() / w;
  }
  fallback /= p.num_contacts();
  double energy = 0;
  if (system.shifted().factor(R)) {
    Vector s;
    system.shifted().solve(g, s);
    for (int c = 0; c < p.num_contacts(); ++c) energy += system.mobility()[c * D] * s[c * D] * s[c * D];
    energy /= p.num_contacts();
  }
  return std::isfinite(energy) && energy > 0 ? energy : fallback;
}

template <int D>
void run(const ContactProblem& p, const Parameters& parameters, IterationMonitor& monitor) {
  const std::string form = parameters.choice("linear_system");
  using Form = ShiftedDelassus::Form;
  InteriorSystem<D> system(p, monitor.evaluator().delassus(),
                           form == "auto"   ? Form::kAuto
                           : form == "body" ? Form::kBody
                                            : Form::kContact);
  const double scale = parameters.number("start_scale");
  const double energy = start_energy(system) * scale * scale;
  monitor.end_setup();
  InteriorRun run(monitor);
  if (monitor.stop(0, Vector::Zero(p.num_rows()))) return;

  ProximalInteriorPointOptions first;
  first.max_iterations = parameters.integer("stage_iterations");
  const bool relaxation = parameters.choice("relaxation") == "on" && D > 1;
  ProximalInteriorPointOptions convex = first;
  convex.final_gap = kRelaxedGap;
  ProximalInteriorPointOptions endgame;
  endgame.max_iterations = kEndgameIterations;
  ArclengthOptions arc;
  arc.max_iterations = parameters.integer("arc_iterations");
  const bool arclength = parameters.choice("arclength") == "on";
  const bool polish = parameters.choice("polish") == "on";
  const int rounds = arclength ? parameters.integer("rounds") : 1;
  std::mt19937_64 random(kSeed);
  ContactErrorEvaluator evaluate(p);
  const auto guarded_error = [&](const Vector& s) { return evaluate(s).guarded(); };
  for (int round = 0; round < rounds; ++round) {
    const double factor = kRoundScales[round % std::size(kRoundScales)];
    const double e = energy * factor * factor;
    Vector impulse(p.num_contacts());
    for (int c = 0; c < p.num_contacts(); ++c) {
      impulse[c] = std::sqrt(e / system.mobility()[c * D]);
      if (round >= static_cast<int>(std::size(kRoundScales))) {
        impulse[c] *= std::pow(10.0, uniform(random) - 0.5);
      }
    }
    InteriorState<D> candidate;
    double candidate_error = std::numeric_limits<double>::infinity();
    for (const bool relaxed : {true, false}) {
      if (relaxed && !relaxation) continue;
      system.set_association(relaxed ? 1 : 0);
      InteriorState<D> z = system.central_state(impulse, Vector::Constant(p.num_contacts(), e));
      InteriorState<D> best = z;
      if (relaxed) {
        if (proximal_interior_point(system, z, run, convex, best) == StageEnd::kStop) return;
        system.set_association(z, 0);
        best = z;
      }
      if (proximal_interior_point(system, z, run, first, best) == StageEnd::kStop) return;
      const double error = guarded_error(best.s);
      if (error < candidate_error) {
        candidate_error = error;
        candidate = best;
      }
      if (polish && error < kPolishBelow &&
          proximal_newton<D>(p, system.delassus(), system.shifted(), system.mobility(), best.s, run,
                             {}) == StageEnd::kStop) {
        return;
      }
    }
    InteriorState<D> best = candidate;
    if (arclength &&
        follow_central_path(system, candidate, run, arc, endgame, best) == StageEnd::kStop) {
      return;
    }
  }
  monitor.fail(SolveStatus::kStalled,
               fmt::format("the interior point stopped after {} rounds and {} iterations, best "
                           "error {:.2e}",
                           rounds, run.iteration, monitor.best_error()));
}

}  // namespace

SolveResult solve_interior_point(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kInteriorPointParameters);
  IterationMonitor monitor(p, options);
  dispatch_dim(p.dim, [&](auto d) {
    run<d()>(p, parameters, monitor);
    return 0;
  });
  return monitor.finish();
}

}  // namespace bipot
