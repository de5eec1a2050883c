#include "solvers/methods/homotopy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/portable_random.h"
#include "core/problem/delassus.h"
#include "solvers/homotopy/path_follower.h"
#include "solvers/homotopy/proximal_term.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

// Number of starts of a chain, prepared by apgd, each to a third of the error of the one before.
// The chain ends after one that gained less than kGain.
constexpr int kStarts = 6;
constexpr double kGain = 0.9;
// Iterations of a chain, for each contact and in all.
constexpr int kChainIterations = 6, kLeastChain = 5000;
// A chain of starts with one schedule of delta. Its end is a matter of chance; several schedules
// complement each other.
struct Chain {
  double looser;  // error of the first start in units of start_tol
  int schedule;   // after that of the parameter
};
constexpr Chain kChains[] = {{1, 0}, {1, 1}, {1, 2}, {10, 0}, {30, 1}, {3, 2}, {100, 0}, {0.3, 1}};
// Number of perturbed chains of one start after each of them: the best impulse so far, with every
// component changed by up to kShaken of it.
constexpr int kShakes = 6;
constexpr double kShaken = 0.1;
constexpr int kShakenIterations = 3, kLeastShaken = 2000;  // for each contact, at least
// Schedule of delta. After a failed path, values up to `barrier` times its delta are avoided for a
// while; the factor decreases with every successful path.
struct Schedule {
  bool slow;  // the root of kDeltaShrink is taken
  double barrier, fade;
  int contacts;  // for each pivot of a path that is allowed
};
constexpr Schedule kSchedules[] = {{false, 3, 0.6, 24}, {false, 4, 0.8, 18}, {true, 0, 0, 18}};
constexpr int kLeastPivots = 200;  // of a path, allowed at least
constexpr int kNumSchedules = std::size(kSchedules);
// A stall below it, and within ten tolerances, is rounding, which no other chain can reduce.
constexpr double kRoundingError = 1e-10;
// Paths from one start, failed ones included.
constexpr int kStages = 60;
// Failed paths in a row: those without a result, and those with a turning point.
constexpr int kFailures = 7, kTurns = 20;
// Least t of a turning point that serves as a start.
constexpr double kUsefulTurn = 0.3;
// Factors of delta after a failed path.
constexpr double kRaise = 5, kRaiseAtTurn = 3;
constexpr double kSmallestDelta = 1e-10, kLargestDelta = 1;
// Factor of delta after a path that arrived.
constexpr double kDeltaShrink = 0.3;
// Iterations of apgd that prepare a start.
constexpr int kStartIterations = 2000;
// Random lift of small parameters of the start, which keeps paths away from ties, in means.
constexpr double kLift = 1e-2;
// Errors below this must not grow again while delta is below kFine.
constexpr double kSettled = 1e-5, kFine = 1e-6;
// Normal impulse minus velocity below this, relative to the mean, counts as zero.
constexpr double kNothing = 1e-10;
// Stages at the smallest delta without a gain before the solver ends.
constexpr int kIdleStages = 4;

class Homotopy {
 public:
  explicit Homotopy(SolveRun& run)
      : run_(run),
        options_(run.options()),
        parameters_(run.parameters()),
        problem_(run.problem(), run.delassus().diagonal()),
        follower_(problem_, [this] { return run_.out_of_time(); }),
        random_(static_cast<unsigned>(parameters_.integer("seed"))) {
    run_.end_setup();
  }

  void operator()() {
    if (!judge(run_.start())) {
      const std::string first = parameters_.choice("schedule");
      const int schedule = first == "bold" ? 0 : first == "cautious" ? 1 : 2;
      const double start_tol = parameters_.number("start_tol");
      bool skip = parameters_.choice("shake") == "first";
      for (const Chain& c : kChains) {
        if (c.looser > 1 && start_tol >= 1) continue;  // that start was had
        schedule_ = kSchedules[(schedule + c.schedule) % kNumSchedules];
        if (!skip && (chain(run_.start(), std::min(1.0, c.looser * start_tol)) || at_rounding()))
          break;
        skip = false;
        if (shaken_chains()) break;
      }
      if (!ended_) {
        run_.end(SolveStatus::kStalled,
                 fmt::format("stalled after {}, best error {:.2e}", counted(), run_.best_error()));
      }
    }
    run_.set_iterations(iteration());
  }

