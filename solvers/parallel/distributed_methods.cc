#include "solvers/parallel/distributed_methods.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <type_traits>

#include "solvers/disks/tiled_gradient.h"
#include "solvers/kernels/anderson_iteration.h"
#include "solvers/kernels/local_updates.h"
#include "solvers/kernels/predictor_steps.h"
#include "solvers/methods/accelerated_gradient.h"
#include "solvers/methods/anderson.h"
#include "solvers/methods/gauss_seidel.h"
#include "solvers/methods/interior_point.h"
#include "solvers/parallel/disk_frontier.h"
#include "solvers/parallel/distributed_kernels.h"
#ifdef BIPOT_WITH_PETSC
#include "solvers/methods/newton_snes.h"
#endif
#include "solvers/methods/uzawa.h"

namespace bipot {
namespace {

/// A DistributedMonitor as the methods below see it: alone, or in one stage of `auto`, which ends
/// with its budget as well.
class StageMonitor {
 public:
  explicit StageMonitor(DistributedMonitor& whole) : whole_(whole) {}
  StageMonitor(DistributedMonitor& whole, int first, int budget)
      : whole_(whole), first_(first), budget_(budget), staged_(true) {}

  DistributedSpace& space() { return whole_.space(); }
  bool due(int iteration) { return iteration >= budget_ || whole_.due(first_ + iteration); }
  int undue(int iteration, int most) const {
    return std::min(whole_.undue(first_ + iteration, most), std::max(1, budget_ - iteration));
  }
  bool stop(int iteration, const Vector& s, double step = kNaN, bool moving = false) {
    iterations_ = iteration;
    // The first iterate of a stage is the best of the one before: it was judged.
    const bool judged = staged_ && iteration == 0;
    if (whole_.stop(first_ + iteration, s, step, moving || judged)) ended_ = true;
    return ended_ || iteration >= budget_;
  }
  double best_error() const { return whole_.best_error(); }
  const Vector& best_impulse() const { return whole_.best_impulse(); }
  void end_setup() {
    if (!staged_) whole_.end_setup();
  }

  bool ended() const { return ended_; }
  int iterations() const { return first_ + iterations_; }

 private:
  DistributedMonitor& whole_;
  int first_ = 0, budget_ = std::numeric_limits<int>::max(), iterations_ = 0;
  bool staged_ = false, ended_ = false;
};

void gradient(StageMonitor& monitor, const std::string& map, double step, const Vector& s0) {
  DistributedSpace& space = monitor.space();
  const ContactProblem& p = space.problem();
  const ContactScaling scaling = equilibrated_scaling(p, space.diagonal());
  const double lambda = kSpectralMargin * distributed_spectral_estimate(space, scaling.velocity);
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    if constexpr (D < 3) {
      if (!space.exact()) {
        if (auto disks = DiskFrontier<D>::structure(space)) {
          DiskFrontier<D> frontier(space);
          TiledGradient<D> kernel(p, *disks, scaling, Execution{}, &frontier);
          disks.reset();  // packed: 48 bytes a contact less
          iterate_gradient(kernel, MapRota(map), s0, lambda, step, monitor);
          return;
        }
      }
    }
    const auto run = [&](auto sums) {
      GradientIteration<D, decltype(sums)> kernel(p, sums, scaling);
      iterate_gradient(kernel, MapRota(map), s0, lambda, step, monitor);
    };
    if (space.exact()) {
      run(ExactSums{space});
    } else {
      run(FastSums{space});
    }
  });
}

/// Whether sweeps can follow the velocities of these contacts: disks, or at most two bodies each.
template <int D>
bool can_sweep(const ContactProblem& split) {
  constexpr int kPlanar = D == 1 ? 2 : 3;
  return split.num_contacts() == 0 || TwoPassSweep<D, kPlanar>::fits(split) ||
         TwoPassSweep<D, 6>::fits(split);
}

/// Calls f(sweep, visit) as with_local_updates() does.
template <int D, class F>
void with_split_sweep(const ContactProblem& split, const LocalSettings& settings, F&& f) {
  if (split.num_contacts() == 0) {
    // Nothing to sweep over, but the others wait for this process's part in sums and exchanges.
    DiskSweep<D> nothing(split, DiskStructure{{}, {DiskStructure::Body{}}});
    f(nothing, [](int) {});
    return;
  }
  const DelassusOperator delassus(split, DelassusOperator::Form::kTwoPass);
  with_local_updates<D>(split, delassus, settings, false, [&](auto& sweep, auto visit) {
    // can_sweep() keeps the explicit form out.
    if constexpr (!std::is_same_v<std::decay_t<decltype(sweep)>, ExplicitSweep<D>>) f(sweep, visit);
  });
}

/// The contacts of this process with the masses of their bodies divided among the processes that
/// push them.
ContactProblem split_masses(const ProblemPiece& piece) {
  ContactProblem split = piece.own;
  for (int dof = 0; dof < split.num_dofs(); ++dof) {
    split.A.coeffRef(dof, dof) /= piece.sharers[to_size(dof)];
  }
  return split;
}

