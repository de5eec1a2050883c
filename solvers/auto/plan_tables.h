#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "core/base/types.h"
#include "solvers/auto/auto_plan.h"

/// The plan of `auto` as tables of rows, one for each class of problem; the rows of a class are
/// tried from top to bottom. auto_plan.h says how a stage ends. The values are measured on
/// data/problems and on steps of pours, collapses, impacts and tilts. N: number of contacts.
namespace bipot::plan {

/// max(least, factor N^power), rounded down. A single number does not depend on N.
struct Count {
  double factor = 0, power = 0;
  int least = 0;
  constexpr Count(double number) : factor(number) {}
  constexpr Count(double a, double b, int c = 0) : factor(a), power(b), least(c) {}
  int of(int contacts) const {
    const double count = std::max<double>(least, factor * std::pow(contacts, power));
    return static_cast<int>(std::min<double>(count, AutoStage::kUnlimited));
  }
};
constexpr Count root(double factor, int least = 0) { return {factor, 0.5, least}; }
constexpr Count each(double factor, int least = 0) { return {factor, 1, least}; }
/// Symmetric sweeps with momentum cross a packing in about 15.5 N^0.4 iterations.
constexpr Count crossings(double times) { return {15.5 * times, 0.4}; }

/// Iterations of a stage: at least, at most, and within a decade of a fair tolerance. A single
/// number: it is never given up.
struct Budget {
  Count least, most;
  int near = AutoStage::kUnlimited;
  constexpr Budget(Count all) : least(all), most(all) {}
  constexpr Budget(double all) : Budget(Count(all)) {}
  constexpr Budget(Count a, Count b, int c = AutoStage::kUnlimited) : least(a), most(b), near(c) {}
};

struct Origin {
  AutoStage::Start start;
  double multiple = 1;
};
constexpr Origin own() { return {AutoStage::Start::kOwn}; }
constexpr Origin best(double multiple = 1) { return {AutoStage::Start::kBest, multiple}; }
constexpr Origin caller(double multiple = 1) { return {AutoStage::Start::kCaller, multiple}; }
constexpr Origin last(double multiple = 1) { return {AutoStage::Start::kLast, multiple}; }

/// A row applies for `above` < N <= `up_to`, a best error of at most `error`, and tolerances from
/// `tol_from` and below `tol_below`.
struct When {
  int above = 0, up_to = AutoStage::kUnlimited;
  double error = kInfinity, tol_from = 0, tol_below = kInfinity;
};

/// Properties that a row requires of the problem, and properties of its stage.
enum Mark : unsigned {
  kAlways = 0,
  kWarm = 1,          ///< the caller's start is not 0
  kCold = 2,          ///< it is 0
  kDisks = 4,         ///< disks in 2D
  kNoDisks = 8,       ///< anything else
  kVectors = 16,      ///< disks with friction that fill vectors, and no small square lattice
  kNoVectors = 32,    ///< anything else
  kUnequal = 64,      ///< very unequal masses
  kBodies = 128,      ///< the bodies are given
  kWAlone = 256,      ///< W alone is given
  kInPlane = 512,     ///< d <= 2
  kInSpace = 1024,    ///< d = 3
  kOfProblem = 2047,  ///< all of the above
  kWhole = 2048,      ///< AutoStage::before_cutting
  kWholeOnly = kWhole | 4096,         ///< and AutoStage::on_whole_only
  kThenPaths = kInPlane | 8192,       ///< kAfterStart comes next
  kThenSplitting = kInPlane | 16384,  ///< kAfterSplitting comes next
};

struct PlanRow {
  std::string_view solver, parameters;
  Origin start;
  Budget budget;
  When when;
  unsigned marks;
  std::string_view reason;
};

/// Limits that classes and rows share.
///
/// name           value   unit       reason
/// kFair          5e-4    tolerance  splitting reaches it on large packings, paths reach less
/// kRough         3e-3    tolerance  sweeps or splitting reach it early
/// kUseful        0.5     error      a path from a worse impulse is long
/// kNear          0.1     error      a path from a better impulse is short
/// kUnequalRatio  1e5     W_nn/W_nn  first order needs the root of it in iterations
/// kScalar        20      contacts   too few disks to fill vectors
/// kSmallLattice  600     contacts   accelerated sweeps solve square lattices up to it quickly
/// kFew           100     contacts   dense linear algebra is cheap
/// kMany          2500    contacts   factors of W are worth their price before paths
/// kLarge         4000    contacts   paths are too long for the first rounds
/// kLargeWarm     8000    contacts   the same from a warm start
constexpr double kFair = 5e-4, kRough = 3e-3, kUseful = 0.5, kNear = 0.1, kUnequalRatio = 1e5;
constexpr int kScalar = 20, kSmallLattice = 600, kFew = 100, kMany = 2500, kLarge = 4000,
              kLargeWarm = 8000;
constexpr int kAny = AutoStage::kUnlimited;
constexpr When kIfUseful{0, kAny, kUseful}, kIfRough{0, kAny, kInfinity, kRough},
    kIfTight{0, kAny, kInfinity, 0, kFair};

// Reasons.
constexpr std::string_view
    kWhyAccelerated = "accelerated sweeps show early whether they will arrive",
    kWhyCheap = "few contacts: sweeps cost less than the set-up of other solvers",
    kWhyChains = "a solution is near: many short paths from the given start",
    kWhyDisks = "disks: vectorised symmetric sweeps solve most packings quickly",
    kWhyEight = "eight symmetric sweeps an iteration arrive where fewer stand still",
    kWhyElsewhere = "another start ends elsewhere, and a path from there may arrive",
    kWhyFactors = "a few dozen factorisations solve packings at rest",
    kWhyFolds = "the central path is followed through its folds, where the error falls late",
    kWhyGiven = "W is given: a few factorisations of it cost little",
    kWhyLastResort = "sweeps approach a solution where nothing converges",
    kWhyMasses = "very unequal masses do not slow down an interior point",
    kWhyMomentum = "momentum needs O(sqrt N) iterations on packings at rest",
    kWhyMomentumStart = "momentum is enough at loose tolerances, and else a start for a path",
    kWhyNear = "a slightly different impulse mostly leads elsewhere",
    kWhyNewton = "Newton's method converges quadratically where W is regular",
    kWhyPath = "moving packings: an exact path through opening, stick and slip",
    kWhyLarger = "the same with a larger budget",
    kWhyRandom = "paths with other random numbers arrive by chance",
    kWhyShortPath = "a short exact path from an impulse that is near",
    kWhySplitting = "moving packings: operator splitting by factors of W",
    kWhyStarts = "few contacts: dense Newton steps from many starts",
    kWhySweeps = "sweeps find solutions of sliding pyramids that others miss",
    kWhySymmetric = "symmetric sweeps with momentum need O(N^0.4) iterations on packings at rest";

// Parameters: number of symmetric sweeps in an iteration, and paths that begin at the given
// impulse.
constexpr std::string_view kTwo = "sweeps=2 most_sweeps=2", kFour = "sweeps=4 most_sweeps=4",
                           kAtMostTwo = "most_sweeps=2", kHere = "start_tol=1";

// clang-format off
// solver, parameters, start, {least, most, near}, {above, up to, error, tol from, tol below},
// marks, reason

/// Before all others.
constexpr PlanRow kFirst[] = {
  {"assor", kTwo, own(), {50, 100}, {20, kFew}, kVectors | kWholeOnly, kWhyDisks},
  {"anderson", "", own(), {32, 100}, {0, kFew}, kNoVectors | kWholeOnly, kWhyCheap},
  {"ipm", "", own(), {12, 40}, {20, kFew}, kWAlone | kInSpace, kWhyGiven},
  {"ipm", "", own(), {40, 60}, {}, kUnequal, kWhyMasses},
};

/// 2D, up to kMany contacts.
constexpr PlanRow kSmall[] = {
  {"assor", kTwo, own(), {100, 250, 120}, {kFew, 400}, kVectors | kWholeOnly, kWhyDisks},
  {"assor", kFour, own(), {30, 175, 120}, {400, 1000}, kVectors | kWarm | kWholeOnly, kWhyDisks},
  {"assor", kFour, own(), {30, 175}, {1000, kMany}, kVectors | kWarm | kWholeOnly, kWhyDisks},
  {"assor", kFour, own(), {60, 250, 120}, {400, 1000}, kVectors | kCold | kWholeOnly, kWhyDisks},
  {"assor", kFour, own(), {60, 250}, {1000, kMany}, kVectors | kCold | kWholeOnly, kWhyDisks},
  {"anderson", "", own(), {16, 100, 64}, {kFew, kMany}, kNoVectors | kWholeOnly, kWhyAccelerated},
  {"homotopy", kHere, best(), 500, {0, 400, 0.3}, kWhole, kWhyShortPath},
  {"homotopy", kHere, best(), 500, {400, kMany, kNear, 0, kRough}, kVectors, kWhyShortPath},
  {"pgs", "", own(), {200, 500}, {0, 400}, kAlways, kWhyCheap},
  {"apgd", "", own(), root(72), {0, 1000}, kAlways, kWhyMomentumStart},
  {"apgd", "", own(), 2000, {1000, kMany}, kCold, kWhyMomentumStart},
  {"apgd", "", own(), {2000, 3000}, {1000, kMany}, kWarm, kWhyMomentumStart},
  {"homotopy", kHere, best(), each(4, 1500), kIfUseful, kAlways, kWhyPath},
  {"homotopy", kHere, last(0.98), each(3, 1500), kIfUseful, kAlways, kWhyNear},
  {"apgd", "", caller(0.5), 2000, kIfUseful, kWarm | kThenPaths, kWhyElsewhere},
  {"admm", "", caller(0), {600, 800}, kIfUseful, kCold | kThenPaths, kWhyElsewhere},
  {"pgs", "", own(), {64, 500}, {400, kMany}, kAlways, kWhySweeps},
  {"ipm", "", own(), {40, 80}, {}, kWarm, kWhyFactors},
  {"ipm", "", own(), {12, 40}, {}, kCold, kWhyFactors},
  {"newton", "", own(), {12, 40}, {}, kAlways, kWhyNewton},
};

/// 2D, up to kLarge contacts; from a warm start below kFair up to kLargeWarm.
constexpr PlanRow kMedium[] = {
  {"assor", kFour, own(), {30, 175}, {0, kLarge}, kVectors | kWarm | kWholeOnly, kWhyDisks},
  {"assor", kFour, own(), {60, 250}, {0, kLarge}, kVectors | kCold | kWholeOnly, kWhyDisks},
  {"anderson", "", own(), {16, 100, 64}, {0, kLarge}, kNoVectors | kWholeOnly, kWhyAccelerated},
  {"apgd", "", own(), {500, 3000}, {0, kLarge}, kAlways, kWhyMomentumStart},
  {"apgd", "", own(), {500, root(140)}, {kLarge}, kAlways, kWhyMomentumStart},
  {"admm", "", caller(), {600, 800}, {}, kAlways, kWhySplitting},
  {"homotopy", kHere, best(), each(2), kIfUseful, kAlways, kWhyPath},
  {"homotopy", kHere, last(0.98), each(2), kIfUseful, kAlways, kWhyNear},
  {"admm", "", caller(0.5), {600, 800}, kIfUseful, kWarm | kThenPaths, kWhyElsewhere},
  {"pgs", "", own(), {64, 500}, {0, kLarge}, kAlways, kWhySweeps},
  {"admm", "", caller(), {1000, 3000}, kIfTight, kAlways, kWhyLarger},
  {"homotopy", kHere, last(), each(4), kIfTight, kAlways, kWhyPath},
  {"ipm", "", own(), {40, 80}, {}, kWarm, kWhyFactors},
  {"ipm", "", own(), {12, 40}, {}, kCold, kWhyFactors},
  {"newton", "", own(), {12, 40}, {0, kLarge}, kAlways, kWhyNewton},
};

/// 2D, larger, tolerance kFair or more.
constexpr PlanRow kLargeFair[] = {
  {"assor", kAtMostTwo, own(), {crossings(0.25), crossings(3)}, {0, 8000, kInfinity, kRough},
   kDisks, kWhySymmetric},
  {"assor", kAtMostTwo, own(), {crossings(0.25), crossings(0.5)}, {8000, kAny, kInfinity, kRough},
   kDisks, kWhySymmetric},
  {"apgd", "", own(), 3000, kIfRough, kNoDisks, kWhyMomentum},
  {"admm", "", best(), {600, 2000}, kIfRough, kAlways, kWhySplitting},
  {"apgd", "", own(), {500, root(140)}, {0, kLargeWarm}, kWarm, kWhyMomentum},
  {"assor", "", own(), {crossings(1), crossings(3)}, {0, kLargeWarm},
   kDisks | kCold | kWholeOnly, kWhySymmetric},
  {"assor", "", own(), {crossings(1), crossings(3)}, {kLargeWarm},
   kDisks | kWholeOnly, kWhySymmetric},
  {"apgd", "", own(), {root(70), root(105)}, {}, kNoDisks, kWhyMomentum},
  {"admm", "", caller(0.1), {600, 1500}, {}, kWarm | kThenSplitting, kWhySplitting},
  {"admm", "", caller(0.35), {600, 1500}, {}, kWarm | kThenSplitting, kWhySplitting},
  {"admm", "", caller(0.6), {600, 1500}, {}, kWarm | kThenSplitting, kWhySplitting},
  {"admm", "", caller(), {600, 1500}, {}, kThenSplitting, kWhySplitting},
  {"homotopy", kHere, best(), 10000, kIfUseful, kAlways, kWhyPath},
  {"homotopy", "start_tol=1 seed=2", best(0.98), 20000, {}, kAlways, kWhyNear},
  {"admm", "", caller(), {6000, 14000}, {}, kAlways, kWhyLarger},
  {"ipm", "", own(), {40, 80}, {}, kAlways, kWhyFactors},
};

/// 2D, larger, tolerance below kFair.
constexpr PlanRow kLargeTight[] = {
  {"assor", "", own(), {crossings(1), crossings(3)}, {}, kDisks | kWholeOnly, kWhySymmetric},
  {"apgd", "", own(), {root(70), root(105)}, {}, kNoDisks, kWhyMomentum},
  {"admm", "", caller(), {600, 800}, {0, 8000}, kDisks, kWhySplitting},
  {"homotopy", kHere, best(), each(0.5), {0, 8000, kNear}, kDisks, kWhyShortPath},
  {"admm", "", caller(), {1000, 3000}, {}, kAlways, kWhyLarger},
  {"ipm", "", own(), {40, 80}, {}, kAlways, kWhyFactors},
  {"homotopy", kHere, last(), each(2, 10000), {0, 8000, kUseful}, kAlways, kWhyPath},
  {"homotopy", kHere, best(), 10000, {8000, kAny, kUseful}, kAlways, kWhyPath},
  {"homotopy", kHere, last(0.98), each(2, 10000), kIfUseful, kAlways, kWhyNear},
  {"homotopy", kHere, last(0.95), each(2, 10000), kIfUseful, kAlways, kWhyNear},
  {"homotopy", kHere, last(0.9), each(2, 10000), kIfUseful, kAlways, kWhyNear},
};

/// 2D, W alone.
constexpr PlanRow kPlaneOfW[] = {
  {"anderson", "", own(), {16, 100, 64}, {kFew, kLarge}, kWholeOnly, kWhyAccelerated},
  {"homotopy", kHere, best(), 500, {0, 400, 0.3}, kWhole, kWhyShortPath},
  {"homotopy", kHere, best(), 500, {400, 1000, kNear, 0, kRough}, kAlways, kWhyShortPath},
  {"newton", "", own(), {12, 40}, {kFew, 1000}, kAlways, kWhyGiven},
  {"apgd", "", own(), {root(20), root(30, 4000)}, {}, kCold, kWhyMomentum},
  {"apgd", "", own(), {root(40), 40000}, {}, kWarm, kWhyMomentum},
  {"newton", "", own(), {12, 40}, {1000}, kAlways, kWhyGiven},
  {"homotopy", kHere, best(), each(4, 1500), {0, kLarge, kUseful}, kAlways, kWhyPath},
  {"homotopy", kHere, last(0.98), each(3, 1500), {0, kLarge, kUseful}, kAlways, kWhyNear},
  {"apgd", "", caller(0.5), 2000, {0, kLarge, kUseful}, kWarm | kThenPaths, kWhyElsewhere},
  {"pgs", "", own(), {200, 1000}, {0, kLarge}, kAlways, kWhySweeps},
  {"admm", "", caller(), {1000, 3000}, {kLarge}, kAlways, kWhySplitting},
  {"ipm", "", own(), {40, 80}, {}, kWarm, kWhyFactors},
  {"ipm", "", own(), {12, 40}, {}, kCold, kWhyFactors},
  {"newton", "", own(), {500, 1000}, {0, kLarge}, kAlways, kWhyNewton},
};

/// 3D.
constexpr PlanRow kSpace[] = {
  {"anderson", "", own(), {16, 30, 64}, {kFew, kLarge}, kBodies | kWholeOnly, kWhyAccelerated},
  {"anderson", "", own(), {16, 60, 64}, {kFew, kLarge}, kWAlone | kWholeOnly, kWhyAccelerated},
  {"newton", "", own(), {12, 40}, {kFew, 1000}, kWAlone, kWhyGiven},
  {"pgs", "", own(), 80, {0, 400}, kBodies, kWhyCheap},
  {"apgd", "", own(), {root(70), root(105, 8000)}, {}, kBodies | kCold, kWhyMomentum},
  {"apgd", "", own(), {root(140), 40000}, {}, kBodies | kWarm, kWhyMomentum},
  {"apgd", "", own(), {root(20), root(30, 4000)}, {}, kWAlone | kCold, kWhyMomentum},
  {"apgd", "", own(), {root(40), 40000}, {}, kWAlone | kWarm, kWhyMomentum},
  {"newton", "", own(), {12, 40}, {1000}, kWAlone, kWhyGiven},
  {"pgs", "", own(), {64, 80}, {400, kLarge}, kBodies, kWhySweeps},
  {"pgs", "", own(), {200, 1000}, {0, kLarge}, kWAlone, kWhySweeps},
  {"ipm", "", own(), {90, 150}, {}, kAlways, kWhyFolds},
  {"newton", "", own(), {12, 40}, {0, kLarge}, kBodies, kWhyNewton},
  {"newton", "", own(), {500, 1000}, {0, kLarge}, kWAlone, kWhyNewton},
};

/// After the rows of all classes: larger budgets.
constexpr PlanRow kLargerBudgets[] = {
  {"multistart", "starts=1000000", best(), 5000, {0, 50}, kAlways, kWhyStarts},
  {"multistart", "starts=1000000", best(), 500, {50, kFew}, kAlways, kWhyStarts},
  {"pgs", "", own(), {16000, 20000}, {0, 1000}, kAlways, kWhyLarger},
  {"admm", "", caller(), {12000, 15000}, {0, kLarge}, kInSpace, kWhyLarger},
  {"ipm", "", caller(), {350, 400}, {0, kLarge}, kInSpace, kWhyFolds},
  {"assor", "sweeps=8", caller(), 6000, {kMany, kLargeWarm}, kDisks, kWhyEight},
  {"admm", "", caller(0.25), {600, 800}, {0, kLargeWarm, kUseful},
   kWarm | kThenPaths, kWhyElsewhere},
  {"admm", "", caller(0.75), {600, 800}, {0, kLargeWarm, kUseful},
   kWarm | kThenPaths, kWhyElsewhere},
  {"apgd", "", caller(0), 2000, {0, kLargeWarm, kUseful}, kThenPaths, kWhyElsewhere},
  {"assor", "", caller(0.5), 500, {0, kLargeWarm, kUseful}, kDisks | kThenPaths, kWhyElsewhere},
  {"apgd", "", caller(0.75), 2000, {0, kLargeWarm, kUseful}, kWarm | kThenPaths, kWhyElsewhere},
  {"admm", "", caller(0), {600, 800}, {0, kLargeWarm, kUseful}, kWarm | kThenPaths, kWhyElsewhere},
  {"homotopy", "start_tol=1 shake=first", best(), each(12, 10000), {0, kMany}, kAlways, kWhyRandom},
  {"homotopy", "start_tol=1 shake=first", best(), 20000, {kMany}, kAlways, kWhyRandom},
  {"homotopy", "seed=2", caller(), each(14), {kFew, kLargeWarm}, kAlways, kWhyRandom},
  {"homotopy", "seed=3", caller(), each(14), {kFew, kLargeWarm}, kAlways, kWhyRandom},
  {"ipm", "", caller(), 1000, {kFew, kMany}, kInPlane, kWhyFolds},
  {"homotopy", "schedule=cautious", caller(), 60000, {kFew, kAny, 1e-4}, kAlways, kWhyChains},
  {"apgd", "", caller(), {6000, root(560, 12000)}, {}, kAlways, kWhyLarger},
  {"pgs", "", own(), {16000, 20000}, {1000, kLarge}, kAlways, kWhyLarger},
  {"ipm", "", caller(), {150, 300}, {}, kAlways, kWhyFolds},
  {"newton", "", own(), {100, 500}, {0, kLarge}, kAlways, kWhyLarger},
};

/// At the end.
constexpr PlanRow kLongRuns[] = {
  {"multistart", "starts=1000000 seed=2", caller(), 20000, {0, 50}, kAlways, kWhyStarts},
  {"apgd", "", best(), 100000, {}, kAlways, kWhyLarger},
  {"newton", "start_sweeps=5000", best(), 3000, {0, kLarge}, kAlways, kWhyLarger},
  {"admm", "", best(), 4000, {0, kLarge}, kAlways, kWhySplitting},
  {"homotopy", "", best(), AutoStage::kUnlimited, {}, kAlways, kWhyPath},
  {"ipm", "", best(), 2000, {}, kAlways, kWhyFolds},
  {"multistart", "starts=1000000 seed=3", best(), 1000000, {0, kFew}, kAlways, kWhyStarts},
  {"pgs", "", best(), AutoStage::kUnlimited, {}, kAlways, kWhyLastResort},
};

/// After rows with kThenSplitting, and after those with kThenPaths.
constexpr PlanRow kAfterSplitting[] = {
  {"homotopy", kHere, last(), 500, {0, 12000, kNear}, kAlways, kWhyShortPath},
  {"admm", "", last(0.95), {600, 1500}, {}, kAlways, kWhyNear},
  {"admm", "", last(0.9), {600, 1500}, {}, kAlways, kWhyNear},
};
constexpr PlanRow kAfterStart[] = {
  {"homotopy", kHere, last(), each(3, 1500), {0, kMany, kUseful}, kAlways, kWhyPath},
  {"homotopy", kHere, last(), each(2), {kMany, kAny, kUseful}, kAlways, kWhyPath},
  {"homotopy", kHere, last(0.95), each(3, 1500), {0, kMany, kUseful}, kAlways, kWhyNear},
  {"homotopy", kHere, last(0.95), each(2), {kMany, kAny, kUseful}, kAlways, kWhyNear},
  {"homotopy", kHere, last(0.9), each(3, 1500), {0, kMany, kUseful}, kAlways, kWhyNear},
  {"homotopy", kHere, last(1.02), each(3, 1500), {0, kMany, kUseful}, kAlways, kWhyNear},
};
// clang-format on

}  // namespace bipot::plan
