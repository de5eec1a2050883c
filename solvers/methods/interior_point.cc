#include "solvers/methods/interior_point.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/criterion/contact_error.h"
#include "solvers/interior/active_set.h"
#include "solvers/interior/equal_product_start.h"
#include "solvers/interior/interior_state.h"
#include "solvers/interior/proximal_interior_point.h"
#include "solvers/interior/proximal_newton.h"
#include "solvers/interior/taylor_path.h"
#include "solvers/solve_run.h"

namespace bipot {
namespace {

constexpr double kPolishBelow = 1e-5;   // guarded error from which Newton is tried
constexpr double kEndgameBelow = 1e-4;  // and from which the proximal interior point is, on a path
constexpr double kEndgameAgain = 0.1;   // decrease of the error before the endgame is tried again
constexpr int kActiveSetSteps = 3, kPolishSteps = 15;
constexpr int kDirectPatience = 12;
constexpr int kDirectTrial = 10;  // iterations after which a start counts as too small or too large
constexpr double kDirectOther = 30;   // factor by which such a start changes
constexpr double kDirectGrowth = 10;  // of the error over the best one: the attempt diverges
// Factor of the energy of the direct attempts of each round.
constexpr double kDirectScales[] = {1, 10, 0.1, 100};

constexpr double kColdFactor = 10;      // of the cold path's start
constexpr double kNetworkError = 1e-2;  // of an impulse whose force network is worth keeping
constexpr int kNetworkIterations = 2000;
constexpr int kFirstTurn = 30;  // series of a path in round 0, doubled each round
// First round of the paths near a network whose error is above kNetworkError. In space the cold
// path mostly arrives before.
constexpr int kBadNetworkRound = 1, kBadNetworkRoundInSpace = 3;
// A path whose t decreased by the factor over this number of series continues.
constexpr int kProgressSeries = 10;
constexpr double kProgressFall = 0.3;
constexpr double kSmallestT = 1e-18;  // of a path; products are then below round-off

/// A path that alternates with others.
template <ContactRows D>
struct Contender {
  std::string name;
  bool cold = true;
  /// Of the start: factor of the cold one, of the network's normal energy for others.
  double products = 0;
  int first_round = 0;
  std::unique_ptr<TaylorPath<D>> path = nullptr;  ///< from its first turn on
  double last_try = kInfinity;                    ///< error of the last endgame
  std::vector<double> t = {};                     ///< after each series

  bool over() const { return path && (path->ended() || path->t() < kSmallestT); }
  bool progresses() const {
    return t.size() > kProgressSeries && path->descending() &&
           t.back() < kProgressFall * t[t.size() - 1 - kProgressSeries];
  }
};

template <ContactRows D>
class Driver {
 public:
  Driver(SolveRun& run, const Parameters& parameters)
      : p_(run.problem()),
        run_(run),
        system_(p_, run.delassus(), form(parameters), run.factor(), run.factor_stop()),
        stages_(run),
        starts_{system_},
        interior_{system_, stages_},
        active_set_(system_),
        direct_(parameters.choice("direct") == "on"),
        paths_(parameters.choice("paths") == "on"),
        polish_(parameters.choice("polish") == "on"),
        rounds_(parameters.integer("rounds")),
        scale_(parameters.number("start_scale")),
        energy_(run.out_of_time() ? 0 : starts_.spring_energy()) {
    path_order_ = parameters.integer("order");
    run.end_setup();
  }

  void operator()() {
    const Vector s0 = run_.start();
    if (run_.stop(0, s0)) return;
    if (polish_from(s0) == StageEnd::kStop) return;
    for (int round = 0; round < rounds_; ++round) {
      if (direct_ && attempt_directly(round) == StageEnd::kStop) return;
      if (!paths_) continue;
      if (round == 0) enter_paths();
      for (Contender<D>& c : contenders_) {
        if (c.first_round > round || c.over()) continue;
        if (take_turn(c, kFirstTurn << std::min(round, 16)) == StageEnd::kStop) return;
      }
    }
    run_.end(SolveStatus::kStalled,
             fmt::format("no attempt and no path arrived in {} rounds and {} iterations, best "
                         "error {:.2e}",
                         rounds_, stages_.iteration, run_.best_error()));
  }

  /// Description of the stages for the message.
  std::string story() const {
    int paths = 0, series = 0, folds = 0;
    std::string each;
    for (const Contender<D>& c : contenders_) {
      if (!c.path) continue;
      ++paths;
      series += c.path->series();
      folds += c.path->folds();
      each += fmt::format("{}{} {}", each.empty() ? "" : ", ", c.name, c.path->series());
    }
    if (paths == 0) return fmt::format("{} factorisations, no path", stages_.iteration);
    return fmt::format("{} factorisations, {} series on {} paths ({}), {} folds", stages_.iteration,
                       series, paths, each, folds);
  }

 private:
  static ShiftedDelassus::Form form(const Parameters& parameters) {
    const std::string choice = parameters.choice("linear_system");
    if (choice == "body") return ShiftedDelassus::Form::kBody;
    if (choice == "contact") return ShiftedDelassus::Form::kContact;
    return ShiftedDelassus::Form::kAuto;
  }

