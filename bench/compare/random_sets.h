#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/watch.h"

namespace bipot {

struct RandomSets {
  /// Results of a solver on a random set, in problems (or steps, for scenes).
  struct Tally {
    std::string solver;
    int tried = 0, refused = 0;  ///< refused: not this solver's dimension or size
    int planted = 0, planted_solved = 0;
    int other = 0, other_solved = 0;  ///< without a planted solution
    int none_proved = 0;              ///< of these: certified to have no solution
    int exists_unsolved = 0;          ///< of these: certified to have one, not solved
    int undecided = 0;                ///< of these: not solved, and undecided
    int missed_by_first = 0;          ///< solved by this solver, but not by the first one
    int false_claims = 0;             ///< claimed convergence that the independent check denies
    int not_finite = 0;               ///< returned an entry that is not finite
    int crashed = 0, hung = 0;
    double cpu_seconds = 0;
  };
  /// One problem that should be examined.
  struct Finding {
    std::string kind;  ///< "false claim", "not solved", …
    int index = 0;
    std::string solver, message;
  };
  struct Options {
    int count = 0;
    int first = 0;  ///< index of the first problem
    std::uint64_t seed = 1;
    double tol = 1e-8;
    double time_limit = 2;  ///< CPU seconds of a solve
    /// Solvers of the problems: the first runs on all of them, the others in turn.
    std::vector<std::string> solvers;
    Watch watch;
  };
  std::vector<Tally> tallies;  ///< in the order of the solvers
  std::vector<Finding> findings;
  int done = 0;
  int certificates = 0;        ///< problems whose existence was looked at
  int false_certificates = 0;  ///< "none" where a solution was planted or found
  int poor_plants =
      0;  ///< planted solutions that rounding leaves above tol / 10: not counted as planted
  /// Energy that a scene's contacts created although one coefficient e and fixed walls forbid it.
  int energy_grew = 0;
  bool sound() const;  ///< no false claim, no NaN, crash, hang, or false certificate
};

/// Problems of random_problem.h; in a child process each crash and hang is counted.
RandomSets run_random_problems(const RandomSets::Options& options);

/// Scenes of random_scene.h, `kStepsOfAScene` steps each, all by the solvers' first one.
RandomSets run_random_scenes(const RandomSets::Options& options);
inline constexpr int kStepsOfAScene = 20;

std::string to_text(const RandomSets& result, const std::string& what);

}  // namespace bipot