/// Velocities at s = 0 of a sweep's contacts such that at its impulse they are those of the whole.
template <int D, class Sweep>
void meet_the_others(DistributedSpace& space, Sweep& sweep, Vector& u) {
  space.velocity(sweep.impulse(), u);
  for (int c = 0; c < space.problem().num_contacts(); ++c) {
    sweep.shift(c, local<D>(u, c) - sweep.velocity(c));
  }
}

/// Calls f(dimension, sweep, visit) with the split sweep of this process.
template <class F>
void with_domain_sweep(DistributedSpace& space, const LocalSettings& settings, F&& f) {
  const ContactProblem split = split_masses(space.piece());
  dispatch_dim(split.dim, [&](auto d) {
    space.group().fail_where_any(
        can_sweep<d()>(split) ? ""
                              : "sweeps on several processes need contacts of one or two bodies");
    with_split_sweep<d()>(split, settings, [&](auto& sweep, auto visit) { f(d, sweep, visit); });
  });
}

void sweeps(StageMonitor& monitor, const LocalSettings& settings, bool symmetric,
            const Vector& s0) {
  DistributedSpace& space = monitor.space();
  const int contacts = space.problem().num_contacts();
  with_domain_sweep(space, settings, [&](auto d, auto& sweep, auto visit) {
    Vector u;
    sweep.reset(s0);
    monitor.end_setup();
    for (int iteration = 0;
         !(monitor.due(iteration) && monitor.stop(iteration, sweep.impulse(), settings.omega));
         ++iteration) {
      meet_the_others<d()>(space, sweep, u);
      if (symmetric && iteration % 2 == 1) {
        for (int c = contacts - 1; c >= 0; --c) visit(c);
      } else {
        for (int c = 0; c < contacts; ++c) visit(c);
      }
    }
  });
}

void anderson_sweeps(StageMonitor& monitor, int columns, const Vector& s0) {
  DistributedSpace& space = monitor.space();
  const int contacts = space.problem().num_contacts();
  const ContactScaling scaling = equilibrated_scaling(space.problem(), space.diagonal());
  with_domain_sweep(space, {}, [&](auto d, auto& sweep, auto visit) {
    Vector u;
    monitor.end_setup();
    iterate_anderson(DistributedProducts{space}, scaling, s0, columns, monitor, [&](Vector& s) {
      sweep.reset(s);
      meet_the_others<d()>(space, sweep, u);
      for (int c = 0; c < contacts; ++c) visit(c);
      for (int c = contacts - 1; c >= 0; --c) visit(c);
      s = sweep.impulse();
    });
  });
}

void anderson_gradient(StageMonitor& monitor, int columns, const Vector& s0) {
  DistributedSpace& space = monitor.space();
  const ContactProblem& p = space.problem();
  const ContactScaling scaling = equilibrated_scaling(p, space.diagonal());
  const double rho = 1 / (kSpectralMargin * distributed_spectral_estimate(space, scaling.velocity));
  Vector u;
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    iterate_anderson(DistributedProducts{space}, scaling, s0, columns, monitor, [&](Vector& s) {
      space.velocity(s, u);
      for (int c = 0; c < p.num_contacts(); ++c) {
        const Local<D> to_x = scaling.impulse.segment<D>(c * D);
        const Local<D> y = local<D>(s, c).cwiseProduct(to_x);
        const Local<D> w = local<D>(u, c).cwiseQuotient(to_x);
        s.segment<D>(c * D) =
            corrected<D, GradientMap::kSplit>(y, w, scaling.mu[c], rho).cwiseQuotient(to_x);
      }
    });
  });
}

std::string nothing_to_refuse(const Parameters&) { return {}; }

std::string refuse_uzawa(const Parameters& parameters) {
  if (parameters.choice("refresh") != "jacobi") {
    return "uzawa on several processes takes refresh = jacobi alone";
  }
  return {};
}

std::string refuse_sweeps(const Parameters& parameters) {
  const std::string order = parameters.choice("order");
  if (order != "forward" && order != "symmetric") {
    return "pgs on several processes takes order = forward or symmetric";
  }
  if (parameters.choice("operator") != "auto") {
    return "pgs on several processes does not take operator = explicit";
  }
  return {};
}

#ifdef BIPOT_WITH_PETSC
std::string refuse_newton(const Parameters& parameters) {
  const std::string linear = parameters.choice("linear");
  if (linear != "auto" && linear != "mumps") {
    return "newton on several processes takes linear = auto or mumps";
  }
  if (parameters.choice("residual") == "snesvi") {
    return "newton on several processes takes residual = alart-curnier or fischer-burmeister";
  }
  return {};
}
#endif

bool always(const Parameters&) { return true; }
bool never(const Parameters&) { return false; }
bool with_gradient_map(const Parameters& parameters) {
  return parameters.choice("map") == "gradient";
}

