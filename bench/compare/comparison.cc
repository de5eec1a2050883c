#include "bench/compare/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "bench/measure/cpu_limit.h"
#include "bench/measure/stopwatch.h"
#include "bench/measure/true_error.h"
#include "bench/measure/warm_up.h"
#include "bench/report/build_info.h"
#include "core/file_error.h"
#include "core/files/fclib_file.h"
#include "core/motion/time_stepping.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

std::string key_of(const std::string& problem, const std::string& solver, double tol) {
  return fmt::format("{}|{}|{}", problem, solver, tol);
}

double median(std::vector<double> x) {
  std::sort(x.begin(), x.end());
  const std::size_t half = x.size() / 2;
  return x.size() % 2 == 1 ? x[half] : 0.5 * (x[half - 1] + x[half]);
}

/// A problem's name as a file name.
std::string file_stem(const std::string& name) {
  std::string stem = name;
  for (char& c : stem) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' ||
                       c == '_' || c == '@' || c == '=';
    if (!plain) c = '_';
  }
  return stem;
}

/// What all rows of a folder have in common besides their keys.
nlohmann::ordered_json limits_json(const ComparisonOptions& o) {
  return {{"time_limit", o.time_limit},
          {"reference_time_limit", o.reference_time_limit},
          {"repeat", o.repeat},
          {"min_time", o.min_time},
          {"try_all", o.try_all}};
}

/// The files of a comparison.
class Store {
 public:
  explicit Store(const ComparisonOptions& options) : folder_(options.out) {
    if (folder_.empty()) return;
    std::error_code failed;
    fs::create_directories(folder_ / "references", failed);
    if (!failed) fs::create_directories(folder_ / "problems", failed);
    if (failed) throw FileError(folder_, "", failed.message());
    const fs::path limits = folder_ / "limits.json";
    const nlohmann::ordered_json now = limits_json(options);
    if (std::ifstream in(limits); in) {
      const auto before = nlohmann::ordered_json::parse(in, nullptr, false);
      if (before != now) {
        throw std::invalid_argument(
            fmt::format("{}: rows were made under {}, not {}: name another folder",
                        folder_.string(), before.dump(), now.dump()));
      }
    } else {
      std::ofstream out(limits);
      out << now.dump(2) << '\n';
    }
    const fs::path rows = folder_ / "rows.csv", histories = folder_ / "history.csv";
    if (fs::exists(rows)) {
      for (ComparisonRow& row : read_csv_rows(rows)) {
        const std::string key = key_of(row.problem, row.solver, row.tol);
        rows_.insert_or_assign(key, std::move(row));
      }
    }
    if (fs::exists(histories)) {
      for (History& history : read_csv_histories(histories)) {
        histories_.insert_or_assign({history.problem, history.solver}, std::move(history));
      }
    }
    open(rows, csv_header(), rows_file_);
    open(histories, history_csv_header(), history_file_);
  }

  const ComparisonRow* find(const std::string& problem, const std::string& solver,
                            double tol) const {
    const auto found = rows_.find(key_of(problem, solver, tol));
    return found == rows_.end() ? nullptr : &found->second;
  }

  /// The history before the row: a row that stands in the file has its history.
  void append(const ComparisonRow& row, const History& history) {
    if (!history.points.empty()) histories_[{history.problem, history.solver}] = history;
    if (folder_.empty()) return;
    history_file_ << to_csv(history) << std::flush;
    rows_file_ << to_csv(row) << std::endl;
    if (!rows_file_ || !history_file_) {
      throw FileError(folder_ / "rows.csv", "", "cannot be written");
    }
  }

  const History* history(const std::string& problem, const std::string& solver) const {
    const auto found = histories_.find({problem, solver});
    return found == histories_.end() ? nullptr : &found->second;
  }

  std::optional<ReferenceSolution> reference(const std::string& problem) const {
    const fs::path path = reference_path(problem);
    if (folder_.empty() || !fs::exists(path)) return std::nullopt;
    return read_reference(path);
  }

  void write(const ProblemSource& source, const TestProblem& problem,
             const ReferenceSolution& reference) const {
    if (folder_.empty()) return;
    write_reference(reference_path(source.name), source.name, reference);
    // Problems that come from files are not copied.
    if (fs::exists(source.target) && !source.target.ends_with(".toml")) return;
    if (problem.problem.num_contacts() == 0) return;
    write_fclib(folder_ / "problems" / (file_stem(source.name) + ".hdf5"), problem.problem,
                {.title = source.name, .description = problem.origin});
  }

 private:
  fs::path reference_path(const std::string& problem) const {
    return folder_ / "references" / (file_stem(problem) + ".json");
  }

  /// For appending whole lines. A line that was cut off must not be continued by the next one.
  static void open(const fs::path& path, const std::string& header, std::ofstream& file) {
    if (fs::exists(path)) {
      std::ifstream in(path, std::ios::binary);
      const std::string whole((std::istreambuf_iterator<char>(in)), {});
      in.close();
      if (const std::size_t end = whole.rfind('\n'); end + 1 != whole.size()) {
        fs::resize_file(path, end + 1);
      }
    }
    const bool fresh = !fs::exists(path) || fs::file_size(path) == 0;
    file.open(path, std::ios::app);
    if (fresh) file << header << std::endl;
    if (!file) throw FileError(path, "", "cannot be written");
  }

  fs::path folder_;
  std::map<std::string, ComparisonRow> rows_;
  std::map<std::pair<std::string, std::string>, History> histories_;
  std::ofstream rows_file_, history_file_;
};

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
  ProblemRows(const ProblemSource& source, const ComparisonOptions& options, Store& store,
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
  Store& store_;
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

double HistoryPoint::guarded() const { return std::fmax(epsilon, eta); }

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
  Store store(options);
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
