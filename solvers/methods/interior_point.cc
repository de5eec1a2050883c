#include "solvers/methods/interior_point.h"

#include <fmt/format.h>

#include <cmath>
#include <random>

#include "solvers/interior/arclength.h"
#include "solvers/interior/interior_state.h"
#include "solvers/interior/proximal_interior_point.h"
#include "solvers/interior/proximal_newton.h"
#include "solvers/monitor.h"
#include "solvers/parameters.h"

namespace bipot {
namespace {

// Stiffness of the springs of the start estimate, over 1/W_nn: forces reach about its square root
// of contacts far.
constexpr double kStartStiffness = 1e4;
constexpr double kRoundScales[] = {1, 0.1, 10};  // start scale of the rounds, in turn
constexpr double kRelaxedGap = 1e-2;  // accuracy of the associated law before the exact one
constexpr double kRelaxedNeighbourhood = 0.1;  // tight: the path has no folds to get around
constexpr double kPolishBelow = 1e-2;          // guarded error from which Newton is worth a try
constexpr int kWarmIterations = 15;
constexpr int kEndgameIterations = 60;
constexpr unsigned kSeed = 1;

/// In [0, 1), the same bits on every platform.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// Energy of the start. The bodies are held by normal springs of stiffness kappa / W_nn, which may
/// pull: (I + R W) s = -R u_free, R = diag(kappa / W_nn, 0). Its mean W_nn s_n² grows with the
/// weight that a packing carries, has the problem's units and costs one factorisation.
template <int D>
double start_energy(InteriorSystem<D>& system) {
  const ContactProblem& p = system.problem();
  const Vector& mobility = system.mobility();
  std::vector<double> R(static_cast<std::size_t>(p.num_contacts()) * D * D, 0.0);
  Vector g = Vector::Zero(p.num_rows());
  double fallback = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double stiffness = kStartStiffness / mobility[c * D];
    R[static_cast<std::size_t>(c) * D * D] = stiffness;
    g[c * D] = -stiffness * p.u_free[c * D];
    fallback += p.u_free.segment<D>(c * D).squaredNorm() / mobility[c * D];
  }
  double energy = 0;
  if (system.shifted().factor(R)) {
    Vector s;
    system.shifted().solve(g, s);
    for (int c = 0; c < p.num_contacts(); ++c) energy += mobility[c * D] * s[c * D] * s[c * D];
  }
  // An operator that is not definite may put a pole where the springs are.
  return (std::isfinite(energy) && energy > 0 ? energy : fallback) / p.num_contacts();
}

template <int D>
class Driver {
 public:
  Driver(const ContactProblem& p, const SolverOptions& options, const Parameters& parameters,
         IterationMonitor& monitor)
      : p_(p),
        options_(options),
        monitor_(monitor),
        evaluate_(p),
        system_(p, monitor.evaluator().delassus(), form(parameters)),
        run_(monitor),
        random_(kSeed) {
    relaxation_ = D > 1 && parameters.choice("relaxation") == "on";
    arclength_ = parameters.choice("arclength") == "on";
    polish_ = parameters.choice("polish") == "on";
    rounds_ = parameters.integer("rounds");
    exact_.max_iterations = parameters.integer("stage_iterations");
    associated_ = exact_;
    associated_.final_gap = kRelaxedGap;
    associated_.neighbourhood = kRelaxedNeighbourhood;
    endgame_.max_iterations = kEndgameIterations;
    arc_.max_iterations = parameters.integer("arc_iterations");
    scale_ = parameters.number("start_scale");
    energy_ = start_energy(system_);
    monitor.end_setup();
  }

  void operator()() {
    const bool warm = options_.s0.size() != 0;
    const Vector s0 = start_of(p_, options_);
    if (monitor_.stop(0, s0)) return;
    if (warm && polish_ && monitor_.best_error() < kPolishBelow) {
      ProximalNewtonOptions newton;
      newton.max_iterations = kWarmIterations;
      if (polish(s0, newton) == StageEnd::kStop) return;
    }
    for (int round = 0; round < rounds_; ++round) {
      if (play(round)) return;
    }
    monitor_.end(SolveStatus::kStalled,
                 fmt::format("the interior point stalled in its {} stage after {} rounds and {} "
                             "iterations, best error {:.2e}",
                             arclength_ ? "arclength" : "proximal", rounds_, run_.iteration,
                             monitor_.best_error()));
  }

