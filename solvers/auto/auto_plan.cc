#include "solvers/auto/auto_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <vector>

#include "solvers/registry.h"

namespace bipot {
namespace {

constexpr int kFew = kFewContactsOfAuto;
// Up to it, too few to fill vectors: `anderson` takes 0.5 to 0.9 of the time of `assor`; twice as
// long from 70 contacts on (steps of 6 to 100 disks).
constexpr int kVeryFew = 20;
// Up to it, a dense Newton step costs less than a millisecond; beyond, up to four.
constexpr int kDense = 50;
// From it on, first order needs too many iterations.
constexpr double kLargeFriction = 10;
// Up to it, sweeps get more patience: they cost less than other solvers' set-up.
constexpr int kSmall = 400;
// Up to it, `anderson` needs 10 to 30 iterations on square lattices, where `assor` takes one to
// three times as long. Elsewhere `assor` takes less: 0.4 to 0.8 of the time on triangular lattices,
// and on pyramids `anderson` does not arrive.
constexpr int kSmallLattice = 600;
// Above it, proximal Newton (a factorisation of d contacts unknowns a step) and Anderson (whose
// sweeps need more iterations the deeper the packing) are left out of the first rounds.
constexpr int kLarge = 4000;
// Above it, a dozen factorisations of W cost more than apgd needs for a whole packing given by W
// alone: 0.2 s against 0.06 s at 2600 contacts, 0.27 s against 0.1 s at 5000.
constexpr int kCheapFactors = 1000;
// Above it, paths are so long that splitting, a factorisation for every 75 solves, comes before them.
// It arrives within 600 to 1200 iterations or not at all, and after 600 paths from its impulse are
// short: sixteen steps of a pour of 3000 disks (2800 to 4400 contacts) to 1e-4 took 10 s with 500 to
// 700 iterations of it, 13.7 s with 1500, 16 s and more after apgd; below, it is no gain.
constexpr int kMany = 2500;
// Below kRough, so many pivots from where the first sweeps ended if the error is kNearStart at most
// (paths from far away are long), up to kMany contacts. 0.86 of the time of 40 problems and steps
// of 400 to 1000 contacts from warm starts, 0.97 from cold ones; 0.8 of 48 of up to 400; 0.92 and
// 0.94 of 28 of 1000 to 2500, and 0.85 from cold ones where the sweeps are not given up before 60
// iterations. (Up to kSmall contacts at any tolerance and from farther away: no difference on 186
// steps of 6 to 400 disks, but pyramids, where all first order stands still, need three pivots.)
constexpr int kPivotsSoon = 500;
constexpr double kNearStart = 0.1, kNearStartOfSmall = 0.3;
// Normal diagonals of W that differ more than that: first order needs the root of it in iterations.
constexpr double kUnequal = 1e5;
// So near, at loose tolerances, Anderson is let go on for so many iterations: on the shipped and moving
// problems it arrives by then or needs hundreds.
constexpr int kCloseAnderson = 64;
// The same of `assor` up to kShortPaths contacts: seven of 384 cases at 3e-1 to 1e-3 take 0.5 to 0.9
// of the time, three of 1500 to 1800 contacts would take 1.5 to 2.
constexpr int kCloseSweeps = 120;
// Chains of starts of paths, taken where the error has fallen to this.
constexpr int kManyChains = 60000;
constexpr double kNearSolution = 1e-4;
// What apgd does before paths are tried, and pivots of these. A path from one start arrives within so
// many pivots for each contact, or mostly not at all: from a second start one in two of those that had
// not arrived does (ten steps of 3000 poured disks to 1e-4, fourteen of 1000 to 1e-8, thirteen ways to
// make a start), so that several short ones cost less than a long one. After the first path of small
// packings three pivots a contact: of 211 such paths on 47 hard steps of 1000 disks to 1e-8 45 arrive
// within four pivots a contact and 39 within three; 180 steps, others among them, take 0.97 of the pivots.
constexpr int kStartSteps = 2000, kPivots = 1500, kManyPivots = 10000, kPivotsOfStart = 4,
              kPivotsOfOther = 3, kPivotsOfLargeStart = 2, kPivotsOfLarge = 4,
              kPivotsOfShakesLarge = 6, kPivotsAfreshLarge = 10, kPivotsOfShakes = 12,
              kPivotsAfresh = 14;
// To fair tolerances splitting arrives within so many iterations, from one start or another: of ten
// usual steps of a pour of 10^4 disks (8000 to 13 000 contacts) to 1e-3 six or seven within 850 from
// any multiple of the caller's impulse below 1, three from itself. Where it stands just above the
// tolerance from any, as on three of seven steps that had taken 3e4 to 1.7e5 iterations, it arrives from
// a little off where it stands.
constexpr int kSoonSplitting = 600, kEnoughSplitting = 1500;
// From where it stands then a path is short, or mostly does not arrive: so many pivots, up to
// kShortUpTo contacts.
constexpr int kPivotsOfSplitting = 500, kShortUpTo = 12000;
// Contacts for each pivot of a path that follows some splitting on packings of kLarge to kLargeStep:
// of 42 such paths (21 and 7 steps of two pours, to 1e-4 and 1e-8) 30 arrived, 27 of them within that.
constexpr int kContactsOfPivot = 2;
// A step of a run, which starts from the one before, is taken for a moving one up to that size.
constexpr int kLargeStep = 8000;
// Paths from a worse start are long: free pyramids.
constexpr double kUsefulStart = 0.5;
// Tolerances from here on are loose.
constexpr double kRough = 3e-3;
// From here on `admm` is worth many more solves on large packings than below, and `assor` is the
// first stage from warm starts of any size. (Up to kMany it is so at any tolerance: 0.9 of the time
// of 33 packings from warm starts, most of 1000 to 2500 contacts; no difference below.)
constexpr double kFair = 5e-4;
// Up to it, paths from warm starts are short, and no more momentum is worth while before them.
constexpr int kShortPaths = 1000;
constexpr int kUnlimited = AutoStage::kUnlimited;

/// What makes a start of paths, and the multiple of the caller's impulse that it starts from.
struct OtherStart {
  const char* solver;
  int least, most;
  double multiple;
  bool local, disks;  // W alone is enough; only for disks
};
constexpr OtherStart momentum_from(double multiple) {
  return {"apgd", kStartSteps, kStartSteps, multiple, true, false};
}
constexpr OtherStart splitting_from(double multiple) {
  return {"admm", 600, 800, multiple, false, false};
}
constexpr OtherStart sweeps_from(double multiple) {
  return {"assor", 500, 500, multiple, false, true};
}
// A path from where one came nearest ends there again; from a little off it mostly goes elsewhere.
constexpr double kKicks[] = {0.98, 0.95, 0.9, 1.02, 0.8, 1.05};
constexpr int kKicksInARow = 3;
// In the order in which they come, so many before the factorisations of interior points, which packings
// at rest need. Up to kMany contacts momentum makes as good a start as splitting, at less cost.
constexpr std::size_t kSoon = 1;
constexpr OtherStart kOtherStarts[] = {
    momentum_from(0.5), splitting_from(0.5),  splitting_from(1),   momentum_from(0),
    sweeps_from(0.5),   splitting_from(0.25), momentum_from(0.75), splitting_from(0)};
constexpr OtherStart kOtherStartsOfMany[] = {
    splitting_from(0.5), splitting_from(0.25), splitting_from(0.75), splitting_from(0),
    momentum_from(0.75), sweeps_from(0.5),     splitting_from(2),    momentum_from(0.25)};
// Where the caller's start is 0.
constexpr OtherStart kOtherSolvers[] = {splitting_from(0), sweeps_from(0), momentum_from(0)};

bool is_hyperstatic(const ContactProblem& p) {
  // Without H the rank is not known: dense packings are the rule.
  return !p.has_velocities() || p.num_rows() > p.num_dofs();
}

/// Largest over smallest W_nn of a contact.
double spread_of_masses(const ContactProblem& p, const DelassusOperator& delassus) {
  const Vector diagonal = delassus.diagonal();
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double w = diagonal[static_cast<Eigen::Index>(c) * p.dim];
    if (w > 0) least = std::min(least, w);
    most = std::max(most, w);
  }
  return most > 0 ? most / least : 1;
}

/// Whether all normals are along or across one direction.
bool is_square(const DiskStructure& disks) {
  constexpr double kSame = 1e-6;
  if (disks.contacts.empty()) return false;
  const auto& first = disks.contacts.front().n;
  return std::all_of(disks.contacts.begin(), disks.contacts.end(), [&](const auto& c) {
    const double along = first[0] * c.n[0] + first[1] * c.n[1];
    const double across = first[0] * c.n[1] - first[1] * c.n[0];
    return std::abs(along) < kSame || std::abs(across) < kSame;
  });
}

/// Writes the plan down, stage by stage; `plan_auto` says what it is.
class Planner {
  using Start = AutoStage::Start;

