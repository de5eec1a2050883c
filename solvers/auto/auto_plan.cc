#include "solvers/auto/auto_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/auto/plan_tables.h"
#include "solvers/registry.h"

namespace bipot {
namespace plan {
namespace {

/// True if all normals are along or across one direction.
bool is_square_lattice(const DiskStructure& disks) {
  constexpr double kSame = 1e-6;
  if (disks.contacts.empty()) return false;
  const auto& first = disks.contacts.front().n;
  return std::all_of(disks.contacts.begin(), disks.contacts.end(), [&](const auto& c) {
    const double along = first[0] * c.n[0] + first[1] * c.n[1];
    const double across = first[0] * c.n[1] - first[1] * c.n[0];
    return std::abs(along) < kSame || std::abs(across) < kSame;
  });
}

/// Largest over smallest W_nn of a contact.
double ratio_of_diagonal(const ContactProblem& p, const DelassusOperator& delassus) {
  const Vector diagonal = delassus.diagonal();
  double least = kInfinity, most = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double w = diagonal[static_cast<Eigen::Index>(c) * p.dim];
    if (w > 0) least = std::min(least, w);
    most = std::max(most, w);
  }
  return most > 0 ? most / least : 1;
}

/// The marks of plan_tables.h that the problem has.
unsigned marks_of(const ContactProblem& p, const DelassusOperator& delassus, bool warm) {
  const auto& disks = delassus.disks();
  const int n = p.num_contacts();
  const bool vectors =
      disks && p.dim == 2 && n > kScalar && !(n <= kSmallLattice && is_square_lattice(*disks));
  unsigned marks = warm ? kWarm : kCold;
  marks |= disks ? kDisks : kNoDisks;
  marks |= vectors ? kVectors : kNoVectors;
  marks |= p.has_velocities() ? kBodies : kWAlone;
  marks |= p.dim <= 2 ? kInPlane : kInSpace;
  if (ratio_of_diagonal(p, delassus) > kUnequalRatio) marks |= kUnequal;
  return marks;
}

/// The table of the problem's class.
std::span<const PlanRow> class_of(unsigned marks, int contacts, double tol) {
  if (marks & kInSpace) return kSpace;
  if (marks & kWAlone) return kPlaneOfW;
  if (contacts <= kMany) return kSmall;
  if (contacts <= kLarge) return kMedium;
  if (tol >= kFair) return kLargeFair;
  if ((marks & kWarm) && contacts <= kLargeWarm) return kMedium;
  return kLargeTight;
}

/// Makes stages from the rows that apply.
class Planner {
 public:
  Planner(int contacts, unsigned marks, double tol)
      : contacts_(contacts), marks_(marks), tol_(tol) {
    stages_.reserve(64);
  }

  void add(std::span<const PlanRow> rows) {
    for (const PlanRow& row : rows) {
      if (!serves(row)) continue;
      add(row);
      if ((row.marks & kThenPaths) == kThenPaths) add(kAfterStart);
      if ((row.marks & kThenSplitting) == kThenSplitting) add(kAfterSplitting);
    }
  }
  std::vector<AutoStage> stages() { return std::move(stages_); }

 private:
  bool serves(const PlanRow& row) const {
    const When& when = row.when;
    const unsigned asked = row.marks & kOfProblem;
    return (marks_ & asked) == asked && when.above < contacts_ && contacts_ <= when.up_to &&
           when.tol_from <= tol_ && tol_ < when.tol_below && can_run(row.solver);
  }
  bool can_run(std::string_view solver) const {
    if (solver == "homotopy") return marks_ & kInPlane;
    return solver != "newton" || with_newton_;
  }
  void add(const PlanRow& row) {
    const int most = row.budget.most.of(contacts_);
    stages_.push_back({.solver = row.solver,
                       .parameters = row.parameters,
                       .start = row.start.start,
                       .of_start = row.start.multiple,
                       .min_iterations = std::min(row.budget.least.of(contacts_), most),
                       .max_iterations = most,
                       .near_iterations = tol_ >= kFair ? std::min(row.budget.near, most) : most,
                       .largest_error = row.when.error,
                       .before_cutting = (row.marks & kWhole) != 0,
                       .on_whole_only = (row.marks & kWholeOnly) == kWholeOnly,
                       .reason = row.reason});
  }

  const int contacts_;
  const unsigned marks_;
  const double tol_;
  const bool with_newton_ = find_solver("newton") != nullptr;  // needs PETSc
  std::vector<AutoStage> stages_;
};

}  // namespace
}  // namespace plan

namespace {

std::string start_in_words(const AutoStage& stage) {
  static constexpr std::string_view kNames[] = {"", "the given start", "the last impulse",
                                                "the best impulse"};
  const std::string_view name = kNames[static_cast<int>(stage.start)];
  if (name.empty()) return "";
  if (stage.of_start == 1) return fmt::format("; from {}", name);
  return fmt::format("; from {:g} times {}", stage.of_start, name);
}

}  // namespace

std::vector<AutoStage> plan_auto(const ContactProblem& p, const DelassusOperator& delassus,
                                 bool warm, double tol) {
  const unsigned marks = plan::marks_of(p, delassus, warm);
  plan::Planner planner(p.num_contacts(), marks, tol);
  planner.add(plan::kFirst);
  planner.add(plan::class_of(marks, p.num_contacts(), tol));
  planner.add(plan::kLargerBudgets);
  planner.add(plan::kLongRuns);
  return planner.stages();
}

std::string explain_auto(const ContactProblem& p, const SolverOptions& options) {
  const bool warm = is_warm(options);
  std::string text = fmt::format(
      "auto: {} contacts, d = {}, {}, {} start, tolerance {:.0e}\n", p.num_contacts(), p.dim,
      p.has_velocities() ? "bodies given" : "W alone given", warm ? "warm" : "cold", options.tol);
  int number = 0;
  for (const AutoStage& stage : plan_auto(p, DelassusOperator(p), warm, options.tol)) {
    const std::string budget =
        stage.max_iterations == AutoStage::kUnlimited
            ? "(no limit)"
            : fmt::format("({} to {})", stage.min_iterations, stage.max_iterations);
    const std::string condition =
        std::isfinite(stage.largest_error)
            ? fmt::format("; if the best error is at most {:.0e}", stage.largest_error)
            : "";
    text += fmt::format("  {:>2}. {:<10} {:<16} {}{}{}\n", ++number, stage.solver, budget,
                        stage.reason, start_in_words(stage), condition);
  }
  return text;
}

}  // namespace bipot
