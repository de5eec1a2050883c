#include "bench/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "bench/compare/comparison_store.h"
#include "bench/measure/cpu_limit.h"
#include "bench/measure/stopwatch.h"
#include "bench/measure/true_error.h"
#include "bench/measure/warm_up.h"
#include "bench/report/build_info.h"
#include "core/file_error.h"
#include "core/motion/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  const std::size_t half = x.size() / 2;
  return x.size() % 2 == 1 ? x[half] : 0.5 * (x[half - 1] + x[half]);
}

/// Adds a judged iteration to a history, unless it comes too soon after the one before. The newest
/// always stands at the end.
class HistoryRecorder {
 public:
  void operator()(const IterationRecord& r) {
    const bool early = r.iteration <= kDense, first = points_.empty();
    if (!first && newest_is_extra_) points_.pop_back();
    newest_is_extra_ = !early && !first && r.iteration < kGrowth * points_.back().iteration;
    points_.push_back({r.iteration, r.seconds, r.error.epsilon, r.error.eta});
  }
  std::vector<HistoryPoint> points() const { return points_; }

 private:
  static constexpr int kDense = 32;
  static constexpr double kGrowth = 1.1;
  std::vector<HistoryPoint> points_;
  bool newest_is_extra_ = false;
};

struct Measurement {
  ComparisonRow row;
  std::vector<HistoryPoint> history;
};

Measurement measure(const SolverEntry& entry, const TestProblem& given, double tol,
                    const TrueErrorEvaluator& true_error, const ComparisonOptions& options) {
  const ContactProblem& problem = given.problem;
  Measurement made;
  ComparisonRow& row = made.row;
  SolverOptions solver;
  solver.tol = tol;
  solver.time_limit = CpuLimit::kWallFactor * options.time_limit;
  // Watching costs next to nothing beside the judgements themselves, and only the first repeat is
  // watched.
  HistoryRecorder recorder;
  solver.on_iteration = [&recorder](const IterationRecord& r) { recorder(r); };
  std::vector<double> setup, solve_time, total, cpu;
  double spent = 0;
  for (int k = 0; k < std::max(1, options.repeat) || spent < options.min_time; ++k) {
    CpuLimit limit(options.time_limit);
    solver.cancelled = [&limit] { return limit(); };
    const CpuStopwatch watch;
    SolveResult result = solve(entry, problem, solver);
    cpu.push_back(watch.seconds());
    spent += cpu.back();
    setup.push_back(result.setup_seconds);
    solve_time.push_back(result.solve_seconds);
    total.push_back(result.setup_seconds + result.solve_seconds);
    if (k == 0) {
      solver.on_iteration = nullptr;
      if (limit.reached() && !is_success(result.status)) {
        result.status = SolveStatus::kTimeLimit;
        result.message =
            fmt::format("time limit {} s of CPU time reached after {} iterations, error {:.2e}",
                        options.time_limit, result.iterations, result.error.guarded());
      }
      row.status = to_string(result.status);
      row.message = result.message;
      row.iterations = result.iterations;
      if (result.status == SolveStatus::kInvalidInput) return made;
      made.history = recorder.points();
      row.epsilon = result.error.epsilon;
      row.eta = result.error.eta;
      row.guarded = result.error.guarded();
      row.raw42 = result.error.raw42;
      row.natural_map = result.error.natural_map;
      const ContactCount count = count_contacts(problem, result.s);
      row.take_off = count.take_off;
      row.stick = count.stick;
      row.slip = count.slip;
      const TrueError error = true_error(result.s);
      row.velocity_error = error.velocity;
      row.force_error = error.force;
      row.contact_force_error = error.contact_force;
      row.penetration_velocity = error.penetration_velocity;
      row.penetration = error.penetration;
      row.dissipated = error.dissipated;
      row.energy_error = error.energy;
    }
    if (limit.reached() || result.status == SolveStatus::kTimeLimit) break;  // more of the same
  }
  row.repeats = static_cast<int>(total.size());
  row.setup_min = *std::min_element(setup.begin(), setup.end());
  row.setup_median = median(setup);
  row.solve_min = *std::min_element(solve_time.begin(), solve_time.end());
  row.solve_median = median(solve_time);
  row.total_min = *std::min_element(total.begin(), total.end());
  row.cpu_min = *std::min_element(cpu.begin(), cpu.end());
  return made;
}

