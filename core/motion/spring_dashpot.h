#pragma once

#include <functional>
#include <type_traits>
#include <vector>

#include "core/motion/spring_dashpot_setup.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// The smooth discrete element method of Cundall and Strack, Géotechnique 29 (1979) 47-65, with
/// which the paper compares its own: `bipot run --model dem` integrates it. Contacts overlap. At an
/// overlap d = -gap > 0, with the relative velocity (u_n, u_t) of core/motion/assembly.h,
///
///   F_n = max(0, k_n d - c_n u_n),                    no tension
///   x <- x + dt u_t, cut to k_t |x| <= mu F_n;   where it was cut (slip) F_t = -k_t x,
///                                                else F_t = -k_t x - c_t u_t, cut to mu F_n.
///
/// Here x is the elongation of the tangential spring since the contact began: in space a vector, which
/// turns with n and keeps its length. c = 2 zeta √(k m) has
/// the pair's effective mass m of the direction and zeta from e_n (spring_dashpot_setup.h). Each
/// substep dt is explicit and has the form of the nonsmooth step (38), (43):
///
///   q_m = q + dt/2 v,   v <- v + dt A⁻¹ (F_ext + H F(q_m, v)),   q <- q_m + dt/2 v
///
/// It is of second order, but of first order in the dashpots, which use the velocity half a substep
/// earlier. Friction acts at the lever arm a_i, as in H.
///
/// Used like TimeStepper: advance() takes one step h of the scene, in setup().substeps substeps.
/// Contacts of the state carry the impulses of the whole step (force = s/h is the mean force), the
/// geometry and velocities at its end, and the tangential springs. A restart continues bit for bit.
///
/// StepReport: iterations = substeps, error = NaN (there is no contact problem to judge),
/// penetration = largest overlap in any substep. shock_loss and friction_loss are the work of the
/// normal and tangential forces less the energy stored in their springs. With e_n = 1 shock_loss is
/// the error of the integration.
template <int D>
class SpringDashpotStepper {
 public:
  /// The scene must outlive the stepper. `cut_short` is polled every few substeps; true ends the
  /// step without result. `most_created`: energy that a step may create, over the energy in play.
  /// Throws std::invalid_argument as spring_dashpot_setup() does.
  explicit SpringDashpotStepper(const Scene<D>& scene, std::function<bool()> cut_short = {},
                                double most_created = 0.1);

  /// Throws StepFailure, with the state as before the step, in these cases: overlap or energy
  /// exceed the limits, a value is not finite, or the step was cut short. Substeps allocate memory
  /// only in a new search of neighbours.
  StepReport<D> advance(State<D>& state);

  const SpringDashpotSetup& setup() const { return setup_; }

  /// From now on a step with passages (core/motion/passage.h) in a substep is not taken.
  void refuse_passages() { refuse_passages_ = true; }

 private:
  struct Particle {
    Vec<D> x, v;
    Spin<D> spin;
    std::conditional_t<D == 2, double, Eigen::Quaterniond> turned;
    double inv_mass, inv_inertia, radius;
    Vec<D> force = Vec<D>::Zero();
    Spin<D> torque = no_turn<D>();
  };
  /// A pair in contact or close to it.
  struct Pair {
    int i = 0, j = 0;
    double mu = 0, c_n = 0, c_t = 0;
    Tangent<D> spring = no_turn<D>();
    double f_n = 0, s_n = 0;                            // force of the last substep, and
    Tangent<D> f_t = no_turn<D>(), s_t = no_turn<D>();  // impulse of the step so far
    bool touched = false;                               // in this step
  };
  struct Geometry {
    Vec<D> n;
    double gap;
  };
  struct RelativeVelocity {
    double n;
    Tangent<D> t;
  };

  struct Elastic {
    double normal = 0, tangential = 0;
    double sum() const { return normal + tangential; }
  };

  void load(const State<D>& state);
  void place(State<D>& state) const;
  void check_passages(const State<D>& state, State<D> before, StepReport<D>& report) const;
  void find_pairs(const State<D>& state);
  Pair make_pair(int i, int j) const;
  Geometry geometry(const Pair& pair) const;
  RelativeVelocity relative_velocity(const Pair& pair, const Vec<D>& n) const;
  void drift(double dt);
  void apply_contacts(double dt);
  void kick(double dt);
  void close_work(double dt);
  Elastic elastic_energy() const;
  void integrate(const State<D>& state, StepReport<D>& report);
  State<D> state_after(const State<D>& state) const;
  void close_ledger(const State<D>& state, const Elastic& elastic_before, State<D>& next,
                    StepReport<D>& report);
  double path_per_substep(double dt) const;
  std::string overlap_pair() const;

  const Scene<D>& scene_;
  SpringDashpotSetup setup_;
  std::function<bool()> cut_short_;
  double most_created_;
  bool refuse_passages_ = false;

  std::vector<Particle> bodies_;
  std::vector<Wall<D>> walls_, walls_before_;  // now; as they begin the step
  Vec<D> gravity_ = Vec<D>::Zero();            // of the step
  std::vector<double> wall_push_;    // force on driven walls along their direction, this substep
  std::vector<Pair> pairs_, fresh_;  // sorted by (i, j)
  double skin_ = 0, path_ = 0;       // of the neighbour list: its reach, and the used part of it
  double work_n_ = 0, work_t_ = 0;   // of contact forces in this step
  double wall_work_ = 0;
  Vec<D> external_ = Vec<D>::Zero();  // impulse on bodies and driven walls from outside
  double worst_overlap_ = 0;          // relative to the smaller radius
  double penetration_ = 0;
  int worst_i_ = -1, worst_j_ = -1;
};

}  // namespace bipot
