#include "bench/tune/measure_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "bench/measure/limited_solve.h"
#include "bench/measure/stopwatch.h"
#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/motion/time_stepping.h"
#include "solvers/auto/auto_plan.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// Powers: sweeps carry a force over a packing in about N^p iterations; factorisations do not grow.
constexpr struct {
  std::string_view solver, parameters;
  double power;
} kVariants[] = {{"uzawa", "", 1},
                 {"classical", "", 1},
                 {"pgs", "", 1},
                 {"apgd", "", 0.5},
                 {"apgd", "map=followed hold=64", 0.5},
                 {"assor", "", 0.4},
                 {"anderson", "", 0.5},
                 {"assor", "sweeps=4 most_sweeps=4", 0.4},
                 {"admm", "", 0.4},
                 {"admm", "rho=0.01", 0.4},
                 {"homotopy", "", 1},
                 {"homotopy", "start_tol=1", 1}};

// constant      value  unit         reason
// kEnough       0.3    CPU seconds  longer solves are measured once, others until that is spent
// kMostRepeats  20     solves       at most
constexpr double kEnough = 0.3;
constexpr int kMostRepeats = 20;

/// Steps of one scene share their name up to the @, files of one scene up to the last number.
std::string scene_of(const ProblemSource& source) {
  if (source.target.find(':') != std::string::npos) return source.target;
  std::string name = source.name.substr(0, source.name.rfind('@'));
  if (name != source.name) return name;
  while (!name.empty() &&
         (std::isdigit(static_cast<unsigned char>(name.back())) || name.back() == '_')) {
    name.pop_back();
  }
  return name.empty() ? source.name : name;
}

/// One problem from one start.
class ProblemMeasurement {
 public:
  ProblemMeasurement(const ProblemSource& source, const MeasureOptions& options,
                     const TestProblem& given, bool warm)
      : source_(source), options_(options), given_(given), warm_(warm) {}

  /// Rows at these tolerances, from loose to tight. Interrupted: none.
  std::vector<MeasuredRow> rows(const std::string& variant, const std::vector<double>& tols) {
    const std::string solver = variant.substr(0, variant.find(' '));
    const SolverEntry& entry = require_solver(solver);
    warm_up(entry);
    std::vector<MeasuredRow> made;
    if (entry.path_ignores_tolerance) {
      if (!least_of_some(entry, variant, tols, made)) made.clear();
      return made;
    }
    bool hopeless = false;
    for (const double tol : tols) {
      MeasuredRow row = made.empty() ? blank(variant) : made.back();
      row.traits.tol = tol;
      if (hopeless) {
        made.push_back(row);
        continue;
      }
      std::vector<MeasuredRow> one;
      if (!least_of_some(entry, variant, {tol}, one)) return {};
      made.push_back(one.front());
      hopeless = !one.front().solved;
    }
    return made;
  }

 private:
  MeasuredRow blank(const std::string& variant) const {
    return {.problem = source_.name,
            .scene = scene_of(source_),
            .traits = traits_,
            .mark = mark_,
            .variant = variant,
            .limit = options_.time_limit};
  }

  /// Short solves are repeated, and the least times count: the first one warms caches up.
  bool least_of_some(const SolverEntry& entry, const std::string& variant,
                     const std::vector<double>& tols, std::vector<MeasuredRow>& made) {
    if (!once(entry, variant, tols, made)) return false;
    double spent = made.back().seconds;
    for (int repeat = 1; repeat < kMostRepeats && spent < kEnough; ++repeat) {
      std::vector<MeasuredRow> again;
      if (!once(entry, variant, tols, again)) return false;
      spent += again.back().seconds;
      for (std::size_t k = 0; k < made.size(); ++k) {
        made[k].seconds = std::min(made[k].seconds, again[k].seconds);
      }
    }
    return true;
  }