/// Makes the rows of one problem, and the problem itself only where one is missing.
class ProblemRows {
 public:
  ProblemRows(const ProblemSource& source, const ComparisonOptions& options, ComparisonStore& store,
              const std::string& commit)
      : source_(source), options_(options), store_(store), commit_(commit) {}

  /// `hopeless`: why the solver is not tried, empty when it is.
  Measurement make(const SolverEntry& entry, double tol, const ComparisonRow* looser,
                   const std::string& hopeless) {
    prepare();
    Measurement made;
    ComparisonRow& row = made.row;
    if (!defect_.empty()) {
      row.status = to_string(SolveStatus::kInvalidInput);
      row.message = defect_;
    } else if (!hopeless.empty()) {
      row.status = ComparisonRow::kNotTried;
      row.message = hopeless;
    } else if (looser != nullptr && entry.path_ignores_tolerance &&
               looser->status == to_string(SolveStatus::kTimeLimit)) {
      row = *looser;
      if (!row.message.starts_with("not run again")) {
        row.message = fmt::format("not run again: out of time at tol {:g} already ({})",
                                  looser->tol, looser->message);
      }
    } else {
      made = measure(entry, problem_, tol, *true_error_, options_);
    }
    row.problem = source_.name;
    row.solver = entry.name;
    row.tol = tol;
    row.contacts = problem_.problem.num_contacts();
    row.dim = defect_.empty() ? problem_.problem.dim : 0;
    row.commit = commit_;
    return made;
  }

  /// Without the problem where no row was missing and the reference is kept.
  ProblemSummary summary() {
    if (!prepared_) {
      if (auto kept = store_.reference(source_.name)) {
        reference_ = std::move(*kept);
      } else {
        prepare();
      }
    }
    ProblemSummary s;
    s.name = source_.name;
    s.target = source_.target;
    s.origin = reference_.origin;
    s.defect = defect_;
    s.series = source_.series;
    s.contacts = reference_.contacts;
    s.dim = reference_.dim;
    s.dofs = reference_.dofs;
    s.reference_solver = reference_.solver;
    s.reference_guarded = reference_.error.guarded();
    s.reference_natural_map = reference_.error.natural_map;
    s.attempts = reference_.attempts;
    s.velocity_spread = reference_.velocity_spread;
    return s;
  }

 private:
  void prepare() {
    if (prepared_) return;
    prepared_ = true;
    try {
      problem_ = source_.load();
      if (auto wrong = validate(problem_.problem); !wrong.empty()) defect_ = wrong;
    } catch (const FileError& e) {
      defect_ = e.what();
    } catch (const std::invalid_argument& e) {
      defect_ = e.what();
    } catch (const StepFailure& e) {
      defect_ = e.what();
    }
    if (!defect_.empty()) {
      problem_ = {};
      return;
    }
    if (auto kept = store_.reference(source_.name);
        kept && kept->s.size() == problem_.problem.num_rows()) {
      reference_ = std::move(*kept);
      const double before = reference_.error.guarded();
      reference_.error = contact_error(problem_.problem, reference_.s);
      if (std::isfinite(before) &&
          !(reference_.error.guarded() <= 10 * before + ReferenceSolution::kTarget)) {
        throw std::invalid_argument(
            fmt::format("{}: problem {} is not the one that the rows there were made for (its "
                        "reference had the error {:.1e}, now {:.1e}): name another folder",
                        options_.out.string(), source_.name, before, reference_.error.guarded()));
      }
    } else {
      reference_ = find_reference(problem_, options_.reference_time_limit,
                                  ReferenceSolution::kTarget, LimitOn::kCpu);
      store_.write(source_, problem_, reference_);
    }
    true_error_.emplace(problem_, reference_);
  }

  const ProblemSource& source_;
  const ComparisonOptions& options_;
  ComparisonStore& store_;
  const std::string& commit_;
  bool prepared_ = false;
  std::string defect_;
  TestProblem problem_;
  ReferenceSolution reference_;
  std::optional<TrueErrorEvaluator> true_error_;
};

