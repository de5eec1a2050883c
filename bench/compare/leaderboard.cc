#include "bench/compare/leaderboard.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>

#include "bench/measure/independent_check.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/stopwatch.h"
#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/base/number_text.h"
#include "core/criterion/impulse_verdict.h"
#include "core/files/input_file.h"
#include "core/problem_files/impulse_file.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

constexpr const char* kImpulseEndings[] = {".npy", ".csv", ".hdf5", ".txt", ".dat"};

/// What one folder has.
struct Submission {
  fs::path folder;
  std::map<std::string, double> seconds;

  std::string name() const {
    const fs::path whole = fs::absolute(folder).lexically_normal();
    return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
  }
  std::optional<fs::path> file_of(const std::string& problem) const {
    for (const char* ending : kImpulseEndings) {
      if (fs::path file = folder / (problem + ending); fs::is_regular_file(file)) return file;
    }
    return {};
  }
};

Submission read_submission(fs::path folder) {
  if (!folder.has_filename()) folder = folder.parent_path();
  if (!fs::exists(folder)) throw FileError(folder.string(), "", "no such folder");
  if (!fs::is_directory(folder)) throw FileError(folder.string(), "", "is not a folder");
  Submission made{.folder = folder, .seconds = {}};
  const fs::path times = folder / "times.csv";
  if (!fs::exists(times)) return made;
  // Written by hand or on another system: the last line may lack its end.
  std::string text = read_text_file(times);
  std::erase(text, '\r');
  if (!text.ends_with('\n')) text += '\n';
  for (const auto& row : csv_table_of(text, times, "problem,seconds", 2)) {
    const auto seconds = whole_number<double>(row[1]);
    if (!(seconds >= 0.0)) {
      throw FileError(times.string(), "", fmt::format("'{}' is no time in seconds", row[1]));
    }
    made.seconds[row[0]] = *seconds;
  }
  return made;
}

void judge_into(const ContactProblem& p, const Vector& s, Leaderboard::Entry& entry) {
  const ImpulseVerdict verdict = judge(p, s, 0);
  entry.guarded = verdict.guarded();
  entry.epsilon = verdict.error.epsilon;
  entry.eta = verdict.error.eta;
  entry.cone = verdict.cone;
  entry.quadruple = independent_check(p, s).guarded;
}

}  // namespace

Leaderboard make_leaderboard(const std::vector<fs::path>& folders,
                             const std::vector<ProblemSource>& problems,
                             const Leaderboard::Ours& ours) {
  Leaderboard board{.tol = ours.tol};
  std::vector<Submission> submissions;
  for (const fs::path& folder : folders) {
    submissions.push_back(read_submission(folder));
    const Submission& made = submissions.back();
    const bool any = std::ranges::any_of(problems, [&](const ProblemSource& problem) {
      return made.file_of(problem.name).has_value();
    });
    if (!any) throw std::invalid_argument(folder.string() + ": no impulse of these problems");
    for (const auto& [name, seconds] : made.seconds) {
      const bool known = made.file_of(name).has_value() ||
                         std::ranges::any_of(problems, [&, &name = name](const ProblemSource& p) {
                           return p.name == name;
                         });
      if (!known) {
        throw FileError((made.folder / "times.csv").string(), "",
                        fmt::format("'{}' is none of the problems and has no impulse", name));
      }
    }
    board.who.push_back(made.name());
  }
  for (const std::string& solver : ours.solvers) {
    board.who.push_back("bipot " + solver);
    warm_up(require_solver(solver));
  }
  for (auto it = board.who.begin(); it != board.who.end(); ++it) {
    if (std::count(board.who.begin(), it, *it) > 0) {
      throw std::invalid_argument(fmt::format("two contestants are called {}", *it));
    }
    if (*it == "family" || *it == "problems") {  // columns of the tables
      throw std::invalid_argument(fmt::format("a contestant cannot be called {}", *it));
    }
  }
  for (const ProblemSource& source : problems) {
    const std::string& name = source.name;
    ContactProblem p;
    try {
      p = source.load().problem;
    } catch (const Interrupted&) {  // in the run that makes the problem
      board.complete = false;
      break;
    }
    board.problems.push_back(name);
    const auto entry_of = [&](const std::string& who) {
      return Leaderboard::Entry{
          .who = who, .problem = name, .contacts = p.num_contacts(), .defect = {}};
    };
    for (const Submission& submission : submissions) {
      Leaderboard::Entry entry = entry_of(submission.name());
      const auto time = submission.seconds.find(name);
      if (time != submission.seconds.end()) entry.seconds = time->second;
      const auto impulses = submission.file_of(name);
      if (!impulses) {
        entry.defect = Leaderboard::Entry::kNoImpulse;
      } else {
        try {
          judge_into(p, read_impulses(*impulses, p), entry);
        } catch (const std::exception& e) {
          entry.defect = e.what();
        }
      }
      board.entries.push_back(std::move(entry));
    }
    for (const std::string& solver : ours.solvers) {
      Leaderboard::Entry entry = entry_of("bipot " + solver);
      const CpuStopwatch watch;
      const SolveResult result =
          solve_within(require_solver(solver), p,
                       {.tol = ours.tol, .cancelled = ours.watch.interrupted}, ours.time_limit);
      entry.seconds = watch.seconds();
      if (result.status == SolveStatus::kInvalidInput) {
        entry.defect = result.message;
      } else {
        judge_into(p, result.s, entry);
      }
      board.entries.push_back(std::move(entry));
    }
    if (ours.watch.stopped()) {
      std::erase_if(board.entries, [&](const Leaderboard::Entry& e) { return e.problem == name; });
      board.problems.pop_back();
      board.complete = false;
      break;
    }
    ours.watch.tell(static_cast<long>(board.problems.size()), static_cast<long>(problems.size()),
                    name);
  }
  return board;
}

}  // namespace bipot
