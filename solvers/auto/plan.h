#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Properties of a problem that a plan can ask for.
enum PlanMark : unsigned {
  kWarm = 1,           ///< the caller's start is not 0
  kCold = 2,           ///< it is 0
  kDisks = 4,          ///< disks in 2D
  kNoDisks = 8,        ///< anything else
  kVectors = 16,       ///< disks with friction that fill vectors, and no small square lattice
  kNoVectors = 32,     ///< anything else
  kUnequal = 64,       ///< very unequal masses
  kBodies = 128,       ///< the bodies are given
  kWAlone = 256,       ///< W alone is given
  kInPlane = 512,      ///< d <= 2
  kInSpace = 1024,     ///< d = 3
  kInParallel = 2048,  ///< several processes have it
  kAnyForces = 4096,   ///< any force network serves that obeys the law
  kClosePacked = 8192  ///< spheres with many more contacts than a random packing has
};

/// The marks as words, separated by blanks, and back; an unknown word throws std::invalid_argument.
std::string mark_words(unsigned marks);
unsigned marks_of_words(std::string_view words);

/// What a plan knows of a problem.
struct ProblemTraits {
  int contacts = 0, dim = 0;
  double tol = 0;
  unsigned marks = 0;  ///< of PlanMark
  bool rolls = false;  ///< rolling friction: stages of solvers that take it alone serve
};

/// Holds for `above` < N <= `up_to` contacts, tolerances from `tol_from` and below `tol_below`, and
/// problems with all `marks`.
struct PlanConditions {
  double above = -1, up_to = kInfinity, tol_from = 0, tol_below = kInfinity;
  unsigned marks = 0;

  bool hold(const ProblemTraits& problem) const {
    return (problem.marks & marks) == marks && above < problem.contacts &&
           problem.contacts <= up_to && tol_from <= problem.tol && problem.tol < tol_below;
  }
  /// "N <= 2500, warm"; empty: always.
  std::string to_text() const;
};

/// What a stage of `auto` has from its row of the plan.
struct StageTerms {
  /// A stage starts at the impulse of the same solver's last stage (at first, at the caller's
  /// start), at the caller's start, at the impulse of the last stage, or at the best one.
  enum class Start { kOwn, kCaller, kLast, kBest };

  std::string parameters;  ///< "name=value name=value"
  Start start = Start::kOwn;
  double of_start = 1;  ///< factor of that impulse
  double largest_error = kInfinity;
  bool before_cutting = false;  ///< tried on the whole before it is split into islands
  bool on_whole_only = false;   ///< then not tried again on islands
  std::string reason;
};

/// The plan of `auto`: data/manual/explanation/auto.md has the form of the file.
struct AutoPlan {
  /// A stage (auto_plan.h), or a list of stages.
  struct Row : StageTerms {
    /// max(least, factor N^power), rounded down; a single number does not depend on N.
    struct Count {
      double factor = 0, power = 0, least = 0;
      /// `times` that number, at most AutoStage::kUnlimited.
      int of(int contacts, double times) const;
    };
    PlanConditions conditions;
    std::string list;   ///< its name; empty: a stage
    int repeat = 1;     ///< of the list
    double growth = 1;  ///< of its budgets, with each repetition
    std::string solver;
    Count least, most, near;
  };
  /// The rows for one class of problems.
  struct Class {
    std::string name;
    PlanConditions conditions;
    int solved = 0, measured = 0;  ///< by its own stages; 0: not measured
    std::vector<Row> rows;
  };
  std::string source;
  std::vector<Class> classes;  ///< the first one whose conditions hold serves
  std::map<std::string, std::vector<Row>> lists;

  /// Null: none serves.
  const Class* class_of(const ProblemTraits& problem) const;
};

/// "name=value name=value" as a map; a word without '=' has an empty value.
std::map<std::string, std::string> stage_parameters(std::string_view text);

/// The name of the list that stands for the stages of the shipped plan.
inline constexpr std::string_view kShippedList = "shipped";

/// Throws std::invalid_argument, "source:line: reason".
AutoPlan parse_plan(std::string_view text, const std::string& source);
/// Also throws FileError.
std::shared_ptr<const AutoPlan> read_plan(const std::filesystem::path& path);
/// The plan that a solver's parameter `plan` names; null without one. Throws as read_plan.
std::shared_ptr<const AutoPlan> named_plan(const std::map<std::string, std::string>& parameters);
/// solvers/auto/plan.toml, which is part of the program.
const AutoPlan& shipped_plan();

}  // namespace bipot
