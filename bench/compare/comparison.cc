#include "bench/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "bench/compare/comparison_store.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/statistics.h"
#include "bench/measure/stopwatch.h"
#include "bench/measure/true_error.h"
#include "bench/report/build_info.h"
#include "bench/report/labels.h"
#include "core/base/file_error.h"
#include "core/motion/time_stepping.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

/// Adds a judged iteration to a history, unless it is too close to the one before. The newest is
/// always at the end.
class HistoryRecorder {
 public:
  void operator()(const IterationRecord& r) {
    const bool early = r.iteration <= kDense, first = points_.empty();
    if (!first && newest_is_extra_) points_.pop_back();
    newest_is_extra_ = !early && !first && r.iteration < kGrowth * points_.back().iteration;
    points_.push_back({r.iteration, r.seconds, r.error.epsilon, r.error.eta});
  }
  std::vector<Comparison::History::Point> points() const { return points_; }

 private:
  static constexpr int kDense = 32;
  static constexpr double kGrowth = 1.1;
  std::vector<Comparison::History::Point> points_;
  bool newest_is_extra_ = false;
};

struct Measurement {
  Comparison::Row row;
  std::vector<Comparison::History::Point> history;
  Vector s;  ///< impulse of the row; empty: none was found now
};

void write_errors(const TrueErrorEvaluator& true_error, const Vector& s, Comparison::Row& row) {
  const TrueError error = true_error(s);
  row.velocity_error = error.velocity;
  row.force_error = error.force;
  row.contact_force_error = error.contact_force;
  row.penetration_velocity = error.penetration_velocity;
  row.penetration = error.penetration;
  row.dissipated = error.dissipated;
  row.energy_error = error.energy;
  row.answer = error.nearest + 1;
}