/// Which solver ran out of time where.
class TimeOuts {
 public:
  void add(const ProblemSource& source, const ComparisonRow& row) {
    if (row.status != to_string(SolveStatus::kTimeLimit)) return;
    seen_.push_back({source.series, row.solver, source.name, source.size, row.tol});
  }

  /// Why there is no hope, in words; empty when nothing is known.
  std::string reason(const ProblemSource& source, std::string_view solver, double tol) const {
    if (solver == "auto") return {};
    for (const Seen& s : seen_) {
      if (s.solver != solver || s.tol < tol) continue;
      const bool smaller =
          !source.series.empty() && s.series == source.series && s.size < source.size;
      // Where the path does not depend on the tolerance, the row is known without a run.
      const bool looser =
          s.problem == source.name && s.tol > tol && !require_solver(solver).path_ignores_tolerance;
      if (smaller || looser) {
        return fmt::format("not tried: out of time on {} at tol {:g}", s.problem, s.tol);
      }
    }
    return {};
  }

 private:
  struct Seen {
    std::string series, solver, problem;
    double size, tol;
  };
  std::vector<Seen> seen_;
};

}  // namespace

double HistoryPoint::guarded() const {
  ContactError error;
  error.epsilon = epsilon;
  error.eta = eta;
  return error.guarded();
}

Comparison compare(const std::vector<ProblemSource>& sources, const ComparisonOptions& options) {
  std::vector<const SolverEntry*> entries;
  for (const std::string& name : options.solvers) {
    entries.push_back(&require_solver(name));
  }
  std::vector<double> tols = options.tols;
  std::sort(tols.begin(), tols.end(), std::greater<>());
  tols.erase(std::unique(tols.begin(), tols.end()), tols.end());
  for (double tol : tols) {
    if (!(tol > 0) || !std::isfinite(tol)) {
      throw std::invalid_argument(fmt::format("tolerance {}, expected a positive number", tol));
    }
  }

  const std::string commit = build_info().commit;
  ComparisonStore store(options);
  Comparison comparison;
  bool warm = false;
  TimeOuts time_outs;
  const int total = static_cast<int>(sources.size() * entries.size() * tols.size());
  for (const ProblemSource& source : sources) {
    ProblemRows problem(source, options, store, commit);
    const std::size_t first = comparison.rows.size();
    for (const SolverEntry* entry : entries) {
      for (std::size_t k = 0; k < tols.size(); ++k) {
        if (options.interrupted && options.interrupted()) return comparison;
        if (const ComparisonRow* kept =
                store.find(source.name, std::string(entry->name), tols[k])) {
          comparison.rows.push_back(*kept);
          ++comparison.rows_kept;
        } else {
          if (!warm) {
            for (const SolverEntry& solver : solver_table()) warm_up(solver);
          }
          warm = true;
          const ComparisonRow* looser = k > 0 ? &comparison.rows.back() : nullptr;
          const std::string hopeless =
              options.try_all ? "" : time_outs.reason(source, entry->name, tols[k]);
          Measurement made = problem.make(*entry, tols[k], looser, hopeless);
          store.append(made.row, {source.name, std::string(entry->name), tols[k], made.history});
          comparison.rows.push_back(std::move(made.row));
        }
        time_outs.add(source, comparison.rows.back());
        if (options.on_row) {
          options.on_row(comparison.rows.back(), static_cast<int>(comparison.rows.size()), total);
        }
      }
      if (const History* history = store.history(source.name, std::string(entry->name))) {
        comparison.histories.push_back(*history);
      }
    }
    ProblemSummary summary = problem.summary();
    if (summary.reference_guarded <= ReferenceSolution::kTrusted) {
      for (std::size_t i = first; i < comparison.rows.size(); ++i) {
        const ComparisonRow& row = comparison.rows[i];
        if (row.guarded <= ReferenceSolution::kTrusted && std::isfinite(row.velocity_error)) {
          summary.velocity_spread = std::fmax(summary.velocity_spread, row.velocity_error);
        }
      }
    }
    comparison.problems.push_back(std::move(summary));
  }
  comparison.complete = true;
  return comparison;
}

}  // namespace bipot