 private:
  int iteration() const { return start_steps_ + follower_.counts().pivots + judged_; }
  std::string counted() const {
    const PathFollower::Counts& n = follower_.counts();
    return fmt::format(
        "{} pivots on {} paths ({} turns, {} paths failed), {} Newton steps, {} of apgd", n.pivots,
        n.paths, n.turns, n.failed, n.newton, start_steps_);
  }
  bool end(SolveStatus status, std::string text) {
    run_.end(status, std::move(text));
    return ended_ = true;
  }

  /// Starts in sequence, each the best impulse of this chain so far, prepared by apgd to a third of
  /// its error. True: the solve ends.
  bool chain(Vector s, double wanted) {
    chain_error_ = kInfinity;
    chain_best_ = s;
    chain_end_ = iteration() + std::max(kLeastChain, kChainIterations * problem_.num_contacts());
    for (int round = 0; round < kStarts && iteration() < chain_end_; ++round) {
      const double before = chain_error_;
      if (prepare(s, wanted) || stages(std::move(s))) return true;
      if (!(chain_error_ < kGain * before)) break;
      s = chain_best_;
      wanted = std::min(wanted, chain_error_) / 3;
    }
    return false;
  }

  /// The error is due to rounding, which another start would meet again.
  bool at_rounding() const {
    return run_.best_error() <= std::min(10 * options_.tol, kRoundingError);
  }

  /// Chains from perturbed copies of the best impulse. True: the solve ends.
  bool shaken_chains() {
    for (int k = 0; k < kShakes; ++k) {
      Vector s = run_.best_impulse();
      for (double& x : s) x *= 1 + kShaken * random_.symmetric();
      chain_error_ = kInfinity;
      chain_end_ =
          iteration() + std::max(kLeastShaken, kShakenIterations * problem_.num_contacts());
      if (judge(s) || stages(std::move(s))) return true;
      if (at_rounding()) return true;
    }
    return false;
  }

  /// Judges an impulse; true: the solve ends.
  bool judge(const Vector& s) {
    // The last impulse belongs into the history.
    if (!run_.due(iteration()) && run_.meets(s)) run_.judge_next();
    if (run_.stop(iteration(), s, delta_, /*moving=*/true)) {
      ended_ = true;
      if (run_.status() == SolveStatus::kConverged && follower_.counts().paths > 0) {
        return end(run_.status(),
                   fmt::format("{} test met after {}", to_string(options_.stop), counted()));
      }
      return true;
    }
    if (run_.last_error() < chain_error_) {
      chain_error_ = run_.last_error();
      chain_best_ = s;
    }
    return false;
  }

  /// apgd from s to the error `wanted`. True: the solve ends.
  bool prepare(Vector& s, double wanted) {
    const int limit = std::min(kStartIterations, options_.max_iterations - iteration());
    if (wanted >= 1 || limit <= 0) return false;
    const SolveResult start = run_.nested("apgd", wanted, limit, s);
    start_steps_ += start.iterations;
    s = start.s;
    return judge(s);
  }

  /// The point of the manifold nearest to s. Bounded parameters near zero are perturbed at random:
  /// this avoids ties, and paths that begin on a face.
  LawPoint lifted_point(const Vector& s, double error) {
    const Vector velocity = problem_.W * s + problem_.b;
    LawPoint point = nearest_point(problem_, s, velocity);
    const int d = problem_.dim, c = problem_.num_contacts();
    double impulse = 0;
    for (int i = 0; i < c; ++i) impulse += std::abs(s[i * d]) / c;
    const double speed = velocity.cwiseAbs().sum() / c;
    if (impulse == 0) impulse = speed;
    const double lift = kLift * std::min(1.0, error / 1e-2);
    for (int i = 0; i < c; ++i) {
      // A contact without impulse and velocity, as beside the columns of a square lattice, stays
      // open along the whole path if it begins open.
      if (std::abs(s[i * d] - velocity[i * d]) <= kNothing * std::max(impulse, speed)) {
        point.set(problem_, i, Cell::kTakeOff);
        point.value[i * d] = 0;
        for (int k = 1; k < d; ++k) point.value[i * d + k] = velocity[i * d + k];
      }
    }
    for (int slot = 0; slot < problem_.num_rows(); ++slot) {
      if (point.bound[slot] == 0) continue;
      const double part = 0.5 + random_.uniform();
      const bool pushes = is_impulse(point.column[to_size(slot)]);
      const double least = lift * part * (pushes ? impulse : speed);
      if (point.bound[slot] * point.value[slot] < least) {
        point.value[slot] += point.bound[slot] * least;
      }
    }
    return point;
  }