Measurement measure(const SolverEntry& entry, const TestProblem& given, double tol, bool warm,
                    const TrueErrorEvaluator& true_error, const Comparison::Options& options) {
  const ContactProblem& problem = given.problem;
  Measurement made;
  Comparison::Row& row = made.row;
  SolverOptions solver;
  solver.tol = tol;
  solver.execution.threads = options.threads;
  if (warm) solver.s0 = given.start;
  solver.cancelled = options.watch.interrupted;
  // The cost of recording is negligible beside the judgements, and only the first repeat is
  // recorded.
  HistoryRecorder recorder;
  solver.on_iteration = [&recorder](const IterationRecord& r) { recorder(r); };
  std::vector<double> setup, solve_time, total, cpu;
  double spent = 0;
  for (int k = 0; k < std::max(1, options.repeat) || spent < options.min_time; ++k) {
    const CpuStopwatch watch;
    SolveResult result = solve_within(entry, problem, solver, options.time_limit);
    cpu.push_back(watch.seconds());
    const bool out_of_time = cpu.back() >= options.time_limit;
    spent += cpu.back();
    setup.push_back(result.setup_seconds);
    solve_time.push_back(result.solve_seconds);
    total.push_back(result.setup_seconds + result.solve_seconds);
    if (k == 0) {
      solver.on_iteration = nullptr;
      if (out_of_time && result.status == SolveStatus::kTimeLimit) {
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
      write_errors(true_error, result.s, row);
      made.s = result.s;
    }
    if (out_of_time || result.status == SolveStatus::kTimeLimit ||
        result.status == SolveStatus::kInterrupted) {
      break;  // more of the same
    }
  }
  row.repeats = static_cast<int>(total.size());
  row.setup_min = *std::ranges::min_element(setup);
  row.setup_median = median(setup);
  row.solve_min = *std::ranges::min_element(solve_time);
  row.solve_median = median(solve_time);
  row.total_min = *std::ranges::min_element(total);
  row.cpu_min = *std::ranges::min_element(cpu);
  return made;
}

/// Makes the rows of one problem, and the problem itself only if one is missing.
class ProblemRows {
 public:
  ProblemRows(const ProblemSource& source, const Comparison::Options& options,
              ComparisonStore& store, const std::string& commit)
      : source_(source), options_(options), store_(store), commit_(commit) {}

  /// `hopeless`: reason why the solver is not tried, empty if it is.
  Measurement make(const SolverEntry& entry, double tol, bool warm, const Comparison::Row* looser,
                   const std::string& hopeless) {
    prepare();
    Measurement made;
    Comparison::Row& row = made.row;
    if (!defect_.empty()) {
      row.status = to_string(SolveStatus::kInvalidInput);
      row.message = defect_;
    } else if (!hopeless.empty()) {
      row.status = Comparison::Row::kNotTried;
      row.message = hopeless;
    } else if (looser != nullptr && entry.path_ignores_tolerance &&
               looser->status == to_string(SolveStatus::kTimeLimit)) {
      row = *looser;
      if (!row.message.starts_with("not run again")) {
        row.message = fmt::format("not run again: out of time at tol {} already ({})",
                                  tolerance_label(looser->tol), looser->message);
      }
    } else {
      made = measure(entry, problem_, tol, warm, *true_error_, options_);
    }
    row.problem = source_.name;
    row.solver = entry.name;
    row.tol = tol;
    row.warm = warm ? 1 : 0;
    row.contacts = problem_.problem.num_contacts();
    row.dim = defect_.empty() ? problem_.problem.dim : 0;
    row.commit = commit_;
    if (made.s.size() > 0 && !options_.watch.stopped()) learn(made);
    return made;
  }

  /// True if answers were found after the errors of some row were measured.
  bool has_stale_errors() const { return learned_; }

  /// Measures the errors of a row again; false if its impulse is not known any more.
  bool renew_errors(Comparison::Row& row) const {
    const auto found = impulses_.find({row.solver, row.tol, row.warm});
    if (found == impulses_.end()) return false;
    write_errors(*true_error_, found->second, row);
    return true;
  }

  /// Makes the problem.
  bool has_start() {
    prepare();
    return problem_.start.size() == problem_.problem.num_rows() && problem_.start.size() > 0;
  }

  /// Without the problem if no row was missing and the reference is kept.
  Comparison::Problem summary() {
    if (!prepared_) {
      // Those of a series are always the same; others are looked at, as their files may have changed.
      const bool same = !source_.series.empty();
      if (auto kept = store_.reference(source_.name); kept && same) {
        reference_ = std::move(*kept);
      } else {
        prepare();
      }
    }
    Comparison::Problem s{.name = source_.name,
                          .target = source_.target,
                          .origin = reference_.origin,
                          .defect = defect_,
                          .series = source_.series,
                          .contacts = reference_.contacts,
                          .dim = reference_.dim,
                          .dofs = reference_.dofs,
                          .reference = reference_};
    if (defect_.empty() && !s.poor_reference())
      s.answers = 1 + static_cast<int>(reference_.others.size());
    s.reference.s.resize(0);
    s.reference.others.clear();
    return s;
  }

 private:
  /// A new answer changes the reference of the errors.
  void learn(const Measurement& made) {
    const Comparison::Row& row = made.row;
    impulses_[{row.solver, row.tol, row.warm}] = made.s;
    if (!learn_answer(problem_.problem, made.s, options_.reference_time_limit,
                      options_.watch.interrupted, reference_)) {
      return;
    }
    learned_ = true;
    reference_.spread = true_error_->spread();
    store_.write(source_, problem_, reference_);
  }

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
    const auto refuse_another = [&](const std::string& why) {
      throw std::invalid_argument(
          fmt::format("{}: problem {} is not the one that the rows there were made for ({}): name "
                      "another folder",
                      options_.out.string(), source_.name, why));
    };
    if (auto kept = store_.reference(source_.name)) {
      if (kept->s.size() != problem_.problem.num_rows()) {
        refuse_another(fmt::format("{} rows, now {}", kept->s.size(), problem_.problem.num_rows()));
      }
      const ProblemMark now = mark_of(problem_.problem);
      if (!kept->mark.fits(now)) {
        refuse_another(fmt::format("{}, now {}", to_string(kept->mark), to_string(now)));
      }
      reference_ = std::move(*kept);
      const double before = reference_.error.guarded();
      reference_.error = contact_error(problem_.problem, reference_.s);
      if (std::isfinite(before) &&
          !(reference_.error.guarded() <= 10 * before + ReferenceSolution::kTarget)) {
        refuse_another(fmt::format("its reference had the error {:.1e}, now {:.1e}", before,
                                   reference_.error.guarded()));
      }
    } else {
      reference_ = find_reference(problem_, options_.reference_time_limit,
                                  ReferenceSolution::kTarget, options_.watch.interrupted);
      reference_.mark = mark_of(problem_.problem);
      true_error_.emplace(problem_, reference_);
      if (reference_.several()) reference_.spread = true_error_->spread();
      if (!options_.watch.stopped()) store_.write(source_, problem_, reference_);
    }
    if (!true_error_) true_error_.emplace(problem_, reference_);
  }

  const ProblemSource& source_;
  const Comparison::Options& options_;
  ComparisonStore& store_;
  const std::string& commit_;
  bool prepared_ = false;
  std::string defect_;
  TestProblem problem_;
  ReferenceSolution reference_;
  std::optional<TrueErrorEvaluator> true_error_;
  /// Impulses of the new rows by solver, tolerance and start.
  std::map<std::tuple<std::string, double, int>, Vector> impulses_;
  bool learned_ = false;
};