 public:
  Planner(const ContactProblem& p, const DelassusOperator& delassus, bool warm)
      : problem_(p),
        delassus_(delassus),
        contacts_(p.num_contacts()),
        exact_(p.dim <= 2),
        friction_(p.dim == 2),
        local_(!p.has_velocities()),
        warm_(warm),
        unequal_(spread_of_masses(p, delassus) > kUnequal),
        disks_(delassus.disks().has_value()),
        square_(disks_ && contacts_ <= kSmallLattice && is_square(*delassus.disks())),
        sweeps_pay_(disks_ && friction_ && !square_ && contacts_ > kFew),
        largest_friction_(p.mu.size() > 0 ? p.mu.maxCoeff() : 0) {
    const double root = std::sqrt(static_cast<double>(contacts_));
    crossing_ = 50 + static_cast<int>((local_ ? 20 : 70) * root);
    ssor_crossing_ = 30 + static_cast<int>(15 * std::pow(contacts_, 0.4));
    stages_.reserve(20);
  }

  std::vector<AutoStage> operator()() {
    regular_packings();
    first_order();
    second_order();
    again();
    without_end();
    return std::move(stages_);
  }

 private:
  void add(const char* solver, int least, int most, Start start, const char* reason,
           std::map<std::string, std::string> parameters = {}) {
    if (!with_newton_ && solver == std::string_view("newton")) return;
    stages_.push_back({solver, least, most, start, 1, std::move(parameters), reason});
  }
  void follow(int most, std::map<std::string, std::string> parameters, const char* reason) {
    if (exact_) add("homotopy", most, most, Start::kBest, reason, std::move(parameters));
  }
  void first_paths(int pivots) {
    follow(pivots, {{"start_tol", "1"}}, "moving packings: an exact path from the best impulse");
    if (exact_) stages_.back().largest_error = kUsefulStart;
  }
  /// Paths from the start of the step, with other random numbers each.
  void afresh(std::initializer_list<const char*> seeds, int pivots_of_contact) {
    const int pivots = pivots_of_contact * contacts_;
    for (const char* seed : seeds) {
      add("homotopy", pivots, pivots, Start::kCaller, "again, from the start of the step",
          {{"seed", seed}});
      if (contacts_ > kLarge) stages_.back().tol_below = kFair;
    }
  }
  int pivots_of_start(int of_contact = kPivotsOfStart) const {
    if (!paths_first()) return std::max(kManyPivots, kPivotsOfLargeStart * contacts_);
    return std::max(kPivots, (splitting_first() ? kPivotsOfLargeStart : of_contact) * contacts_);
  }
  /// A stage of those that make starts and follow short paths from them.
  void add_start(const char* solver, int least, int most, Start start, double multiple,
                 const char* reason, std::map<std::string, std::string> parameters = {}) {
    add(solver, least, most, start, reason, std::move(parameters));
    stages_.back().of_start = multiple;
    stages_.back().largest_error = kUsefulStart;
    if (contacts_ > kLarge) stages_.back().tol_below = kFair;
  }
  void path_from_last(double multiple, const char* reason) {
    const int pivots = pivots_of_start(kPivotsOfOther);
    add_start("homotopy", pivots, pivots, Start::kLast, multiple, reason, {{"start_tol", "1"}});
  }
  /// A path from a little off the impulse where the last one came nearest.
  void kicked_path() {
    if (!exact_) return;
    path_from_last(kKicks[kick_++ % std::size(kKicks)], "again, a little off the last impulse");
  }
  /// First order, sweeps or splitting from a multiple of the caller's start, and short paths.
  void other_start(const OtherStart& other) {
    if (!exact_ || (local_ && !other.local) || (!disks_ && other.disks)) return;
    add_start(other.solver, other.least, other.most, Start::kCaller, other.multiple,
              "again, from the caller's start");
    path_from_last(1, "and a path from there");
    for (int k = 0; k < (splitting_first() ? 1 : kKicksInARow); ++k) kicked_path();
  }
  /// Some of them: those that come soon, or the others.
  void other_starts(bool soon) {
    std::span<const OtherStart> all(kOtherStarts);
    if (splitting_first()) all = kOtherStartsOfMany;
    if (!warm_) all = kOtherSolvers;
    for (const OtherStart& other : soon ? all.first(kSoon) : all.subspan(kSoon)) other_start(other);
  }
  /// To fair tolerances, splitting from multiples of the caller's start, each time with a short path
  /// and two kicks.
  void fair_splitting() {
    const auto splitting = [&](Start start, double multiple) {
      add("admm", kSoonSplitting, kEnoughSplitting, start,
          start == Start::kLast ? "again, a little off the last impulse"
                                : "large moving packings, by factors of W");
      stages_.back().of_start = multiple;
      stages_.back().least_tol = kFair;
    };
    const auto short_path = [&] {
      add("homotopy", kPivotsOfSplitting, kPivotsOfSplitting, Start::kLast,
          "a short path from where splitting stands", {{"start_tol", "1"}});
      stages_.back().least_tol = kFair;
      stages_.back().largest_error = kNearStart;
    };
    for (const double multiple : {0.1, 0.35, 0.6, 1.0}) {
      if (!warm_ && multiple < 1) continue;
      splitting(Start::kCaller, multiple);
      if (contacts_ <= kShortUpTo) short_path();
      splitting(Start::kLast, 0.95);
      splitting(Start::kLast, 0.9);
    }
  }
  void newton_on_delassus() {
    add("newton", 12, 40, Start::kOwn, "W given: a few factorisations cost little");
  }
  void sweeps() {
    if (contacts_ > kLarge) return;
    // In space their iterations take longer, and momentum after them arrives as often.
    const int most = local_ ? 1000 : exact_ ? 500 : 80;
    add("pgs", local_ || contacts_ <= kSmall ? std::min(200, most) : 64, most, Start::kOwn,
        "sweeps find solutions of sliding pyramids that others miss");
  }
  void many_starts(int steps, const char* seed, Start start = Start::kBest) {
    if (contacts_ > kFew) return;
    if (contacts_ > kDense) steps /= 10;
    add("multistart", steps, steps, start, "few contacts: dense Newton steps, many starts",
        {{"starts", "1000000"}, {"seed", seed}});
  }
  bool paths_first() const {
    return contacts_ <= kLarge || (warm_ && !local_ && contacts_ <= kLargeStep);
  }
  bool splitting_first() const { return exact_ && !local_ && contacts_ > kMany && paths_first(); }
  /// Above kLargeStep it is no gain: 0.9 of the time in the mean of 17 steps to 1e-4, 1.15 in the sum.
  bool path_from_splitting() const {
    return disks_ && friction_ && !paths_first() && contacts_ <= kLargeStep;
  }
  bool sweeps_are_cheap() const { return !local_ && contacts_ <= kSmall; }
  bool sweeps_first() const { return sweeps_are_cheap() && (!sweeps_pay_ || warm_); }