  /// Paths from s with decreasing delta. True: the solve ends.
  bool stages(Vector anchor) {
    const double shrink = schedule_.slow ? std::sqrt(kDeltaShrink) : kDeltaShrink;
    delta_ = parameters_.number("delta");
    double factor = shrink, last_error = kInfinity;
    double best = last_error;
    anchor.array() /= problem_.impulse_unit.array();
    Vector s;
    LawPoint point = lifted_point(anchor, run_.last_error());
    const int longest = std::max(kLeastPivots, problem_.num_contacts() / schedule_.contacts);
    int failures = 0, idle = 0;
    double failed = 0;  // delta of the last path that did, fading
    for (int stage = 0; stage < kStages && iteration() < chain_end_; ++stage) {
      LawPoint before = point;
      before.bound.resize(0);  // a contact's cell tells them
      const int left = options_.max_iterations - iteration();
      proximal_term(problem_, point, anchor, delta_, proximal_);
      const PathFollower::End path =
          follower_.follow(point, anchor, proximal_, std::min(longest, left));
      point.impulse(problem_, s);
      if (path == PathFollower::kSolved) {
        ++judged_;
        if (judge(s.cwiseProduct(problem_.impulse_unit))) return true;
        const double error = run_.last_error();
        failures = 0;
        idle = error < 0.9 * best ? 0 : idle + 1;
        best = std::min(best, error);
        if (idle >= kIdleStages && best < kSettled && delta_ <= 10 * kSmallestDelta) return false;
        if (delta_ < kFine && last_error < kSettled && error > 2 * last_error) {
          point = std::move(before);
          point.find_bounds(problem_);
          delta_ = std::min(10 * delta_, 1e-5);
          continue;
        }
        anchor = s;
        last_error = error;
        failed *= schedule_.fade;
        delta_ = std::max({kSmallestDelta, factor * delta_, schedule_.barrier * failed});
        factor = std::max(shrink, shrink * factor);
        continue;
      }
      if (path == PathFollower::kStopped) return stopped();
      if (iteration() >= options_.max_iterations) {
        return end(SolveStatus::kIterationLimit, fmt::format("iteration limit {} reached, {}",
                                                             options_.max_iterations, counted()));
      }
      factor = shrink;
      failed = delta_;
      ++failures;
      if (follower_.turning_t() > kUsefulTurn) {
        point = follower_.turning_point();
        point.find_bounds(problem_);
        point.impulse(problem_, anchor);
        // F is 1 - t of its former value: an error just above the tolerance may now meet it.
        ++judged_;
        if (judge(anchor.cwiseProduct(problem_.impulse_unit))) return true;
        delta_ = std::min(kLargestDelta, kRaiseAtTurn * delta_);
        if (failures > kTurns) return false;
      } else {
        point = std::move(before);
        point.find_bounds(problem_);
        delta_ *= kRaise;
        if (delta_ > kLargestDelta || failures >= kFailures) return false;
      }
    }
    return false;
  }

  /// Reports the cause of the stop, and the kinds of iterations in place of their number.
  bool stopped() {
    const bool by_caller = run_.cancelled();
    const std::string cause =
        by_caller ? "interrupted" : fmt::format("time limit {:.3g} s reached", options_.time_limit);
    return end(by_caller ? SolveStatus::kInterrupted : SolveStatus::kTimeLimit,
               fmt::format("{} after {}, best error {:.2e}", cause, counted(), run_.best_error()));
  }

  SolveRun& run_;
  const SolverOptions& options_;
  const Parameters& parameters_;
  LawProblem problem_;
  PathFollower follower_;
  PortableRandom random_;
  Schedule schedule_ = kSchedules[0];
  double delta_ = kNaN;
  Vector proximal_;  // of the path in progress
  double chain_error_ = kInfinity;
  Vector chain_best_;
  int start_steps_ = 0, judged_ = 0, chain_end_ = 0;
  bool ended_ = false;
};

}  // namespace

void solve_homotopy(SolveRun& run) { Homotopy{run}(); }

}  // namespace bipot
