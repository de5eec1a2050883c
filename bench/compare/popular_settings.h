#pragma once

#include <array>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bench/measure/problem_target.h"
#include "bench/measure/true_error.h"
#include "bench/measure/watch.h"
#include "core/criterion/contact_error.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// A code as it is run by default, or in its own benchmark, by a solver of this project. Sources
/// and departures: data/manual/reference/settings.md.
struct PopularSetting {
  /// What the code compares with its tolerance, evaluated on the iterates of that solver. u = W s +
  /// b, û = u + mu |u_t| n, s⁻: the iterate before, norms over all contacts.
  enum class Test {
    kNone,        ///< a fixed number of iterations
    kNaturalMap,  ///< Siconos: peer_natural_map()                                          [-]
    /// LMGC90, check "Quad". x: the impulse of each contact alone, the others as they are; V =
    /// W_cc (s - x)_c, R = (s + x)_c/2, sums over both s and x halved. The largest of
    /// (Σ|V|²/Σ|W_cc s_c|²)^½, (n Σ|V|²|R|²)^½/Σs·W_cc s and |ΣR·V|/Σs·W_cc s, with n contacts that
    /// push                                                                                  [-]
    kQuadratic,
    /// Kamino: the largest of |s - s⁻| [N s], |û - P_K*(û)| [m/s] and |s·û| [J], as numbers
    kAbsolute,
    kFixedPoint  ///< SCoPI: |q - q⁻| / (|q| + 1), q = mu |u_t| [m/s], as a number
  };

  std::string code;
  std::string rule;  ///< for readers: when it stops
  std::string solver;
  std::map<std::string, std::string> parameters = {};
  Test test = Test::kNone;
  double tol = kNaN;
  int most = 0;   ///< iterations
  int every = 1;  ///< iterations between two tests
};
std::string to_string(PopularSetting::Test test);

const std::vector<PopularSetting>& popular_settings();

/// All settings on some problems.
struct SettingStudy {
  /// Tolerances whose meaning is asked for, of each test.
  static constexpr std::array<double, 4> kTolerances = {1e-2, 1e-3, 1e-4, 1e-6};

  /// The result of a setting on one problem.
  struct Row {
    std::string code, problem;
    int contacts = 0, dim = 0;
    std::string end;       ///< "test", "most iterations", "time limit", or a status
    int iterations = 0;    ///< of the impulse that is judged
    double own = kNaN;     ///< what its test gave there
    ContactError error;    ///< of that impulse
    TrueError true_error;  ///< undefined without a reference below 1e-9
    /// max(ε, η) of the first iterate within each of kTolerances; NaN: not reached.
    std::array<double, 4> at_tolerance = {kNaN, kNaN, kNaN, kNaN};
  };

  /// Bodies in each other after steps that a setting ended, from a start without overlaps.
  struct Overlap {
    static constexpr int kSteps = 100;
    static constexpr const char* kColumn = "column at rest";   ///< a scene; exact steps give 0
    static constexpr const char* kExact = "max(ε, η) = 1e-8";  ///< code of the steps by `auto`
    std::string code, scene;
    double largest = kNaN, mean = kNaN;  ///< of the pairs that overlap, over the smallest radius
    std::string end;                     ///< empty, or why there is none
  };

  struct Options {
    double time_limit = 2;            ///< CPU seconds of one run, or of one step
    double reference_time_limit = 5;  ///< of one attempt at a reference to 1e-10
    bool warm = false;                ///< from the problem's start, where it has one
    bool overlaps = true;             ///< are measured
    Watch watch = {};
  };

  std::vector<Row> rows;             ///< problem by problem
  std::vector<Overlap> overlaps;     ///< scene by scene
  std::vector<std::string> defects;  ///< problems that could not be made, and why
  bool complete = false;
};

/// Runs one setting. The run goes on after its end until kTolerances are reached, or for 3000
/// iterations, within the time limit. `true_error` may be null.
SettingStudy::Row run_popular(const PopularSetting& setting, const TestProblem& problem,
                              const TrueErrorEvaluator* true_error,
                              const SettingStudy::Options& options);

/// Ends each step as the setting does, from the impulses of the step before.
StepSolver popular_step_solver(const PopularSetting& setting, const SettingStudy::Options& options);

/// Of three scenes: disks that fall, a column of 30 rows at rest, spheres that fall.
std::vector<SettingStudy::Overlap> popular_overlaps(const SettingStudy::Options& options);

SettingStudy study_settings(const std::vector<ProblemSource>& sources,
                            const SettingStudy::Options& options);

}  // namespace bipot