  /// Disks with friction: sweeps on the whole, before it is cut into islands, and from where they end
  /// a path in small ones.
  void disks_first() {
    const bool few = contacts_ <= kSmall;
    const auto sweeps_to = [&](int least, int most) {
      // More sweeps arrive where two stand still, and on few contacts cost more than they are worth.
      const char* const m = few ? "2" : "4";
      add("assor", least, most, Start::kOwn,
          "the quickest on what is easy, and roughly on most; soon seen not to be elsewhere",
          {{"sweeps", m}, {"most_sweeps", m}});
      if (contacts_ <= kShortPaths) stages_.back().close_iterations = kCloseSweeps;
      stages_.back().before_cutting = stages_.back().on_whole_only = true;
    };
    if (few) {
      sweeps_to(100, 250);
    } else if (warm_) {
      sweeps_to(30, 175);
      if (contacts_ > kMany) stages_.back().least_tol = kFair;
    } else {
      sweeps_to(60, 250);
    }
    if (contacts_ > kMany) return;
    soon_path();
  }
  /// A path from where the first stage ended, if that is near.
  void soon_path() {
    if (!exact_) return;
    first_paths(kPivotsSoon);
    const bool small = contacts_ <= kSmall;
    stages_.back().largest_error = small ? kNearStartOfSmall : kNearStart;
    if (!small) stages_.back().tol_below = kRough;
    stages_.back().before_cutting = small;
  }

