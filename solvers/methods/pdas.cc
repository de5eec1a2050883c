#include "solvers/methods/pdas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "solvers/kernels/contact_residual.h"
#include "solvers/kernels/contact_scaling.h"
#include "solvers/kernels/stagnation_test.h"
#include "solvers/systems/shifted_delassus.h"

namespace bipot {
namespace {

constexpr int kSetPatience = 500;     // solves without halving the error before kappa is bounded
constexpr double kBoundFalls = 100;   // of kappa, each time
constexpr double kSetsSolved = 1e-9;  // residual of a regularised problem in space, relative

/// Sets of all contacts, one letter each: o open, k stick, p slip; with rolling friction p, q, r ... by
/// the parts that slip or roll.
template <ContactRows D>
char set_of(const Local<D>& z, const FrictionOf<D>& mu) {
  if (z[0] <= 0) return 'o';
  int moving = 0, part = 1;
  each_bounded<D>(mu, [&](auto first, auto count, double bound) {
    if (!(part_norm<first(), count()>(z) <= bound * z[0])) moving += part;
    part *= 2;
  });
  return moving == 0 ? 'k' : static_cast<char>('p' + moving - 1);
}

/// The active sets of one regularised problem.
template <ContactRows D>
class ActiveSets {
 public:
  ActiveSets(SolveRun& run, const Vector& weights)
      : p_(run.problem()),
        delassus_(run.delassus()),
        weights_(weights),
        system_(p_, ShiftedDelassus::Form::kAuto, run.factor(), run.factor_stop()),
        sets_(to_size(p_.num_contacts()), ' '),
        R_(to_size(p_.num_contacts() * D * D)),
        residual_(p_.num_rows()) {}

  /// Sets and residual of s, and the linear system of these sets. Returns the residual over the
  /// size of z, as energies.
  double update(double kappa, const Vector& anchor, const Vector& s) {
    delassus_.velocity(s, u_);
    double gap = 0, size = 0;
    for (int c = 0; c < p_.num_contacts(); ++c) {
      const Local<D> weight = weights_.segment<D>(c * D);
      const Local<D> rho = kappa * weight.cwiseInverse();
      const Local<D> z = local<D>(anchor, c) - rho.cwiseProduct(local<D>(u_, c));
      Eigen::Matrix<double, D.count, D.count> jacobian;
      const FrictionOf<D> friction = friction_of<D>(p_, c);
      const Local<D> on_law = split_projection<D>(z, friction, jacobian);
      const Local<D> f = on_law - local<D>(s, c);
      residual_.segment<D>(c * D) = f;
      gap += f.dot(weight.cwiseProduct(f));
      size += on_law.dot(weight.cwiseProduct(on_law));
      sets_[to_size(c)] = set_of<D>(z, friction);
      Eigen::Map<Eigen::Matrix<double, D.count, D.count, Eigen::RowMajor>> block(
          &R_[to_size(c * D * D)]);
      block = jacobian * rho.asDiagonal();
    }
    return std::sqrt(gap / size);
  }
  const std::string& sets() const { return sets_; }

  /// s of the present sets; false if the system is singular.
  bool solve(Vector& s) {
    if (!system_.factor(R_)) return false;
    system_.solve(residual_, step_);
    s += step_;
    return s.allFinite();
  }

 private:
  const ContactProblem& p_;
  const DelassusOperator& delassus_;
  const Vector& weights_;
  ShiftedDelassus system_;
  std::string sets_;
  std::vector<double> R_;
  Vector u_, residual_, step_;
};

template <ContactRows D>
void iterate_sets(SolveRun& run) {
  const Vector weights = mean_diagonal(run.problem(), run.delassus().diagonal());
  const int cap = run.parameters().integer("set_changes");
  ActiveSets<D> active(run, weights);
  Vector start = run.start();
  run.end_setup();
  if (run.stop(0, start)) return;
  int iteration = 0, begun = 0;
  StagnationTest stagnation(kSetPatience);
  bool stagnates = false;
  const auto inner = [&](double kappa, const Vector& anchor) {
    InnerReport out{.s = anchor};
    std::vector<std::string> seen;
    for (int k = 0; k < cap; ++k) {
      const double residual = active.update(kappa, anchor, out.s);
      const bool same = !seen.empty() && seen.back() == active.sets();
      if (k > 0 && (D.in_plane() ? same : residual <= kSetsSolved)) {
        out.outcome = InnerReport::Outcome::kSolved;
        out.effort = static_cast<double>(k) / cap;
        return out;
      }
      const auto before = std::find(seen.begin(), seen.end(), active.sets());
      if (D.in_plane() && before != seen.end()) {
        out.reason = fmt::format("the sets cycle with period {}", seen.end() - before);
        return out;
      }
      seen.push_back(active.sets());
      if (!active.solve(out.s)) {
        out.reason = "the system of the sets is singular";
        return out;
      }
      const bool stop = run.stop(++iteration, out.s, kappa, /*moving=*/true);
      stagnates = !stop && stagnation.stagnates(iteration - begun, run.best_error());
      if (stop || stagnates) {
        out.outcome = InnerReport::Outcome::kStop;
        return out;
      }
    }
    out.reason = fmt::format("the sets still change after {} solves", cap);
    return out;
  };
  run.judge_every_iteration();
  ProximalOptions loop{.kappa = run.parameters().number("kappa"),
                       .kappa_max = run.parameters().number("kappa_max")};
  int steps = 0, failed = 0;
  for (;;) {
    const ProximalReport report = proximal_point(loop, weights, std::move(start), inner, run);
    steps += report.steps;
    failed += report.failed;
    if (!stagnates) break;
    loop.kappa_max /= kBoundFalls;
    if (loop.kappa_max < 1) {
      run.end(SolveStatus::kStalled, fmt::format("the sets do not settle in {} solves, best error "
                                                 "{:.2e}",
                                                 iteration, run.best_error()));
      break;
    }
    stagnates = false;
    stagnation = StagnationTest(kSetPatience);
    begun = iteration;
    start = run.best_impulse();
  }
  run.remark(fmt::format("; {} proximal steps ({} failed), kappa up to {:.0e}", steps, failed,
                         loop.kappa_max));
}

}  // namespace

void solve_pdas(SolveRun& run) {
  dispatch_rows(run.problem(), [&](auto d) { iterate_sets<d()>(run); });
}

}  // namespace bipot