 private:
  static ShiftedDelassus::Form form(const Parameters& parameters) {
    const std::string choice = parameters.choice("linear_system");
    if (choice == "body") return ShiftedDelassus::Form::kBody;
    if (choice == "contact") return ShiftedDelassus::Form::kContact;
    return ShiftedDelassus::Form::kAuto;
  }

  StageEnd polish(const Vector& s, const ProximalNewtonOptions& options) {
    return proximal_newton<D>(p_, system_.delassus(), system_.shifted(), system_.mobility(), s,
                              run_, options);
  }

  /// Start of a round: scales in turn, then random ones contact by contact as well.
  Vector start_impulse(int round) {
    const int scales = static_cast<int>(std::size(kRoundScales));
    Vector impulse(p_.num_contacts());
    for (int c = 0; c < p_.num_contacts(); ++c) {
      impulse[c] =
          scale_ * kRoundScales[round % scales] * std::sqrt(energy_ / system_.mobility()[c * D]);
      if (round >= scales) impulse[c] *= std::pow(10.0, uniform(random_) - 0.5);
    }
    return impulse;
  }

  /// One round; true: the monitor said stop.
  bool play(int round) {
    // The impulses are scaled, the velocities w, la, lc are not.
    const double factor = scale_ * kRoundScales[round % std::size(kRoundScales)];
    const Vector energy = Vector::Constant(p_.num_contacts(), factor * energy_);
    const Vector impulse = start_impulse(round);
    InteriorState<D> best;
    double best_error = std::numeric_limits<double>::infinity();
    for (const bool relaxed : {true, false}) {
      if (relaxed && !relaxation_) continue;
      system_.set_association(relaxed ? 1 : 0);
      InteriorState<D> z = system_.central_state(impulse, energy);
      InteriorState<D> candidate = z;
      if (relaxed) {
        const StageEnd end = proximal_interior_point(system_, z, run_, associated_, candidate);
        if (end == StageEnd::kStop) return true;
        system_.set_association(z, 0);
        candidate = z;
      }
      if (proximal_interior_point(system_, z, run_, exact_, candidate) == StageEnd::kStop) {
        return true;
      }
      const double error = evaluate_(candidate.s).guarded();
      if (polish_ && error < kPolishBelow && polish(candidate.s, {}) == StageEnd::kStop) {
        return true;
      }
      if (best.X.size() == 0 || error < best_error) {
        best_error = error;
        best = std::move(candidate);
      }
    }
    if (!arclength_) return false;
    const InteriorState<D> start = best;
    if (follow_central_path(system_, start, run_, arc_, endgame_, best) == StageEnd::kStop) {
      return true;
    }
    return polish_ && monitor_.best_error() < kPolishBelow &&
           polish(Vector(monitor_.best_impulse()), {}) == StageEnd::kStop;
  }

  const ContactProblem& p_;
  const SolverOptions& options_;
  IterationMonitor& monitor_;
  ContactErrorEvaluator evaluate_;
  InteriorSystem<D> system_;
  InteriorRun run_;
  std::mt19937_64 random_;
  bool relaxation_ = true, arclength_ = true, polish_ = true;
  int rounds_ = 1;
  ProximalInteriorPointOptions exact_, associated_, endgame_;
  ArclengthOptions arc_;
  double scale_ = 1, energy_ = 0;  // the energy is that of the default start
};

}  // namespace

SolveResult solve_interior_point(const ContactProblem& p, const SolverOptions& options) {
  const Parameters parameters(options.parameters, kInteriorPointParameters);
  IterationMonitor monitor(p, options);
  dispatch_dim(p.dim, [&](auto d) { Driver<d()>(p, options, parameters, monitor)(); });
  return monitor.finish();
}

}  // namespace bipot