  /// One solve to the last of the tolerances. False: interrupted.
  bool once(const SolverEntry& entry, const std::string& variant, const std::vector<double>& tols,
            std::vector<MeasuredRow>& made) {
    SolverOptions options{.tol = tols.back()};
    if (warm_) options.s0 = given_.start;
    options.parameters = stage_parameters(
        variant.find(' ') == std::string::npos ? "" : variant.substr(variant.find(' ') + 1));
    options.cancelled = options_.watch.interrupted;
    const CpuStopwatch watch;
    std::vector<std::pair<int, double>> reached(tols.size(), {-1, 0.0});
    options.on_iteration = [&](const IterationRecord& r) {
      for (std::size_t k = 0; k < tols.size(); ++k) {
        if (reached[k].first < 0 && r.error.guarded() <= tols[k]) {
          reached[k] = {r.iteration, watch.seconds()};
        }
      }
    };
    const SolveResult result = solve_within(entry, given_.problem, options, options_.time_limit);
    const double seconds = watch.seconds();
    if (options_.watch.stopped()) return false;
    for (std::size_t k = 0; k < tols.size(); ++k) {
      MeasuredRow row = blank(variant);
      row.traits.tol = tols[k];
      row.solved = result.error.guarded() <= tols[k];
      const bool earlier = row.solved && reached[k].first >= 0 && k + 1 < tols.size();
      row.iterations = std::max(1, earlier ? reached[k].first : result.iterations);
      row.seconds = earlier ? reached[k].second : seconds;
      made.push_back(row);
    }
    return true;
  }

  const ProblemSource& source_;
  const MeasureOptions& options_;
  const TestProblem& given_;
  const bool warm_;
  const ProblemMark mark_ = mark_of(given_.problem);
  const ProblemTraits traits_ = traits_of(given_.problem, DelassusOperator(given_.problem),
                                          {.tol = 1,
                                           .s0 = warm_ ? given_.start : Vector(),
                                           // The plan is to serve runs too.
                                           .parameters = {{"forces", "spread"}}});
};

/// Throws std::invalid_argument where rows of that name were measured on another problem.
void require_same(const std::vector<MeasuredRow>& rows, const ProblemSource& source,
                  const ContactProblem& p, const std::filesystem::path& file) {
  const ProblemMark now = mark_of(p);
  for (const MeasuredRow& row : rows) {
    const ProblemTraits& then = row.traits;
    const bool same =
        then.contacts == p.num_contacts() && then.dim == p.plain_dim() && row.mark.fits(now);
    if (row.problem != source.name || same) continue;
    throw std::invalid_argument(fmt::format(
        "{}: its rows of {} are of another problem ({} contacts, d = {}; now {}, {}): name another "
        "file by --rows",
        file.string(), source.name, then.contacts, then.dim, p.num_contacts(), p.plain_dim()));
  }
}

/// Without contacts where the run of its scene fails before, or is interrupted.
TestProblem loaded(const ProblemSource& source, const MeasureOptions& options) {
  try {
    return source.load();
  } catch (const Interrupted&) {
    return {};
  } catch (const StepFailure& e) {
    if (options.warn) options.warn(fmt::format("{} is left out: {}", source.name, e.what()));
    return {};
  }
}

bool can_run(const std::string& variant, const ContactProblem& p) {
  const SolverEntry& entry = require_solver(variant.substr(0, variant.find(' ')));
  return beyond_solver(entry, p).empty();
}

}  // namespace

std::string instance_of(const MeasuredRow& row) {
  return fmt::format("{} {} {:g}", row.problem, (row.traits.marks & kWarm) ? "warm" : "cold",
                     row.traits.tol);
}

std::string measured_csv_header() {
  return "problem,scene,contacts,dim,tol,properties,variant,iterations,seconds,solved,limit,"
         "velocity,friction,mobility";
}

std::string to_csv(const MeasuredRow& row) {
  return fmt::format("{},{},{},{},{:g},{},{},{},{:.6g},{},{:g},{:.9g},{:.9g},{:.9g}\n",
                     csv_text(row.problem), csv_text(row.scene), row.traits.contacts,
                     row.traits.dim, row.traits.tol, csv_text(mark_words(row.traits.marks)),
                     csv_text(row.variant), row.iterations, row.seconds, row.solved ? 1 : 0,
                     row.limit, row.mark.velocity, row.mark.friction, row.mark.mobility);
}