  /// A start by splitting and a short path from it.
  void splitting_and_path() {
    add("admm", kSoonSplitting, kSoonSplitting + 200, Start::kCaller,
        "moving packings, by factors of W, and a start");
    stages_.back().tol_below = kFair;
    first_paths(contacts_ / kContactsOfPivot);
    stages_.back().tol_below = kFair;
    stages_.back().largest_error = kNearStart;
  }

  void regular_packings() {
    if (contacts_ <= kFew) {
      stages_.push_back(first_of_few(problem_, delassus_));
      // A dozen pivots, where more of the same would be a hundred iterations.
      soon_path();
      if (!exact_ && local_ && contacts_ > kVeryFew) {
        add("ipm", 12, 40, Start::kOwn, "few contacts, W given: a dozen factorisations");
      }
    }
    if (unequal_) {
      add("ipm", 40, 60, Start::kOwn, "very unequal masses: factorisations do not feel them");
    }
    if (contacts_ > kFew && contacts_ <= kLarge) {
      if (sweeps_pay_) disks_first();
      if (!sweeps_pay_ || (warm_ && contacts_ > kMany)) {
        // In space, given W: cutting out islands takes as long as 30 more.
        const int most = exact_ ? 100 : local_ ? 60 : 30;
        add("anderson", 16, most, Start::kOwn,
            "the quickest on small square lattices, and soon seen not to be elsewhere");
        stages_.back().close_iterations = kCloseAnderson;
        stages_.back().before_cutting = stages_.back().on_whole_only = true;
        if (sweeps_pay_) stages_.back().tol_below = kFair;
        // Above it, a dozen Newton steps take half as long as a path with W.
        if (local_ && contacts_ <= kCheapFactors) soon_path();
      }
    }
    if (local_ && contacts_ > kFew && contacts_ <= kCheapFactors) newton_on_delassus();
    if (sweeps_first()) {
      sweeps();
    } else if (sweeps_are_cheap()) {
      add("anderson", 50, 200, Start::kOwn, "few contacts: sweeps, accelerated");
      stages_.back().close_iterations = kCloseAnderson;
    }
  }