  /// Newton from an accurate impulse; no effect on a bad one.
  StageEnd polish_from(const Vector& s) {
    if (!polish_ || !(run_.last_error() < kPolishBelow)) return StageEnd::kLimit;
    active_set_.start(s);
    if (active_set_(kActiveSetSteps, stages_) == StageEnd::kStop) return StageEnd::kStop;
    return newton(s);
  }
  StageEnd newton(const Vector& s) {
    return proximal_newton(p_, system_.delassus(), system_.shifted(), system_.mobility(), s,
                           stages_, kPolishSteps);
  }
  StageEnd finish_status(const InteriorState<D>& z) {
    if (!polish_) return StageEnd::kLimit;
    active_set_.start(z);
    return active_set_(kActiveSetSteps, stages_);
  }

  /// The proximal interior point from an equal-product start; impulses scale with the energy's
  /// factor, as in EqualProductStart::cold(). A start that is too small (the forces of a large
  /// packing grow from contact to contact) or too large is soon detected, and so is a case in which
  /// the other one is no better.
  StageEnd attempt_directly(int round) {
    const std::size_t turn = to_size(round) % std::size(kDirectScales);
    const double factor = scale_ * kDirectScales[turn];
    ProximalInteriorPointOptions options{.patience = kDirectPatience,
                                         .largest_growth = kDirectGrowth,
                                         .far_iterations = kDirectTrial};
    InteriorState<D> z = starts_.cold(energy_, factor), best = z;
    StageEnd end = interior_(z, options, best);
    if (end == StageEnd::kSmallStart || end == StageEnd::kLargeStart) {
      const double other = end == StageEnd::kSmallStart ? kDirectOther : 1 / kDirectOther;
      z = starts_.cold(energy_, other * factor);
      best = z;
      end = interior_(z, options, best);
    }
    if (end == StageEnd::kStop) return StageEnd::kStop;
    if (!(run_.best_error() < kPolishBelow)) return StageEnd::kLimit;
    if (finish_status(best) == StageEnd::kStop) return StageEnd::kStop;
    return polish_ ? newton(best.s) : StageEnd::kLimit;
  }

  /// The paths, in their order: near the force network of a rough impulse, and the cold one. Paths
  /// of a bad rough impulse wait.
  void enter_paths() {
    Vector network = run_.best_impulse();
    double error = run_.best_error();
    if (!(error <= kNetworkError)) {
      network = run_.nested("apgd", kNetworkError, kNetworkIterations, run_.options().s0).s;
      error = contact_error(p_, network).guarded();
    }
    const bool good = error <= kNetworkError;
    const double energy = starts_.normal_energy(network);
    const auto enter_warm = [&](const char* name, double products, int first_round) {
      if (!(energy > 0)) return;
      contenders_.push_back(
          {.name = name, .cold = false, .products = products * energy, .first_round = first_round});
    };
    const auto enter_cold = [&] {
      contenders_.push_back({.name = "cold", .products = kColdFactor * scale_});
    };
    network_ = std::move(network);
    if (!good) enter_cold();
    const int late = p_.plain_dim() == 3 ? kBadNetworkRoundInSpace : kBadNetworkRound;
    const int first_round = good ? 0 : late;
    enter_warm("warm 1e-2", 1e-2, first_round);
    enter_warm("warm 1e-3", 1e-3, first_round);
    if (good) enter_cold();
    enter_warm("warm 1e-1", 1e-1, first_round + 1);
  }

  StageEnd take_turn(Contender<D>& c, int budget) {
    if (!c.path) {
      c.path = std::make_unique<TaylorPath<D>>(
          system_, c.cold ? starts_.cold(energy_, c.products) : starts_.warm(network_, c.products),
          path_order_);
    }
    const TaylorPath<D>& path = *c.path;
    for (int k = 0; k < budget || c.progresses(); ++k) {
      const PathStep step = c.path->advance();
      if (stages_.next(path.state().s, path.reach())) return StageEnd::kStop;
      if (step == PathStep::kRetracted) continue;
      if (step == PathStep::kEnded || c.over()) break;
      c.t.push_back(path.t());
      const double error = run_.last_error();
      if (path.descending() && error < std::min(kEndgameBelow, kEndgameAgain * c.last_try)) {
        c.last_try = error;
        if (endgame(path.state(), error) == StageEnd::kStop) return StageEnd::kStop;
      }
    }
    return StageEnd::kLimit;
  }

  /// From a path's state near the solution to the solution.
  StageEnd endgame(const InteriorState<D>& z, double error) {
    const bool near = error < kPolishBelow;
    if (near && finish_status(z) == StageEnd::kStop) return StageEnd::kStop;
    ProximalInteriorPointOptions options{.max_iterations = near ? 15 : 25, .patience = 12};
    InteriorState<D> end = z, best = z;
    if (interior_(end, options, best) == StageEnd::kStop) return StageEnd::kStop;
    if (!(run_.best_error() < kPolishBelow)) return StageEnd::kLimit;
    return finish_status(best);
  }

  const ContactProblem& p_;
  SolveRun& run_;
  InteriorSystem<D> system_;
  InteriorRun stages_;
  EqualProductStart<D> starts_;
  ProximalInteriorPoint<D> interior_;
  ActiveSet<D> active_set_;
  bool direct_, paths_, polish_;
  int rounds_;
  double scale_, energy_;  // the energy is that of the default start
  int path_order_ = 0;
  Vector network_;  // force network of the warm paths
  std::vector<Contender<D>> contenders_;
};

}  // namespace

void solve_interior_point(SolveRun& run) {
  run.judge_every_iteration();
  const std::string story = dispatch_rows(run.problem(), [&](auto d) {
    Driver<d()> driver(run, run.parameters());
    driver();
    return driver.story();
  });
  run.remark("; " + story);
}

}  // namespace bipot
