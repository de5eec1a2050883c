#include "solvers/auto/auto_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/counted.h"
#include "core/base/number_text.h"
#include "solvers/auto/recovered_disks.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// constant        value  unit       reason
// kFair           5e-4   tolerance  from here on stages near it have no more than their budget
// kUnequalRatio   1e5    W_nn/W_nn  first order needs the root of it in iterations
// kManyContacts   3.5    contacts   a sphere; random packings have about 3 at most
// kScalar         20     contacts   too few disks to fill vectors
// kSmallLattice   600    contacts   accelerated sweeps solve square lattices up to it quickly
constexpr double kFair = 5e-4, kUnequalRatio = 1e5, kManyContacts = 3.5;
constexpr int kScalar = 20, kSmallLattice = 600;

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

/// A list's rows, those of its repetitions with larger budgets, and of the lists that it names.
class Planner {
 public:
  Planner(const AutoPlan& plan, const ProblemTraits& problem) : plan_(&plan), problem_(problem) {
    stages_.reserve(64);
  }

  void add(const std::vector<AutoPlan::Row>& rows, double times) {
    for (const AutoPlan::Row& row : rows) {
      if (!row.conditions.hold(problem_)) continue;
      if (row.list.empty()) {
        add(row, times);
        continue;
      }
      for (int k = 0; k < row.repeat; ++k) {
        add_list(row.list, times * std::pow(row.growth, k));
      }
    }
  }
  void add_class() {
    const AutoPlan::Class* of = plan_->class_of(problem_);
    if (of != nullptr) return add(of->rows, 1);
    if (plan_ != &shipped_plan()) add_list(std::string(kShippedList), 1);
  }
  std::vector<AutoStage> stages() { return std::move(stages_); }

 private:
  void add_list(const std::string& name, double times) {
    if (name != kShippedList) return add(plan_->lists.at(name), times);
    const AutoPlan* own = std::exchange(plan_, &shipped_plan());
    add_class();
    plan_ = own;
  }
  void add(const AutoPlan::Row& row, double times) {
    const SolverEntry* solver = find_solver(row.solver);
    if (solver == nullptr || problem_.dim > solver->max_dim ||
        problem_.contacts > solver->max_contacts || (problem_.rolls && !solver->rolls)) {
      return;
    }
    const int most = row.most.of(problem_.contacts, times);
    const int near = std::min(row.near.of(problem_.contacts, times), most);
    const int least = std::min(row.least.of(problem_.contacts, times), most);
    stages_.push_back({row, solver, least, most, problem_.tol >= kFair ? near : most});
  }

  const AutoPlan* plan_;
  const ProblemTraits problem_;
  std::vector<AutoStage> stages_;
};

std::string start_in_words(const AutoStage& stage) {
  static constexpr std::string_view kNames[] = {"", "the given start", "the last impulse",
                                                "the best impulse"};
  const std::string_view name = kNames[static_cast<int>(stage.start)];
  if (name.empty()) return "";
  if (stage.of_start == 1) return fmt::format("; from {}", name);
  return fmt::format("; from {:g} times {}", stage.of_start, name);
}

/// The class that serves, why, and its odds.
std::string class_in_words(const AutoPlan& plan, const ProblemTraits& problem) {
  const AutoPlan::Class* of = plan.class_of(problem);
  if (of == nullptr) return fmt::format("{}: no class serves\n", plan.source);
  const std::string why = of->conditions.to_text();
  std::string text =
      fmt::format("{}: class '{}' ({})", plan.source, of->name, why.empty() ? "all others" : why);
  if (of->measured > 0) {
    text += fmt::format(", solved {} of {} measured", of->solved, of->measured);
  }
  return text + "\n";
}

}  // namespace

ProblemTraits traits_of(const ContactProblem& p, const DelassusOperator& delassus,
                        const SolverOptions& options) {
  const auto& disks = delassus.disks();
  const int n = p.num_contacts();
  const bool vectors =
      disks && p.dim == 2 && n > kScalar && !(n <= kSmallLattice && is_square_lattice(*disks));
  unsigned marks = is_warm(options) ? kWarm : kCold;
  const auto forces = options.parameters.find("forces");
  if (forces == options.parameters.end() || forces->second == "any") marks |= kAnyForces;
  marks |= disks ? kDisks : kNoDisks;
  marks |= vectors ? kVectors : kNoVectors;
  marks |= p.has_velocities() ? kBodies : kWAlone;
  marks |= p.plain_dim() <= 2 ? kInPlane : kInSpace;
  if (ratio_of_diagonal(p, delassus) > kUnequalRatio) marks |= kUnequal;
  // 6 degrees of freedom a sphere.
  if (p.plain_dim() == 3 && p.has_velocities() && 6 * n > kManyContacts * p.num_dofs()) {
    marks |= kClosePacked;
  }
  return {
      .contacts = n, .dim = p.plain_dim(), .tol = options.tol, .marks = marks, .rolls = p.rolls()};
}

std::vector<AutoStage> plan_stages(const AutoPlan& plan, const ProblemTraits& problem) {
  Planner planner(plan, problem);
  planner.add_class();
  return planner.stages();
}

std::vector<AutoStage> serving_stages(const AutoPlan& plan, const ProblemTraits& problem) {
  std::vector<AutoStage> stages = plan_stages(plan, problem);
  return stages.empty() ? plan_stages(shipped_plan(), problem) : stages;
}

std::string explain_auto(const ContactProblem& p, const SolverOptions& options) {
  if (const auto bodies = recovered_disks(p)) {
    return "W is that of disks: they are recovered\n" + explain_auto(*bodies, options);
  }
  const auto own = options.plan ? options.plan : named_plan(options.parameters);
  const AutoPlan& plan = own ? *own : shipped_plan();
  const bool warm = is_warm(options);
  const ProblemTraits problem = traits_of(p, DelassusOperator(p), options);
  std::string text = fmt::format("auto: {}, d = {}, {}, {} start, tolerance {}\n",
                                 counted(p.num_contacts(), "contact"), p.dim,
                                 p.has_velocities() ? "bodies given" : "W alone given",
                                 warm ? "warm" : "cold", tolerance_label(options.tol));
  text += class_in_words(plan, problem);
  int number = 0;
  for (const AutoStage& stage : serving_stages(plan, problem)) {
    const std::string budget =
        stage.max_iterations == AutoStage::kUnlimited
            ? "(no limit)"
            : fmt::format("({} to {})", stage.min_iterations, stage.max_iterations);
    const std::string condition =
        std::isfinite(stage.largest_error)
            ? fmt::format("; if the best error is at most {:g}", stage.largest_error)
            : "";
    text += fmt::format("  {:>2}. {:<10} {:<16} {}{}{}\n", ++number, stage.solver->name, budget,
                        stage.reason, start_in_words(stage), condition);
  }
  return text;
}

}  // namespace bipot