constexpr DistributedSolver kDistributedSolvers[] = {
    {"auto",
     "rounds of apgd, anderson, pgs and ipm, each from the best impulse so far",
     &distributed_auto,
     {},
     &nothing_to_refuse,
     &never},
    {"apgd", "accelerated projected gradient: the iterates of one process", &distributed_gradient,
     kAcceleratedGradientParameters, &nothing_to_refuse, &always},
    {"anderson", "Anderson acceleration of sweeps with split masses, or of gradient steps",
     &distributed_anderson, kAndersonParameters, &nothing_to_refuse, &with_gradient_map},
    {"uzawa", "bi-potential Uzawa in Jacobi's order: the iterates of one process",
     &distributed_uzawa, kUzawaParameters, &refuse_uzawa, &always},
    {"pgs", "Gauss-Seidel sweeps of all processes at once, with split masses", &distributed_sweeps,
     kGaussSeidelParameters, &refuse_sweeps, &never},
    {"ipm", "interior point on the first process, its systems factored by all with MUMPS", nullptr,
     kInteriorPointParameters, &nothing_to_refuse, &never, &interior_point_with},
#ifdef BIPOT_WITH_PETSC
    {"newton", "nonsmooth Newton on the first process, its systems factored by all with MUMPS",
     nullptr, kNewtonParameters, &refuse_newton, &never, &newton_snes_with},
#endif
};

}  // namespace

std::span<const DistributedSolver> distributed_solvers() { return kDistributedSolvers; }

const DistributedSolver* find_distributed_solver(std::string_view name) {
  for (const DistributedSolver& solver : kDistributedSolvers) {
    if (solver.name == name) return &solver;
  }
  return nullptr;
}

void distributed_gradient(DistributedMonitor& monitor, const Parameters& parameters,
                          const Vector& s0) {
  StageMonitor whole(monitor);
  gradient(whole, parameters.choice("map"), parameters.number("step"), s0);
}

void distributed_uzawa(DistributedMonitor& monitor, const Parameters& parameters,
                       const Vector& s0) {
  DistributedSpace& space = monitor.space();
  const ContactProblem& p = space.problem();
  PredictorSteps steps;
  if (parameters.choice("rho") == "paper") {
    steps = {physical_scaling(p), Vector(p.num_contacts())};
    for (int c = 0; c < p.num_contacts(); ++c) steps.rho[c] = 1 / space.diagonal()[c * p.dim];
  } else {
    steps.scaling = equilibrated_scaling(p, space.diagonal());
    steps.rho = Vector::Constant(p.num_contacts(),
                                 1.9 / distributed_spectral_bound(space, steps.scaling.velocity));
  }
  monitor.end_setup();
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    const BipotentialCorrector<D> update{steps};
    Vector s = s0, u;
    for (int iteration = 0;
         !(monitor.due(iteration) &&
           monitor.stop(iteration, s, steps.rho.size() > 0 ? steps.rho[0] : kNaN));
         ++iteration) {
      space.velocity(s, u);
      for (int c = 0; c < p.num_contacts(); ++c) {
        s.segment<D>(c * D) = update(c, local<D>(s, c), local<D>(u, c));
      }
    }
  });
}

void distributed_sweeps(DistributedMonitor& monitor, const Parameters& parameters,
                        const Vector& s0) {
  const LocalSettings settings{.exact = parameters.choice("local") == "exact",
                               .local_iterations = parameters.integer("local_iterations"),
                               .omega = parameters.number("omega")};
  StageMonitor whole(monitor);
  sweeps(whole, settings, parameters.choice("order") == "symmetric", s0);
}

void distributed_anderson(DistributedMonitor& monitor, const Parameters& parameters,
                          const Vector& s0) {
  const int columns = parameters.integer("memory");
  StageMonitor whole(monitor);
  if (parameters.choice("map") == "sweep") {
    anderson_sweeps(whole, columns, s0);
  } else {
    anderson_gradient(whole, columns, s0);
  }
}

void distributed_auto(DistributedMonitor& monitor, const Parameters&, const Vector& s0) {
  constexpr int kFirstBudget = 512, kRoundsToSecondOrder = 3;
  Vector s = s0;
  int done = 0, rounds = 0;
  for (int budget = kFirstBudget;; budget = std::min(2 * budget, 1 << 24)) {
    for (int stage = 0; stage < 3; ++stage) {
      StageMonitor part(monitor, done, budget);
      if (stage == 0) {
        gradient(part, "auto", 1, s);
      } else if (stage == 1) {
        anderson_sweeps(part, 8, s);
      } else {
        sweeps(part, {}, false, s);
      }
      if (part.ended()) return;
      done = part.iterations();
      s = monitor.best_impulse();
    }
    if (++rounds % kRoundsToSecondOrder != 0) continue;
    StageMonitor part(monitor, done, budget);
    int iterations = 0;
    s = monitor.lead(*find_distributed_solver("ipm"), s, iterations);
    if (part.stop(iterations, s, kNaN, true) && part.ended()) return;
    done = part.iterations();
    s = monitor.best_impulse();
  }
}

}  // namespace bipot
