#pragma once

#include <functional>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/criterion/contact_error.h"
#include "core/motion/state.h"
#include "core/problem/contact_problem.h"
#include "core/scene/scene.h"

namespace bipot {

/// Energy of a state and what the steps so far did to it. Closed:
///   kinetic + potential + elastic = initial + wall_work + passed - friction_loss - shock_loss
///                                  - cohesion_loss
/// up to round-off in the nonsmooth model, because the impulses act through the mean of the
/// velocities before and after the step, as the displacement does (38), (43).
struct EnergyLedger {
  double kinetic = 0;        ///< disks and driven walls                         [J]
  double potential = 0;      ///< of gravity, zero at the origin                 [J]
  double wall_work = 0;      ///< by walls, forces and drag, since step 0        [J]
  double friction_loss = 0;  ///< dissipated by tangential impulses              [J]
  double shock_loss = 0;     ///< dissipated by normal impulses                  [J]
  double imbalance = 0;      ///< of the last step: what does not add up         [J]
  double elastic = 0;        ///< stored in contacts, spring-dashpot model only  [J]
  double cohesion_loss = 0;  ///< taken by cohesion, less what it gave           [J]
  double passed = 0;         ///< came in less what left, by inlets and outlets  [J]
};

/// One step's answer from whatever solves the contact problem.
struct StepSolution {
  bool converged = false;
  bool failed = false;      ///< numerical failure: the step must not be taken
  bool refused = false;     ///< invalid input: neither
  bool unsolvable = false;  ///< the problem provably has no solution; with `failed`: ends the run
  bool cut_short = false;   ///< interrupted or out of time: the step is left for another run
  std::string message;
  Vector s;  ///< in the problem's variables
  ContactError error;
  int iterations = 0;
};

/// Solves the problem from the start s0 (size 0: no start).
using StepSolver = std::function<StepSolution(const ContactProblem&, Vector s0)>;

/// How a step was cut into parts for an accuracy (solvers/simulation/accurate_step.h).
struct StepParts {
  int parts = 0;  ///< 0: no accuracy was asked for
  /// Rejected parts: an impact would have misplaced a body, a contact drifted, an acceleration
  /// changed, or the part was not solved or let bodies through each other.
  int misplacing = 0, drifting = 0, accelerating = 0, failed = 0;
  double smallest = 0;       ///< part, but for those that end with the step                  [s]
  std::string limited_by;    ///< what made that part so small: "impact I J", "drift", ...
  double misplaced = 0;      ///< largest displacement by an impact over the smaller radius [-]
  double misplaced_sum = 0;  ///< sum of the largest ones of all parts                        [-]

  int rejected() const { return misplacing + drifting + accelerating + failed; }
};

template <int D>
struct StepReport {
  int step = 0;
  double time = 0;
  int contacts = 0, active = 0;  ///< candidates; with s_n > 0
  bool converged = true;
  std::string message;
  int iterations = 0;
  ContactError error;
  EnergyLedger energy;
  Vec<D> momentum = Vec<D>::Zero();            ///< of disks and driven walls        [kg m/s]
  Vec<D> momentum_imbalance = Vec<D>::Zero();  ///< change - gravity - wall impulses [kg m/s]
  bool unsolvable = false;                     ///< not converged: there is no solution (proved)
  double penetration = 0;                      ///< largest overlap at mid-step      [m]
  double overlap = 0;                          ///< largest over the smaller radius  [-]
  std::string overlap_pair;                    ///< its pair, if there is any and it is asked for
  double travel = 0;                           ///< largest way of a body over its radius
  int passages = 0;                            ///< pairs that went through each other
  std::string passage;                         ///< the first of them (core/motion/passage.h)
  double force_energy = 0;                     ///< as of core/motion/step_outcome.h [J]
  double joint_loss = 0;                       ///< part of the shock loss, by joints [J]
  double from_rest = 0;  ///< with joints: energy that forces alone give bodies at rest [J]
  StepParts cut;
  double detection_seconds = 0, assembly_seconds = 0, solve_seconds = 0;

  /// Adds the iterations and times of another part of the step, or of an attempt at it that was not
  /// taken.
  void add_cost(const StepReport& other) {
    iterations += other.iterations;
    detection_seconds += other.detection_seconds;
    assembly_seconds += other.assembly_seconds;
    solve_seconds += other.solve_seconds;
  }
};

/// The contact problem of the step that would come next, with Poisson's law of its first phase;
/// bodies that are to leave or come in before have.
template <int D>
ContactProblem step_problem(const Scene<D>& scene, const State<D>& state);

/// A step that was not taken; the message says why.
struct StepFailure : std::runtime_error {
  enum class Kind {
    kNumerical,
    kInvalidInput,
    kCutShort,
    kNotConverged,
    kUnsolvable,  ///< its problem provably has no solution
    kPassage,     ///< bodies or walls would have gone through each other
    /// No solver can help. Bodies at mid-step have contacts without a normal, a cell is too short,
    /// a wall moves into what pins hold, or joints made energy.
    kPlaces
  };
  StepFailure(Kind k, const std::string& message) : std::runtime_error(message), kind(k) {}
  /// Names the step that comes after the state `before`.
  template <int D>
  StepFailure(Kind k, const State<D>& before, const std::string& why)
      : StepFailure(k, before.step, before.time, why) {}
  /// A smaller step may cure it, whatever the scene's rule for passages.
  bool may_yield() const { return kind == Kind::kNumerical || kind == Kind::kPlaces; }
  /// The way of a body passes, or ends on, another or a wall.
  bool is_of_places() const { return kind == Kind::kPassage || kind == Kind::kPlaces; }
  Kind kind;

 private:
  StepFailure(Kind k, int steps_before, double time_before, const std::string& why);
};

template <int D>
class Neighbours;  // core/motion/neighbours.h

/// Advances a state by the mid-point scheme (38)-(43), after bodies have left and come in where the
/// scene has outlets and inlets (core/motion/population.h):
///   q_m = q + h/2 v, contacts at q_m, one contact problem, q <- q_m + h/2 v⁺.
/// One class for a state on one process and for one that lies on several. There each process takes
/// the steps of its own bodies, and sums of the ledger are taken over all.
template <int D>
class TimeStepper {
 public:
  /// The scene must outlive the stepper. `threads`:
  /// of detection and assembly; they change no bit.
  TimeStepper(const Scene<D>& scene, StepSolver solver, int threads = 1);
  /// For the bodies of one of several processes; `neighbours` must outlive the stepper and knows
  /// the state that is advanced. Not for scenes with gates or projected overlaps.
  TimeStepper(const Scene<D>& scene, Neighbours<D>& neighbours);
  ~TimeStepper();
  TimeStepper(TimeStepper&&) noexcept;

  /// Takes one step. Throws StepFailure, leaving the state at the end of the step before, when the
  /// solver failed, refused or was cut short, or when anything comes out not finite; on all of
  /// several processes.
  StepReport<D> advance(State<D>& state);

  /// From now on a report names the pair of its largest overlap only where this is larger; on all of
  /// several processes. At first it always does.
  void name_overlaps_beyond(double overlap);
  /// From now on a step with passages (core/motion/passage.h) is not taken: StepFailure.
  void refuse_passages();

  /// The contact problem of the last step, of this process's contacts; with Poisson's law that of
  /// the phase that was solved last.
  const ContactProblem& problem() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace bipot
