#pragma once

#include <functional>
#include <string>

#include "solvers/solve_run.h"

namespace bipot {

/// Proximal point method (Rockafellar 1976; for Coulomb's law a heuristic, as the law is not
/// monotone). Around the anchor s_k the law is solved with
///
///     u = (W + D / kappa) s + (u_free - D s_k / kappa),      s_{k+1} = its solution,
///
/// D = diag(W_nn, W_tt) of each contact (tangents averaged), so that kappa is dimensionless. The
/// term vanishes at a fixed point: no regularisation remains there, for any W.
///
/// kappa follows the inner solver: a solved step multiplies it, the more the less it cost. A failed
/// one divides it, and the anchor stays unless the inner iterate is closer to the solution. The
/// failed value is approached again by small factors only.
struct ProximalOptions {
  double kappa = 100;      ///< first value                                                 [-]
  double kappa_max = 1e7;  ///< largest value                                               [-]
};

/// Outcome of one regularised problem.
struct InnerReport {
  enum class Outcome {
    kSolved,  ///< to the accuracy requested of the inner solver
    kFailed,  ///< s is its last iterate, of any quality
    kStop     ///< the run is over
  };
  Outcome outcome = Outcome::kFailed;
  Vector s;
  double effort = 1;   ///< iterations over the inner limit: decides how kappa grows
  std::string reason;  ///< of a failure
};
/// (kappa, anchor) -> s.
using InnerSolve = std::function<InnerReport(double kappa, const Vector& anchor)>;

struct ProximalReport {
  int steps = 0;     ///< inner problems, failed ones included
  int failed = 0;    ///< failed ones
  double kappa = 0;  ///< of the last inner problem
};

/// The outer loop, for every inner solver. `weights`: D, see mean_diagonal(). Runs until the inner
/// solver reports kStop. Ends the run itself if it cannot continue (kappa below its minimum, or no
/// movement at the largest kappa).
ProximalReport proximal_point(const ProximalOptions& options, const Vector& weights, Vector start,
                              const InnerSolve& inner, SolveRun& run);

/// The parameters that every solver with this outer loop has.
inline constexpr ParameterSpec kKappaParameter = ParameterSpec::number(
    "kappa", "100", {1e-3, 1e12},
    "first proximal parameter, at most kappa_max, in units of the diagonal of W");
inline constexpr ParameterSpec kLargestKappaParameter =
    ParameterSpec::number("kappa_max", "1e7", {1e-3, 1e12}, "largest proximal parameter");

inline constexpr ParameterSpec kProximalPointParameters[] = {
    ParameterSpec::text("inner", "pgs",
                        "solver of the regularised problems, any other row of the table"),
    ParameterSpec::text("inner_parameters", "", "its parameters, name=value,name=value"),
    ParameterSpec::integer("inner_iterations", "20000", {1, 1e9},
                           "iteration limit of each regularised problem", "iterations"),
    kKappaParameter,
    kLargestKappaParameter,
};

/// `ppa`: the loop around another solver, by name. The inner tolerance follows the outer error: a
/// tenth of it, converted between the two denominators of the criterion. An iteration is one
/// regularised problem; the message gives the sum of inner iterations.
void solve_proximal_point(SolveRun& run);

}  // namespace bipot