  void first_order() {
    if (exact_ && contacts_ > kLarge) {
      // Where sweeps take long, the factors of W are worth their price for two digits.
      if (disks_) {
        add("assor", ssor_crossing_ / 4,
            contacts_ <= kLargeStep ? 3 * ssor_crossing_ : ssor_crossing_ / 2, Start::kOwn,
            "packings at rest, roughly", {{"most_sweeps", "2"}});
      } else {
        add("apgd", 3000, 3000, Start::kOwn, "packings at rest, roughly");
      }
      stages_.back().least_tol = kRough;
      add("admm", 600, 2000, Start::kBest, "moving packings, roughly");
      stages_.back().least_tol = kRough;
    }
    if (disks_ && !paths_first()) {
      add("assor", ssor_crossing_, 3 * ssor_crossing_, Start::kOwn,
          "sweeps forth and back with momentum: O(N^1/4) iterations on packings at rest");
      stages_.back().before_cutting = stages_.back().on_whole_only = true;
    } else if (exact_ && !local_ && paths_first()) {
      // Where it does not go on to the end, it has made a start for paths by then.
      // (Above kMany `admm` makes a better one.)
      const int enough = std::min(crossing_, kStartSteps);
      const int soon = contacts_ > kMany ? enough / 4 : enough;
      const bool path_is_short = contacts_ <= (warm_ ? kShortPaths : kMany);
      const int most = path_is_short ? enough : enough + enough / 2;
      add("apgd", soon, contacts_ > kLarge ? 2 * crossing_ : most, Start::kOwn,
          "momentum: O(sqrt N) iterations, and a start");
    } else {
      // Longer still from a warm start; given that time, it halves the cost of a compaction at
      // rest.
      add("apgd", warm_ ? 2 * crossing_ : crossing_,
          std::max(warm_ ? 40000 : (local_ ? 4000 : 8000), crossing_ + crossing_ / 2), Start::kOwn,
          "momentum: O(sqrt N) iterations, whatever the packing");
    }
    if (local_ && contacts_ > kCheapFactors) newton_on_delassus();
  }

