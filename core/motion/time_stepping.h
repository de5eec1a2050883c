#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/problem/contact_error.h"
#include "core/problem/contact_problem.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// The moving part of a scene: all that a restart needs.
struct State {
  double time = 0;  ///< [s]
  int step = 0;     ///< steps done
  std::vector<Disk> disks;
  std::vector<Wall> walls;
  std::vector<ContactOutcome> contacts;  ///< of the last step, sorted by (i, j); warm start
  /// Accumulated since step 0, for the ledger                                  [J]
  double wall_work = 0, friction_loss = 0, shock_loss = 0;
};
State initial_state(const Scene& scene);

/// Energy of a state and what the steps so far did to it. Closed:
///   kinetic + potential + elastic = initial + wall_work - friction_loss - shock_loss
/// up to round-off in the nonsmooth model, because the impulses act through the mean of the
/// velocities before and after the step, as the displacement does (38), (43).
struct EnergyLedger {
  double kinetic = 0;        ///< disks and driven walls                         [J]
  double potential = 0;      ///< of gravity, zero at the origin                 [J]
  double wall_work = 0;      ///< by moving and driven walls, since step 0       [J]
  double friction_loss = 0;  ///< dissipated by tangential impulses              [J]
  double shock_loss = 0;     ///< dissipated by normal impulses                  [J]
  double imbalance = 0;      ///< of the last step: what does not add up         [J]
  double elastic = 0;        ///< stored in contacts, spring-dashpot model only  [J]
};

double kinetic_energy(const State& state);                         ///< disks and driven walls [J]
double potential_energy(const State& state, const Vec2& gravity);  ///< zero at the origin     [J]
Vec2 momentum(const State& state);  ///< disks and driven walls [kg m/s]

/// What an impulse says of its contact. The cone's edge counts from 1 - 1e-9 of it on.
ContactStatus contact_status(double s_n, double s_t, double mu);

/// One step's answer from whatever solves the contact problem.
struct StepSolution {
  bool converged = false;
  bool failed = false;     ///< numerical failure: the step must not be taken
  bool refused = false;    ///< invalid input: neither
  bool cut_short = false;  ///< interrupted or out of time: the step is left for another run
  std::string message;
  Vector s;  ///< in the problem's variables
  ContactError error;
  int iterations = 0;
};

/// Solves the problem from the start s0 (size 0: no start).
using StepSolver = std::function<StepSolution(const ContactProblem&, const Vector& s0)>;

struct StepReport {
  int step = 0;
  double time = 0;
  int contacts = 0, active = 0;  ///< candidates; with s_n > 0
  bool converged = true;
  std::string message;
  int iterations = 0;
  ContactError error;
  EnergyLedger energy;
  Vec2 momentum = Vec2::Zero();            ///< of disks and driven walls             [kg m/s]
  Vec2 momentum_imbalance = Vec2::Zero();  ///< change - gravity - wall impulses       [kg m/s]
  double penetration = 0;                  ///< largest overlap at mid-step            [m]
  double detection_seconds = 0, assembly_seconds = 0, solve_seconds = 0;
};

/// Empty when a state can go on under a scene: same disks (radius, mass, inertia, material) and
/// walls (shape, motion, force, mass, direction, material); else one sentence that names the
/// difference.
std::string restart_mismatch(const Scene& scene, const State& state);

/// The contact problem of the step that would come next.
ContactProblem step_problem(const Scene& scene, const State& state, bool explicit_delassus);

/// A step that was not taken; the message says why.
struct StepFailure : std::runtime_error {
  enum class Kind { kNumerical, kInvalidInput, kCutShort };
  StepFailure(Kind k, const std::string& message) : std::runtime_error(message), kind(k) {}
  Kind kind;
};

/// Advances a state by the mid-point scheme (38)-(43):
///   q_m = q + h/2 v, contacts at q_m, one contact problem, q <- q_m + h/2 v⁺.
class TimeStepper {
 public:
  /// The scene must outlive the stepper. `explicit_delassus`: assemble W for every step.
  TimeStepper(const Scene& scene, StepSolver solver, bool explicit_delassus);

  /// Takes one step. Throws StepFailure, leaving the state at the end of the step before, when the
  /// solver failed, refused or was cut short, or when anything comes out not finite.
  StepReport advance(State& state);

  /// The contact problem of the last step.
  const ContactProblem& problem() const { return problem_; }

 private:
  const Scene& scene_;
  StepSolver solver_;
  bool explicit_delassus_;
  ContactProblem problem_;
};

}  // namespace bipot
