#pragma once

#include <functional>
#include <memory>
#include <string_view>

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
/// repeated from where it ended: with a tenth of its tolerance where it claimed convergence or came
/// no further, with more iterations where it ran into their limit. A call cannot be interrupted: an
/// end is asked for between calls, and NSGS' calls are cut for that. Siconos ends the process on
/// some internal errors; that cannot be caught here.
///
/// `name`: NSGS, NSN_AC, ADMM, PROX or LEMKE.
std::function<void(SolveRun&)> siconos_solver(std::string_view name);

/// Siconos 4.4 frees no factor of its Newton iterations: beyond, they may fill the memory.
inline constexpr int kSiconosNewtonMaxContacts = 1000;

/// A solver of Siconos as its own users call it: one call, from s = 0, to its own measure, with its
/// default options. For measurements; the solvers above are for solving.
class SiconosCall {
 public:
  /// The planar NSGS has its own exact solver of one contact. The next four are the NSGS in 3D with
  /// its solvers of one contact. The last two are the nonsmooth Newton method on Alart and
  /// Curnier's map, and ADMM, both in 3D. In 3D a planar problem has an inert tangent.
  enum class Algorithm {
    kPlanar,
    kNewton,
    kNewtonAndProjection,
    kProjection,
    kQuartic,
    kAlartCurnier,
    kAdmm
  };

  /// Copies the problem (d >= 1, with W) into Siconos' storage and units. `freezing`: sweeps of
  /// NSGS that skip a settled contact, 0 for none. Throws std::invalid_argument for kPlanar in 3D.
  SiconosCall(const ContactProblem& problem, Algorithm algorithm, int freezing);
  ~SiconosCall();
  SiconosCall(const SiconosCall&) = delete;
  SiconosCall& operator=(const SiconosCall&) = delete;

  /// Iterates from s = 0 until Siconos' residual is at most `tol`, at most `max_iterations`; true
  /// if Siconos reports success.
  bool run(double tol, int max_iterations);

  Vector impulse()
      const;  ///< of the last run, as Siconos left it: m, the problem's variables [N s]
  int iterations() const;   ///< of the last run
  double residual() const;  ///< of the last run, as Siconos reports it [-]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bipot
