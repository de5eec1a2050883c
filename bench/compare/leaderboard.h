#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/problem_target.h"
#include "bench/measure/watch.h"
#include "core/criterion/contact_error.h"

namespace bipot {

/// Impulses of anybody for problem files, judged.
struct Leaderboard {
  /// One contestant on one problem.
  struct Entry {
    static constexpr const char* kNoImpulse = "no impulse";
    std::string who, problem;
    int contacts = 0;
    std::string defect;  ///< why there is no verdict: no file, or one that cannot be read
    double guarded = kNaN, epsilon = kNaN, eta = kNaN, cone = kNaN;  ///< ImpulseVerdict's
    double quadruple = kNaN;  ///< max(ε, η) by independent_check()
    double seconds = kNaN;    ///< as submitted
    /// guarded <= within.
    bool solves(double within) const { return guarded <= within; }
  };
  /// Solvers of this project that take part.
  struct Ours {
    std::vector<std::string> solvers;
    double tol = 1e-6;
    double time_limit = 10;  ///< CPU seconds of one solve
    Watch watch = {};        ///< an interruption ends the board with the problem before
  };

  std::vector<std::string> who;  ///< in the order of the folders, then our solvers
  std::vector<std::string> problems;
  std::vector<Entry> entries;  ///< problem by problem
  double tol = 1e-6;           ///< of our solvers
  bool complete = true;
};

/// Judges the impulses of each folder: of a problem a file of its name with the ending npy, csv,
/// hdf5, txt or dat (core/problem_files/impulse_file.h), and, in times.csv, lines
/// "problem,seconds" for these problems and others with an impulse. The name of a folder is that of
/// its contestant. Throws FileError for a folder or problem that cannot be read,
/// std::invalid_argument for two contestants of one name and for a folder without any impulse of the
/// problems.
Leaderboard make_leaderboard(const std::vector<std::filesystem::path>& folders,
                             const std::vector<ProblemSource>& problems,
                             const Leaderboard::Ours& ours);

}  // namespace bipot
