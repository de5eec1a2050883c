#pragma once

#include <span>
#include <string>
#include <string_view>

#include "solvers/parallel/distributed_monitor.h"
#include "solvers/parameters.h"

namespace bipot {

/// A solver for problems that lie on several processes.
struct DistributedSolver {
  std::string_view name;
  std::string_view summary;
  /// Null where the solver is led.
  void (*run)(DistributedMonitor& monitor, const Parameters& parameters, const Vector& s0);
  std::span<const ParameterSpec> parameters;
  /// Why these parameters cannot be had on several processes; empty where they can.
  std::string (*refuse)(const Parameters& parameters);
  /// Whether the iterates are the same for any number of processes, sums aside.
  bool (*any_processes)(const Parameters& parameters);
  /// A led solver runs on the first process, on the whole problem; its linear systems are factored
  /// by all processes (ProcessGroup::lend_hands) where they are large. Null for the others.
  SolveResult (*led)(const ContactProblem& whole, const SolverOptions& options,
                     SystemFactor* factor) = nullptr;
};

/// auto, apgd, anderson, uzawa, pgs, ipm and, with PETSc, newton; data/manual/explanation/parallel.md says which
/// iterates are those of one process.
std::span<const DistributedSolver> distributed_solvers();
/// Null where no solver for several processes has that name.
const DistributedSolver* find_distributed_solver(std::string_view name);

/// Accelerated projected gradient: the iterates of one process (solvers/methods/
/// accelerated_gradient.h) up to the order of the sums. An iteration is one exchange and one
/// reduction of three numbers.
void distributed_gradient(DistributedMonitor&, const Parameters&, const Vector& s0);

/// Jacobi's order: the iterates of one process up to the bound of W's norm, which may be larger
/// where driven walls take part. An iteration is one exchange.
void distributed_uzawa(DistributedMonitor&, const Parameters&, const Vector& s0);

/// Each process sweeps over its contacts with the velocities that the others left, all at once. A
/// body that n processes push counts in each sweep with 1/n of its mass (mass splitting: Tonge,
/// Benevolenski and Voroshilov, ACM Trans. Graph. 31, 2012). By Cauchy and Schwarz the split
/// operator is a bound, W <= W~ = diag(W_1, ..., W_P), so that for mu = 0 a sweep lowers the
/// majorant s·b + ½ s_k·W s_k + (s - s_k)·W s_k + ½ (s - s_k)·W~ (s - s_k), and with it the energy:
/// it converges where Gauss-Seidel does. With friction there is no proof, as on one process. The
/// iterates depend on the processes; one sweep is one exchange.
void distributed_sweeps(DistributedMonitor&, const Parameters&, const Vector& s0);

/// Anderson's acceleration of these sweeps, forward and backward, or of gradient steps, whose
/// iterates are those of one process up to rounding.
void distributed_anderson(DistributedMonitor&, const Parameters&, const Vector& s0);

/// Rounds of apgd, anderson and pgs, each from the best impulse so far, with a budget that doubles
/// from round to round; after the third, and after every third from there on, one of ipm.
void distributed_auto(DistributedMonitor&, const Parameters&, const Vector& s0);

}  // namespace bipot