  void second_order() {
    if (paths_first()) {
      if (splitting_first()) {
        add("admm", 600, 800, Start::kCaller, "moving packings, by factors of W, and a start");
      }
      first_paths(pivots_of_start());
      if (exact_ && contacts_ > kLarge) stages_.back().tol_below = kFair;
      kicked_path();
      other_starts(true);
    }
    if (!sweeps_first()) sweeps();
    if (exact_ && contacts_ > kLarge) {
      fair_splitting();
      first_paths(kManyPivots);
      stages_.back().least_tol = kFair;
      follow(2 * kManyPivots, {{"start_tol", "1"}, {"seed", "2"}},
             "again, a little off the best impulse");
      stages_.back().of_start = kKicks[0];
      stages_.back().least_tol = kFair;
      add("admm", 6000, 14000, Start::kCaller, "large moving packings, with patience");
      stages_.back().least_tol = kFair;
    }
    if (path_from_splitting()) splitting_and_path();
    if (exact_ && contacts_ > (splitting_first() ? kMany : kLarge)) {
      add("admm", 1000, 3000, Start::kCaller, "large packings at rest, by factors of W");
      stages_.back().tol_below = kFair;
    }
    if (splitting_first()) {
      // Whether paths of a start arrive is chance: of thirteen starts of one step five did, within
      // 3 N pivots, the others not within 6 N.
      add("homotopy", kPivotsOfLarge * contacts_, kPivotsOfLarge * contacts_, Start::kLast,
          "moving packings: paths from another start", {{"start_tol", "1"}});
      stages_.back().tol_below = kFair;
    }
    // An interior point shows its progress late. On large problems too much would be thrown away;
    // and what resists first order from a warm start is a packing at rest, where it arrives in 25
    // to 50.
    const bool patient = warm_ || contacts_ > kLarge;
    if (exact_) {
      add("ipm", patient ? 40 : 12, patient ? 80 : 40, Start::kOwn,
          "accuracy on piles, a few dozen factorisations");
    } else {
      // Packings of spheres under a plate: its central path folds once or twice, and the error falls after that,
      // in 60 to 110 iterations, where all else needs 1e5 and more or stalls.
      add("ipm", 90, 150, Start::kOwn, "packings in space, about a hundred factorisations");
    }
    // There a path costs more than all factorisations that a packing at rest needs.
    if (!paths_first()) {
      // One from where the short one came nearest would end there again.
      if (path_from_splitting()) path_from_last(1, "moving packings: a path from there");
      first_paths(kManyPivots);
      if (path_from_splitting()) stages_.back().least_tol = kFair;
      // One from where it came nearest ends there again.
      for (int k = 0; exact_ && k < kKicksInARow; ++k) kicked_path();
    }
    if (contacts_ <= kLarge) {
      add("newton", local_ ? 500 : 12, local_ ? 1000 : 40, Start::kOwn,
          "quadratic where W is regular");
    }
  }

