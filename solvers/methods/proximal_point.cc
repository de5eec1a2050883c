#include "solvers/methods/proximal_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/problem/delassus.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

constexpr double kShrink = 5;
constexpr double kLeastKappa = 1e-3;  // below, the solve is given up
// Factor of kappa after a solved step, by the fraction of its iteration limit that it needed.
double growth(double effort) {
  if (effort <= 0.2) return 10;
  if (effort <= 0.4) return 3;
  return effort <= 0.7 ? 1.5 : 1.0;
}
// Factor of kappa near a value that failed before.
constexpr double kCautious = 1.5;
// An iterate that differs from its anchor by less than this, relative, equals the anchor.
constexpr double kRoundOff = 4 * std::numeric_limits<double>::epsilon();
// Solved steps that move by less than this, relative, change only rounding errors; a row of them
// ends the loop.
constexpr double kStill = 1e-12;
constexpr int kStillSteps = 10;

double denominator(const ContactError& e) { return std::max(e.friction_power, kTheta * e.energy); }

/// "a=1,b=2" as a map; throws on a part without '='.
std::map<std::string, std::string> parse_assignments(const std::string& text) {
  std::map<std::string, std::string> out;
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string_view piece = rest.substr(0, comma);
    const std::size_t equals = piece.find('=');
    if (equals == std::string_view::npos || equals == 0) {
      throw std::invalid_argument(
          fmt::format("parameter inner_parameters: '{}' is not of the form name=value", piece));
    }
    out[std::string(piece.substr(0, equals))] = std::string(piece.substr(equals + 1));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return out;
}

/// The regularised problem; the matrix is built once for each kappa, the right-hand side for each
/// anchor.
class RegularisedProblem {
 public:
  RegularisedProblem(const ContactProblem& p, const Vector& weights)
      : p_(p), weights_(weights), diagonal_(Eigen::VectorXi::Constant(p.num_rows(), -1)) {
    sub_.dim = p.dim;
    sub_.mu = p.mu;
    sub_.mu_r = p.mu_r;
    sub_.mu_spin = p.mu_spin;
    sub_.row_scale = p.row_scale;
    SparseRows identity(p.num_rows(), p.num_rows());
    identity.setIdentity();
    sub_.W = p.W + 0 * identity;  // the diagonal is stored whatever the pattern of W
    sub_.W.makeCompressed();
    w_ = Eigen::Map<const Vector>(sub_.W.valuePtr(), sub_.W.nonZeros());
    for (int i = 0; i < p.num_rows(); ++i) {
      for (int k = sub_.W.outerIndexPtr()[i]; k < sub_.W.outerIndexPtr()[i + 1]; ++k) {
        if (sub_.W.innerIndexPtr()[k] == i) diagonal_[i] = k;
      }
    }
  }

  const ContactProblem& at(double kappa, const Vector& anchor) {
    Eigen::Map<Vector>(sub_.W.valuePtr(), sub_.W.nonZeros()) = w_;
    for (int i = 0; i < p_.num_rows(); ++i) sub_.W.valuePtr()[diagonal_[i]] += weights_[i] / kappa;
    sub_.u_free = p_.u_free - weights_.cwiseProduct(anchor) / kappa;
    return sub_;
  }

 private:
  const ContactProblem& p_;
  const Vector& weights_;
  ContactProblem sub_;
  Vector w_;
  Eigen::VectorXi diagonal_;  // positions of the diagonal in W's values
};

}  // namespace

ProximalReport proximal_point(const ProximalOptions& options, const Vector& weights, Vector start,
                              const InnerSolve& inner, SolveRun& run) {
  ProximalReport report;
  double kappa = std::min(options.kappa, options.kappa_max);
  int still = 0;
  double failed_at = kInfinity;
  // The run's errors are those of the last judged iterate; the anchor's own is stored here.
  ContactErrorEvaluator judge = run.whole().evaluator();
  double anchor_error = judge(start).guarded();
  for (;;) {
    report.kappa = kappa;
    ++report.steps;
    InnerReport step = inner(kappa, start);
    if (step.outcome == InnerReport::Outcome::kStop) return report;
    const bool usable = step.s.size() == start.size() && step.s.allFinite();
    const double error = usable ? judge(step.s).guarded() : kInfinity;
    if (step.outcome == InnerReport::Outcome::kSolved && usable) {
      const Vector root = weights.cwiseSqrt();
      const double moved = root.cwiseProduct(step.s - start).norm();
      const double size = root.cwiseProduct(step.s).norm();
      start = std::move(step.s);
      anchor_error = error;
      still = moved <= kStill * size ? still + 1 : 0;
      if (still >= kStillSteps) {
        run.end(SolveStatus::kStalled,
                fmt::format("stalled at round-off: proximal steps no longer move, kappa = "
                            "{:.1e}, best error {:.2e}",
                            kappa, run.best_error()));
        return report;
      }
      double next = kappa * growth(step.effort);
      if (next >= failed_at) {
        next = std::min(next, kCautious * kappa);
        failed_at *= kCautious;  // the anchor has moved: the failure fades
      }
      kappa = std::min(next, options.kappa_max);
      continue;
    }
    ++report.failed;
    if (error < anchor_error) {
      start = std::move(step.s);
      anchor_error = error;
    }
    failed_at = kappa;
    kappa /= kShrink;
    if (kappa < kLeastKappa) {
      run.end(SolveStatus::kStalled,
              fmt::format("the regularised problem is not solved even at kappa = {:.1e} ({}), "
                          "best error {:.2e}",
                          report.kappa, step.reason, run.best_error()));
      return report;
    }
  }
}