/// Records the solvers that ran out of time, and on which problems.
class TimeOuts {
 public:
  void add(const ProblemSource& source, const Comparison::Row& row) {
    if (row.status != to_string(SolveStatus::kTimeLimit)) return;
    seen_.push_back({source.series, row.solver, source.name, source.size, row.tol});
  }

  /// Reason why a solve is hopeless, as text; empty if none is known.
  std::string reason(const ProblemSource& source, const SolverEntry& solver, double tol) const {
    if (solver.name == "auto") return {};
    for (const Seen& s : seen_) {
      if (s.solver != solver.name || s.tol < tol) continue;
      const bool smaller =
          !source.series.empty() && s.series == source.series && s.size < source.size;
      // If the path does not depend on the tolerance, the row is known without a run.
      const bool looser = s.problem == source.name && s.tol > tol && !solver.path_ignores_tolerance;
      if (smaller || looser) {
        return fmt::format("not tried: out of time on {} at tol {}", s.problem,
                           tolerance_label(s.tol));
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

/// Fills the table problem by problem.
class TableFiller {
 public:
  TableFiller(const Comparison::Options& options, std::vector<const SolverEntry*> entries,
              std::vector<double> tols, std::size_t problems)
      : options_(options),
        entries_(std::move(entries)),
        tols_(std::move(tols)),
        total_(
            static_cast<int>(problems * entries_.size() * tols_.size() * (options.warm ? 2 : 1))),
        commit_(build_info().commit),
        store_(options) {}

  /// False if it was interrupted.
  bool fill(const ProblemSource& source) {
    try {
      return fill_problem(source);
    } catch (const Interrupted&) {  // in the run that makes the problem
      return false;
    }
  }

  Comparison& finish() {
    store_.finish();
    return table_;
  }

 private:
  bool fill_problem(const ProblemSource& source) {
    ProblemRows problem(source, options_, store_, commit_);
    const std::size_t first = table_.rows.size(), first_warm = table_.warm_rows.size();
    for (const SolverEntry* entry : entries_) {
      if (!fill_rows(source, problem, *entry, false)) return false;
      if (options_.warm && !fill_rows(source, problem, *entry, true)) return false;
      if (const Comparison::History* history =
              store_.history(source.name, std::string(entry->name))) {
        table_.histories.push_back(*history);
      }
    }
    if (problem.has_stale_errors()) {
      renew_errors(problem, table_.rows, first);
      renew_errors(problem, table_.warm_rows, first_warm);
    }
    table_.problems.push_back(problem.summary());
    return true;
  }

  bool fill_rows(const ProblemSource& source, ProblemRows& problem, const SolverEntry& entry,
                 bool warm) {
    std::vector<Comparison::Row>& rows = warm ? table_.warm_rows : table_.rows;
    TimeOuts& time_outs = warm ? warm_time_outs_ : time_outs_;
    const std::string name(entry.name);
    for (std::size_t k = 0; k < tols_.size(); ++k) {
      if (options_.watch.stopped()) return false;
      if (const Comparison::Row* kept = store_.find(source.name, name, tols_[k], warm)) {
        rows.push_back(*kept);
        ++table_.rows_kept;
      } else {
        if (warm && !problem.has_start()) return true;
        warm_up_once();
        const Comparison::Row* looser = k > 0 ? &rows.back() : nullptr;
        const std::string hopeless =
            options_.try_all ? "" : time_outs.reason(source, entry, tols_[k]);
        Measurement made = problem.make(entry, tols_[k], warm, looser, hopeless);
        if (options_.watch.stopped()) return false;
        Comparison::History history{source.name, name, tols_[k], {}};
        if (!warm) history.points = std::move(made.history);
        store_.append(made.row, history);
        rows.push_back(std::move(made.row));
      }
      time_outs.add(source, rows.back());
      const Comparison::Row& row = rows.back();
      const int done = static_cast<int>(table_.rows.size() + table_.warm_rows.size());
      options_.watch.tell(
          done, total_, fmt::format("{} {} {}", row.problem, row.solver, tolerance_label(row.tol)));
      if (options_.on_row) options_.on_row(row, done, total_);
    }
    return true;
  }

  /// The program warms up before the first measured solve.
  void warm_up_once() {
    if (warmed_up_) return;
    for (const SolverEntry& solver : solver_table()) warm_up(solver);
    warmed_up_ = true;
  }

  /// For the rows from `first` on, in the table and on disk, where the later line counts.
  void renew_errors(const ProblemRows& problem, std::vector<Comparison::Row>& rows,
                    std::size_t first) {
    for (std::size_t i = first; i < rows.size(); ++i) {
      if (problem.renew_errors(rows[i])) store_.append(rows[i], {});
    }
  }

  const Comparison::Options& options_;
  const std::vector<const SolverEntry*> entries_;
  const std::vector<double> tols_;
  const int total_;
  const std::string commit_;
  ComparisonStore store_;
  Comparison table_;
  TimeOuts time_outs_, warm_time_outs_;
  bool warmed_up_ = false;
};

}  // namespace

std::string Comparison::id_of(const Problem& problem) const {
  return fmt::format("p{}", &problem - problems.data() + 1);
}

std::string Comparison::link_to(const Problem& problem) const {
  return fmt::format("[{}](#{})", problem.name, id_of(problem));
}

double Comparison::History::Point::guarded() const {
  ContactError error{.epsilon = epsilon, .eta = eta};
  return error.guarded();
}

Comparison compare(const std::vector<ProblemSource>& sources, const Comparison::Options& options) {
  std::vector<const SolverEntry*> entries;
  for (const std::string& name : options.solvers) entries.push_back(&require_solver(name));
  for (const SolverEntry& entry : options.foreign) {
    if (find_solver(entry.name) != nullptr) {
      throw std::invalid_argument(
          fmt::format("solver '{}' is the name of one of this build: give another", entry.name));
    }
    entries.push_back(&entry);
  }
  for (auto it = entries.begin(); it != entries.end(); ++it) {
    if (std::any_of(entries.begin(), it,
                    [&](const SolverEntry* other) { return other->name == (*it)->name; })) {
      throw std::invalid_argument(fmt::format("solver '{}' is named twice", (*it)->name));
    }
  }
  std::vector<double> tols = options.tols;
  std::ranges::sort(tols, std::greater<>());
  tols.erase(std::unique(tols.begin(), tols.end()), tols.end());
  for (double tol : tols) {
    if (!(tol > 0) || !std::isfinite(tol)) {
      throw std::invalid_argument(fmt::format("tolerance {}, expected a positive number", tol));
    }
  }

  TableFiller filler(options, std::move(entries), std::move(tols), sources.size());
  const bool complete = std::ranges::all_of(
      sources, [&](const ProblemSource& source) { return filler.fill(source); });
  Comparison& table = filler.finish();
  table.complete = complete;
  return std::move(table);
}

}  // namespace bipot
