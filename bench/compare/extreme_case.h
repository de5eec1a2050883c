#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/scene.h"

namespace bipot {

/// One column of the matrix: a problem at an extreme, or a short run, and what is known of it
/// before any solver sees it.
struct ExtremeCase {
  enum class Expect {
    kSolution,  ///< a solution exists
    kNone,      ///< none does: nobody may claim one
    kOpen,      ///< either: what counts is that nothing false is said
    kRefused    ///< the data are no problem: refused with a reason
  };
  std::string name, group;
  std::string what;   ///< how it is made, one sentence
  std::string known;  ///< what is known beforehand and why, one or two sentences
  Expect expect = Expect::kSolution;
  /// One-step cases. Throws std::invalid_argument where the data are refused before there is a
  /// problem.
  std::function<ContactProblem()> problem;
  /// Relative error of an answer against what is known; may be empty.                        [-]
  std::function<double(const ContactProblem&, const Vector& s, const Vector& u)> true_error;
  /// The impulses that are known beforehand, where all of them are; rounded to double they show how
  /// low an error can be in double precision at all.
  std::function<Vector()> solution;
  /// Runs: a scene and its number of steps, instead of a problem.
  std::function<Scene<2>()> scene;
  int steps = 0;
  /// Runs: contacts may not create energy (data/manual/explanation/method.md §3).
  bool must_dissipate = false;
  bool must_conserve = false;  ///< nor destroy it
  bool large = false;          ///< left out of the quick matrix
  /// A smaller limit of a cell is raised to this: an answer at the edge of what double precision can
  /// say takes its time.                                                          [CPU s]
  double least_seconds = 0;
};

/// All cases, group by group, in the order of the page.
std::vector<ExtremeCase> extreme_cases();

/// The parts of the list, one file each.
void add_mass_cases(std::vector<ExtremeCase>& cases);
void add_friction_cases(std::vector<ExtremeCase>& cases);
void add_restitution_cases(std::vector<ExtremeCase>& cases);
void add_unit_cases(std::vector<ExtremeCase>& cases);
void add_hyperstatic_cases(std::vector<ExtremeCase>& cases);
void add_contradictory_cases(std::vector<ExtremeCase>& cases);
void add_violent_cases(std::vector<ExtremeCase>& cases);

}  // namespace bipot