void solve_proximal_point(SolveRun& run) {
  const ContactProblem& p = run.problem();
  const SolverOptions& options = run.options();
  const Parameters& parameters = run.parameters();
  const std::string name = parameters.text("inner");
  const SolverEntry* inner_solver = find_solver(name);
  if (inner_solver == nullptr || name == "ppa") {
    return run.end(
        SolveStatus::kInvalidInput,
        fmt::format("parameter inner = '{}': expected another solver of the table", name));
  }
  SolverOptions inner_options;
  try {
    inner_options.parameters = parse_assignments(parameters.text("inner_parameters"));
    Parameters(inner_options.parameters, inner_solver->parameters);
  } catch (const std::invalid_argument& e) {
    return run.end(SolveStatus::kInvalidInput, fmt::format("inner solver {}: {}", name, e.what()));
  }
  if (const std::string beyond = beyond_solver(*inner_solver, p); !beyond.empty()) {
    return run.end(SolveStatus::kInvalidInput, "inner " + beyond);
  }
  inner_options.max_iterations = parameters.integer("inner_iterations");
  inner_options.cancelled = options.cancelled;
  inner_options.islands = false;

  const Vector weights = mean_diagonal(p, run.delassus().diagonal());
  RegularisedProblem regularised(p, weights);
  ContactErrorEvaluator outer = run.whole().evaluator();
  Vector start = run.start();
  // An iterate within the tolerance that was not judged would never be seen: the next inner solve
  // leaves it as it is.
  run.judge_every_iteration();
  run.end_setup();

  long inner_iterations = 0;
  int iteration = 0;
  ProximalReport report;
  if (!run.stop(0, start)) {
    const auto inner = [&](double kappa, const Vector& anchor) {
      InnerReport out;
      const ContactProblem& sub = regularised.at(kappa, anchor);
      const ContactError now = outer(anchor);
      // Errors are energies over energies: a tenth of the outer numerator, over the inner
      // denominator. From s = 0 the two denominators are equal up to rounding.
      const double share = denominator(now) / denominator(ContactErrorEvaluator(sub)(anchor));
      const double target = 0.1 * std::max(std::min(now.guarded(), 1.0), options.tol) *
                            (std::isfinite(share) ? std::min(share, 1.0) : 1.0);
      inner_options.tol = std::clamp(target, 1e-15, 0.1);
      inner_options.s0 = anchor;
      inner_options.time_limit = run.remaining_seconds();
      SolveResult r = run_solver(*inner_solver, sub, inner_options);
      inner_iterations += r.iterations;
      const bool solved = is_success(r.status);
      out.s = std::move(r.s);
      out.reason = fmt::format("{}: {}", name, r.message);
      out.effort = static_cast<double>(r.iterations) / inner_options.max_iterations;
      out.outcome = solved ? InnerReport::Outcome::kSolved : InnerReport::Outcome::kFailed;
      ++iteration;
      // A failed step may leave the anchor unchanged. To the run a repeated iterate is the end;
      // here the next kappa may still change it.
      const bool fresh = out.s.size() == p.num_rows() && out.s.allFinite() &&
                         (out.s - anchor).norm() > kRoundOff * out.s.norm();
      bool stop = false;
      if (fresh) {
        stop = run.stop(iteration, out.s, kappa);
      } else if (iteration >= options.max_iterations) {
        run.end(SolveStatus::kIterationLimit,
                fmt::format("iteration limit {} reached, best error {:.2e}", iteration,
                            run.best_error()));
        stop = true;
      } else {
        stop = run.end_if_out_of_time(iteration);
      }
      if (stop) out.outcome = InnerReport::Outcome::kStop;
      return out;
    };
    const ProximalOptions loop{.kappa = parameters.number("kappa"),
                               .kappa_max = parameters.number("kappa_max")};
    report = proximal_point(loop, weights, std::move(start), inner, run);
  }
  run.remark(fmt::format(
      "; {} proximal steps ({} failed) of {} with {} iterations in all, last kappa {:.1e}",
      report.steps, report.failed, name, inner_iterations, report.kappa));
}

}  // namespace bipot