std::vector<MeasuredRow> read_measured_rows(const std::filesystem::path& path) {
  std::vector<MeasuredRow> rows;
  if (!std::filesystem::exists(path)) return rows;
  for (const auto& fields : read_csv_table(path, measured_csv_header(), 14)) {
    const auto value = [&](std::size_t k) { return csv_number<double>(fields[k], path); };
    MeasuredRow& row = rows.emplace_back();
    row.problem = fields[0];
    row.scene = fields[1];
    row.traits.contacts = static_cast<int>(value(2));
    row.traits.dim = static_cast<int>(value(3));
    row.traits.tol = value(4);
    row.traits.marks = marks_of_words(fields[5]);
    row.variant = fields[6];
    row.iterations = static_cast<int>(value(7));
    row.seconds = value(8);
    row.solved = value(9) != 0;
    row.limit = value(10);
    row.mark = {value(11), value(12), value(13)};
  }
  return rows;
}

std::vector<TunedVariant> tuned_variants(const std::vector<std::string>& solvers) {
  require_solvers(solvers);
  std::vector<TunedVariant> made;
  for (const std::string& name : solvers.empty() ? solver_names() : solvers) {
    if (name == "auto" || (solvers.empty() && name.find(':') != std::string::npos)) continue;
    bool listed = false;
    for (const auto& [solver, parameters, power] : kVariants) {
      if (name != solver) continue;
      listed = true;
      made.push_back({parameters.empty() ? name : fmt::format("{} {}", name, parameters), power});
    }
    if (!listed) made.push_back({name, 0});
  }
  if (made.empty()) throw std::invalid_argument("solvers: a plan is made of others than auto");
  return made;
}

std::vector<MeasuredRow> measure_rows(const std::vector<ProblemSource>& sources,
                                      const MeasureOptions& options) {
  std::vector<MeasuredRow> rows = read_measured_rows(options.file);
  std::set<std::string> known;
  const auto key = [](const std::string& instance, const std::string& variant) {
    return instance + " " + variant;
  };
  std::set<std::string> problems;
  for (const MeasuredRow& row : rows) {
    problems.insert(row.problem);
    if (row.solved || row.limit >= options.time_limit) {
      known.insert(key(instance_of(row), row.variant));
    }
  }
  std::ofstream file = open_csv_table(options.file, measured_csv_header());
  std::vector<double> tols = options.tols;
  std::ranges::sort(tols, std::greater<>());
  tols.erase(std::unique(tols.begin(), tols.end()), tols.end());
  std::vector<std::string> variants{"auto"};
  for (const TunedVariant& variant : options.variants) variants.push_back(variant.name);
  const int total = static_cast<int>(sources.size() * 2 * variants.size());
  int done = 0;
  for (const ProblemSource& source : sources) {
    std::optional<TestProblem> given;
    if (problems.contains(source.name)) {
      given = loaded(source, options);
      if (given->problem.num_contacts() > 0)
        require_same(rows, source, given->problem, options.file);
    }
    for (const bool warm : {false, true}) {
      for (const std::string& variant : variants) {
        ++done;
        std::vector<double> missing;
        MeasuredRow row;
        row.problem = source.name;
        row.traits.marks = warm ? kWarm : kCold;
        for (const double tol : tols) {
          row.traits.tol = tol;
          if (!known.contains(key(instance_of(row), variant))) missing.push_back(tol);
        }
        if (missing.empty()) continue;
        if (options.watch.stopped()) return rows;
        if (!given) given = loaded(source, options);
        const bool has_start = given->start.size() > 0 && !given->start.isZero(0);
        if ((warm && !has_start) || given->problem.num_contacts() == 0 ||
            !can_run(variant, given->problem)) {
          continue;
        }
        ProblemMeasurement measurement(source, options, *given, warm);
        for (const MeasuredRow& made : measurement.rows(variant, missing)) {
          file << to_csv(made);
          rows.push_back(made);
        }
        file << std::flush;
        if (!file) throw FileError(options.file, "", "cannot be written");
        options.watch.tell(done, total, source.name + " " + variant);
      }
    }
  }
  return rows;
}

}  // namespace bipot