  void again() {
    many_starts(5000, "1");
    if (exact_ && contacts_ <= kFew && largest_friction_ > kLargeFriction) {
      add("lemke", 5000, 5000, Start::kOwn, "few contacts, large friction: pivots");
    }
    const bool sweeps_again = !local_ && contacts_ <= kCheapFactors;
    if (sweeps_again) add("pgs", 16000, 20000, Start::kOwn, "again, with patience: still cheap");
    // Where the paths from splitting stop, some are found from the start of the step: of seven such
    // steps of 4800 to 5200 contacts to 1e-4 by 19 of 28 runs within 22 000.
    if (splitting_first()) {
      // Of twelve steps on which all else had needed 8000 iterations and more, it solves two, each in
      // less than a second.
      add("assor", 6000, 6000, Start::kCaller, "again, by many sweeps", {{"sweeps", "8"}});
      other_starts(false);
      afresh({"2"}, kPivotsAfreshLarge);
    } else if (paths_first()) {
      other_starts(false);
    }
    if (exact_ && contacts_ > kFew) {
      // Whether paths of a start arrive is chance, and some of the next ones do.
      const int of_contact = !paths_first()      ? 0
                             : splitting_first() ? kPivotsOfShakesLarge
                                                 : kPivotsOfShakes;
      follow(std::max(kManyPivots, of_contact * contacts_),
             {{"start_tol", "1"}, {"shake", "first"}},
             "again, from starts around the best impulse");
    } else {
      follow(kManyPivots, {}, "again, from a better start");
    }
    if (exact_ && contacts_ > kFew && contacts_ <= kMany) {
      // The best impulse may stand where no path leads on, however it is shaken. Of 25 steps of 1700
      // contacts to 1e-8 that take paths more than 5000 pivots, one run of paths from the caller's
      // start solves seven in eight within that.
      afresh({"2", "3"}, kPivotsAfresh);
      // Of 40 steps of 1700 contacts that take paths thousands of pivots to 1e-8, 30 are solved in
      // 1000 iterations, half of all in 600: half the price of the chains below.
      add("ipm", 1000, 1000, Start::kCaller, "again, through the folds of moving packings");
    }
    if (splitting_first()) afresh({"3", "4"}, kPivotsAfreshLarge);
    if (exact_ && contacts_ > kFew) {
      // Paths that come near a solution and stop there do so again from there.
      add("homotopy", kManyChains, kManyChains, Start::kCaller,
          "again, from other starts: the best impulse so far is near a solution",
          {{"schedule", "cautious"}});
      stages_.back().largest_error = kNearSolution;
    }
    if (local_) {
      add("ipm", 60, 150, Start::kOwn, "again, with patience");
      add("apgd", 3000, 12000, Start::kOwn, "again, with patience");
      add("pgs", 16000, 20000, Start::kOwn, "again, with patience");
      return;
    }
    if (!exact_ && contacts_ <= kLarge) {
      // A plate pressed on spheres: of steps at which all else gives up some are met by splitting in 1e4 cheap
      // iterations, some by a path with a dozen folds.
      add("admm", 12000, 15000, Start::kCaller, "packings in space, by factors of W");
      add("ipm", 350, 400, Start::kCaller, "packings in space, through the folds of the path");
    }
    // Momentum is lost where it was given up: from the start once more, to a later end.
    add("apgd", 6000, std::max(12000, 8 * crossing_), Start::kCaller, "again, with patience");
    if (!sweeps_again && contacts_ <= kLarge) {
      add("pgs", 16000, 20000, Start::kOwn, "again, with patience");
    }
    add("ipm", 150, 300, Start::kCaller, "again, through the folds of sliding pyramids");
    if (contacts_ <= kLarge) add("newton", 100, 500, Start::kOwn, "again, with patience");
  }

