#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/scene.h"

namespace bipot {

/// One column of the matrix: a problem at an extreme, or a short run, with facts known before any
/// solve.
struct ExtremeCase {
  enum class Expect {
    kSolution,  ///< a solution exists
    kNone,      ///< none does: nobody may claim one
    kOpen,      ///< either: any true statement is accepted
    kRefused    ///< the data are no problem: refused with a reason
  };
  std::string name, group;
  std::string what;   ///< how it is made, one sentence
  std::string known;  ///< known facts and their reason, one or two sentences
  Expect expect = Expect::kSolution;
  /// One-step cases. Throws std::invalid_argument if the data are refused before there is a
  /// problem.
  std::function<ContactProblem()> problem;
  /// Relative error of an answer against the known one; may be empty. [-]
  using Error = std::function<double(const Vector& s, const Vector& u)>;
  Error true_error;
  /// The known impulses, if all are known. Rounded to double they show the least possible error in
  /// double precision.
  std::function<Vector()> solution;
  /// Runs: a scene and its number of steps, instead of a problem.
  std::function<Scene<2>()> scene;
  int steps = 0;
  /// Runs: contacts may not create energy (data/manual/explanation/method.md §3).
  bool must_dissipate = false;
  bool must_conserve = false;  ///< nor destroy it
  bool large = false;          ///< left out of the quick matrix
  /// Least time limit of a cell: answers at the limits of double precision take long. [CPU s]
  double least_seconds = 0;
};

/// All cases, group by group, in the order of the page.
std::vector<ExtremeCase> extreme_cases();

/// The parts of the list, one file each, without their group.
void add_mass_cases(std::vector<ExtremeCase>& cases);
void add_friction_cases(std::vector<ExtremeCase>& cases);
void add_restitution_cases(std::vector<ExtremeCase>& cases);
void add_unit_cases(std::vector<ExtremeCase>& cases);
void add_hyperstatic_cases(std::vector<ExtremeCase>& cases);
void add_contradictory_cases(std::vector<ExtremeCase>& cases);
void add_violent_cases(std::vector<ExtremeCase>& cases);

}  // namespace bipot
