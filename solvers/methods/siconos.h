#pragma once

#include <memory>

#include "solvers/solver.h"

namespace bipot {

/// Siconos Numerics' solvers (Acary and others, Apache-2.0 library, Debian's
/// libsiconos-numerics-dev) behind this project's contract, built with BIPOT_WITH_SICONOS=ON only.
///
/// The frames are alike: normal first, then tangents, contact after contact. Siconos knows d = 2
/// and 3: where it lacks a solver for the problem's dimension, each contact gets further tangents
/// that nothing else depends on, with the mobility of its other rows and no free velocity; their
/// impulses are zero at a solution and are dropped. Units are chosen such that the mean of W_nn and
/// the largest free velocity are one, as Siconos has absolute thresholds.
///
/// Siconos decides by its own measure when to return, so each call is judged by the run and
/// repeated from where it ended: with a tenth of its tolerance where it claimed convergence, with
/// more iterations where it ran into their limit. A call cannot be interrupted: a time limit is
/// looked at between calls. Siconos ends the process on some internal errors; that cannot be caught
/// here.
void solve_siconos_nsgs(SolveRun& run);
void solve_siconos_nsn_ac(SolveRun& run);
void solve_siconos_admm(SolveRun& run);
void solve_siconos_prox(SolveRun& run);
void solve_siconos_lemke(SolveRun& run);

/// Siconos' NSGS as its own users call it: one call, from s = 0, to its own measure. For
/// measurements; the solvers above are for solving.
class SiconosNsgs {
 public:
  /// Solver of one contact of a sweep. The planar NSGS has its own, exact, and no choice. The
  /// others belong to the NSGS in 3D, in which a planar problem has an inert tangent.
  enum class Local { kPlanar, kNewton, kNewtonAndProjection, kProjection, kQuartic };

  /// Copies the problem (d >= 1, with W) into Siconos' blocks and units. `freezing`: sweeps that
  /// skip a settled contact, 0 for none. Throws std::invalid_argument for kPlanar in 3D.
  SiconosNsgs(const ContactProblem& problem, Local local, int freezing);
  ~SiconosNsgs();
  SiconosNsgs(const SiconosNsgs&) = delete;
  SiconosNsgs& operator=(const SiconosNsgs&) = delete;

  /// Sweeps from s = 0 until Siconos' residual is at most `tol`, at most `max_sweeps`; true if
  /// Siconos reports success.
  bool run(double tol, int max_sweeps);

  Vector impulse()
      const;           ///< of the last run, as Siconos left it: m, the problem's variables [N s]
  int sweeps() const;  ///< of the last run
  double residual() const;  ///< of the last run, as Siconos reports it [-]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bipot