  void without_end() {
    // The best impulse may stand where rounding is all that is left and too much of it.
    many_starts(20000, "2", Start::kCaller);
    add("apgd", kUnlimited, 100000, Start::kBest, "long runs of first order from the best impulse");
    if (contacts_ <= kLarge) {
      add("newton", kUnlimited, 3000, Start::kBest, "proximal Newton from the best impulse",
          {{"start_sweeps", "5000"}});
      add("admm", kUnlimited, 4000, Start::kBest, "splitting, where pivots go wrong");
    }
    follow(kUnlimited, {}, "paths from better and better starts");
    add("ipm", kUnlimited, 2000, Start::kBest, "central paths through their folds, in turns");
    many_starts(1000000, "3");
    add("pgs", kUnlimited, kUnlimited, Start::kBest,
        "last resort: sweeps, which approach where nothing converges");
  }

  const ContactProblem& problem_;
  const DelassusOperator& delassus_;
  const int contacts_;
  const bool exact_;  // in space the law is not piecewise linear
  const bool friction_, local_, warm_, unequal_, disks_;
  const bool square_;      // a lattice, and small
  const bool sweeps_pay_;  // assor's, before all else
  const double largest_friction_;
  const bool with_newton_ = find_solver("newton") != nullptr;  // needs PETSc
  // Information crosses a packing of N contacts in O(sqrt N) iterations of apgd; its error stands
  // for some crossings before it falls.
  int crossing_ = 0;
  std::size_t kick_ = 0;   // the next of kKicks
  int ssor_crossing_ = 0;  // the same of assor, O(N^1/4)
  std::vector<AutoStage> stages_;
};

}  // namespace

AutoStage first_of_few(const ContactProblem& p, const DelassusOperator& delassus) {
  const auto& disks = delassus.disks();
  const bool vectors = p.dim == 2 && p.num_contacts() > kVeryFew && disks && !is_square(*disks);
  AutoStage stage;
  if (vectors) {
    stage = {"assor", 50, 100};
    stage.parameters = {{"sweeps", "2"}, {"most_sweeps", "2"}};
    stage.reason = "few contacts: sweeps cost little";
  } else {
    stage = {"anderson", 32, 100};
    stage.reason = "few contacts: next to free";
  }
  stage.before_cutting = stage.on_whole_only = true;
  return stage;
}

std::vector<AutoStage> plan_auto(const ContactProblem& p, const DelassusOperator& delassus,
                                 bool warm) {
  return Planner(p, delassus, warm)();
}

std::string explain_auto(const ContactProblem& p, const SolverOptions& options) {
  std::string text = fmt::format(
      "auto: {} contacts, d = {}, {}, {} start, tolerance {:.0e}\n", p.num_contacts(), p.dim,
      !p.has_velocities() ? "local form"
      : is_hyperstatic(p) ? "hyperstatic (more rows than degrees of freedom)"
                          : "not hyperstatic by count",
      is_warm(options) ? "warm" : "cold", options.tol);
  int number = 0;
  for (const AutoStage& stage : plan_auto(p, DelassusOperator(p), is_warm(options))) {
    std::string budget =
        stage.max_iterations == kUnlimited
            ? std::string("(no limit)")
            : fmt::format("({} to {})", std::min(stage.min_iterations, stage.max_iterations),
                          stage.max_iterations);
    std::string condition;
    if (stage.of_start != 1) condition = fmt::format("; {:g} times it", stage.of_start);
    if (stage.least_tol > 0) condition += fmt::format("; tolerance >= {:.0e}", stage.least_tol);
    if (std::isfinite(stage.tol_below)) {
      condition += fmt::format("; tolerance < {:.0e}", stage.tol_below);
    }
    if (std::isfinite(stage.largest_error)) {
      condition += fmt::format("; best error <= {:.0e}", stage.largest_error);
    }
    text += fmt::format("  {:>2}. {:<8} {:<16} {}{}\n", ++number, stage.solver, budget,
                        stage.reason, condition);
  }
  return text;
}

}  // namespace bipot
