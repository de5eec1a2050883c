// Siconos' solvers and those of this project in one run, at equal achieved error: CPU seconds of
// one thread, median of --repeat if one run takes less than two seconds, else of one.
//   peer_bench [TARGET...] [--tols=1e-3,1e-4,1e-6] [--solvers=auto,pgs,ipm]
//              [--variants=planar,frozen10,frozen20,frozen100,newton,hybrid,projection,quartic,
//                          nsn_ac,admm]
//              [--repeat=5] [--map-only] [--time-limit=60] [--csv=FILE]
// Targets are those of `bipot compare` (families, problem files); by default lattices and a
// pyramid.
//
// Each variant goes to --tols by its own measure, from s = 0, with as many iterations as fit into
// --time-limit. All but the last two are NSGS. Its results are judged twice: by the shared
// criterion (max(ε, η)) and by the natural map in Siconos' own normalisation
// (bench/measure/peer_map.h). A solver of this project is
// compared at the error that the planar NSGS reached. If that missed its tolerance, it is compared
// with the quickest variant that did not, and the ratio to the planar one is a lower bound. The two
// comparisons:
//   map    at the loosest tolerance of a quarter-decade ladder whose natural map is no larger,
//   ε, η   at that max(ε, η) as its tolerance.
// Siconos' clock begins when W is stored in its blocks; this project's includes set-up and judging.
// The last columns divide the ratio to Siconos 4.4 by the gain of its newest release in a sweep:
// derived, not measured here.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/command/blas_kernels.h"
#include "bench/measure/limited_solve.h"
#include "bench/measure/peer_map.h"
#include "bench/measure/problem_target.h"
#include "bench/measure/statistics.h"
#include "bench/measure/stopwatch.h"
#include "bench/report/build_info.h"
#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/criterion/contact_error.h"
#include "core/files/atomic_file.h"
#include "core/problem/delassus.h"
#include "solvers/registry.h"
#ifdef BIPOT_WITH_SICONOS
#include "solvers/methods/siconos.h"
#endif

namespace bipot {
namespace {

struct Flags {
  std::vector<std::string> targets{"square:50", "square:100", "triangular:30", "triangular:100",
                                   "pyramid:20:mu=0.5"};
  std::vector<double> tols{1e-3, 1e-4, 1e-6};
  std::vector<std::string> solvers{"auto", "pgs", "ipm"};
  std::vector<std::string> variants{"planar", "frozen10", "frozen20",  "frozen100",
                                    "newton", "hybrid",   "projection"};
  int repeat = 5;
  bool map_only = false;  ///< no rows at equal (ε, η)
  double time_limit = 60;
  std::string csv;
};

// Gain of the newest Siconos (2026.rc1) over 4.4 in a sweep, plain and with freezing. The largest
// of each, so that a derived ratio is a lower bound.
constexpr double kNewestGain = 3.4, kNewestFrozenGain = 4.5;
// Longer runs are measured once.
constexpr double kLongRun = 2;

#ifdef BIPOT_WITH_SICONOS

struct Variant {
  const char* name;
  SiconosCall::Algorithm algorithm;
  int freezing;
};
constexpr Variant kVariants[] = {{"planar", SiconosCall::Algorithm::kPlanar, 0},
                                 {"frozen10", SiconosCall::Algorithm::kPlanar, 10},
                                 {"frozen20", SiconosCall::Algorithm::kPlanar, 20},
                                 {"frozen100", SiconosCall::Algorithm::kPlanar, 100},
                                 {"newton", SiconosCall::Algorithm::kNewton, 0},
                                 {"hybrid", SiconosCall::Algorithm::kNewtonAndProjection, 0},
                                 {"projection", SiconosCall::Algorithm::kProjection, 0},
                                 {"quartic", SiconosCall::Algorithm::kQuartic, 0},
                                 {"nsn_ac", SiconosCall::Algorithm::kAlartCurnier, 0},
                                 {"admm", SiconosCall::Algorithm::kAdmm, 0}};

/// One line of the table.
struct Row {
  std::string problem;
  int contacts = 0;
  double tol = 0;
  std::string who;      ///< a variant, or a solver with its comparison
  double asked = kNaN;  ///< tolerance given to it
  bool met = false;
  long iterations = 0;
  double seconds = kNaN;
  int runs = 0;
  double map = kNaN, guarded = kNaN;
  double planar = kNaN, best = kNaN;  ///< seconds of Siconos over these, lines of this project only
};

/// Median CPU seconds of `repeat` runs, or of one long run.
template <class Run>
double median_seconds(int repeat, int& runs, const Run& run) {
  std::vector<double> seconds;
  do {
    const CpuStopwatch watch;
    run();
    seconds.push_back(watch.seconds());
  } while (static_cast<int>(seconds.size()) < repeat && seconds.front() < kLongRun);
  runs = static_cast<int>(seconds.size());
  return median(seconds);
}

class Bench {
 public:
  explicit Bench(const Flags& flags) : flags_(flags) {}

  std::vector<Row> rows;

  void measure(const ProblemSource& source) {
    ContactProblem p = source.load().problem;
    if (p.num_contacts() == 0) throw std::invalid_argument(source.name + " has no contacts");
    ContactProblem with = p;  // the problem as given to Siconos
    if (!with.has_delassus()) with.W = assemble_delassus(p.A, p.H, p.dim);
    for (const double tol : flags_.tols) {
      const std::size_t first = rows.size();
      for (const Variant& v : kVariants) {
        if (std::ranges::find(flags_.variants, v.name) == flags_.variants.end()) continue;
        if (v.algorithm == SiconosCall::Algorithm::kPlanar && p.dim > 2) continue;
        rows.push_back(siconos_row(with, source.name, v, tol));
        print(rows.back());
      }
      hold_against(p, source.name, tol, first);
    }
  }

  static void print_head() {
    fmt::print(
        "CPU seconds of one thread; map: natural map as Siconos scales it; max(ε, η): the shared "
        "criterion\n\n");
    fmt::print(
        "| problem | contacts | Siconos' tol | who | asked | iterations | CPU s (runs) | map | "
        "max(ε, η) | planar / this | best / this | newest / this, derived | newest frozen / this, "
        "derived |\n");
    fmt::print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  }

 private:
  Row siconos_row(const ContactProblem& p, const std::string& name, const Variant& v, double tol) {
    Row row{.problem = name, .contacts = p.num_contacts(), .tol = tol};
    row.who = std::string("Siconos ") + v.name;
    row.asked = tol;
    SiconosCall call(p, v.algorithm, v.freezing);
    // A call cannot be interrupted: the cost of its iterations is measured first.
    const CpuStopwatch trial;
    constexpr int kTrial = 100;
    call.run(tol, kTrial);
    const double one = std::max(trial.seconds() / std::max(call.iterations(), 1), 1e-9);
    const int most = static_cast<int>(std::min(flags_.time_limit / one, 1e9));
    if (!call.impulse().allFinite()) {  // it would continue to the limit
      row.iterations = call.iterations();
      row.seconds = trial.seconds();
      row.runs = 1;
      return row;
    }
    row.seconds = median_seconds(flags_.repeat, row.runs,
                                 [&] { row.met = call.run(tol, std::max(most, 1)); });
    row.iterations = call.iterations();
    judge(p, call.impulse(), row);
    return row;
  }

  void judge(const ContactProblem& p, const Vector& s, Row& row) {
    const bool whole = s.size() == p.num_rows() && s.allFinite();
    row.map = whole ? peer_natural_map(p, s) : kNaN;
    row.guarded = whole ? contact_error(p, s).guarded() : kNaN;
  }

  /// Adds the lines of this project that compare with the rows from `first` on.
  void hold_against(const ContactProblem& p, const std::string& name, double tol,
                    std::size_t first) {
    const Row* peer = nullptr;  // the planar NSGS, else the quickest variant that met its tolerance
    double planar = kNaN, best = kInfinity;
    for (std::size_t k = first; k < rows.size(); ++k) {
      const Row& row = rows[k];
      if (row.who == "Siconos planar") planar = row.seconds;
      if (!row.met) continue;
      if (row.who == "Siconos planar" || peer == nullptr ||
          (peer->who != "Siconos planar" && row.seconds < peer->seconds)) {
        peer = &row;
      }
      best = std::min(best, row.seconds);
    }
    if (peer == nullptr) {
      fmt::print("| {} | {} | {:.0e} | no variant met it in {:g} s | | | | | | | | | |\n", name,
                 p.num_contacts(), tol, flags_.time_limit);
      return;
    }
    const double map = peer->map, guarded = peer->guarded;  // rows grows below
    for (const std::string& solver : flags_.solvers) {
      for (const bool by_map : {true, false}) {
        if (!by_map && flags_.map_only) continue;
        Row row{.problem = name, .contacts = p.num_contacts(), .tol = tol};
        row.who = solver + (by_map ? " (map)" : " (ε, η)");
        row.asked = by_map ? asked_for_map(p, solver, map, guarded) : std::max(guarded, 1e-15);
        own_row(p, solver, by_map ? map : kInfinity, row);
        if (row.met) {
          row.planar = planar / row.seconds;
          row.best = best / row.seconds;
        }
        rows.push_back(row);
        print(row);
      }
    }
  }

  /// The loosest tolerance of the ladder whose answer has a natural map of at most `map`; if none
  /// has, the tightest one tried.
  double asked_for_map(const ContactProblem& p, const std::string& solver, double map,
                       double guarded) {
    const double quarter = std::pow(10, 0.25);
    const auto rung = [&](int k) { return std::pow(quarter, k); };
    const auto reaches = [&](int k) {
      const SolveResult r =
          solve_within(require_solver(solver), p, {.tol = rung(k)}, flags_.time_limit);
      return is_success(r.status) && peer_natural_map(p, r.s) <= map;
    };
    constexpr int kTightest = -60, kLoosest = 0;
    const double begin = std::isfinite(guarded) && guarded > 0 ? guarded : map;
    int k = std::clamp(static_cast<int>(std::floor(4 * std::log10(begin))), kTightest, kLoosest);
    if (reaches(k)) {
      while (k < kLoosest && reaches(k + 1)) ++k;
    } else {
      // A decade at a time, then back up.
      while (k > kTightest) {
        const int tighter = std::max(k - 4, kTightest);
        const SolveResult r =
            solve_within(require_solver(solver), p, {.tol = rung(tighter)}, flags_.time_limit);
        k = tighter;
        if (!is_success(r.status)) return rung(k);
        if (peer_natural_map(p, r.s) <= map) break;
      }
      for (int up = 0; up < 3 && reaches(k + 1); ++up) ++k;
    }
    return rung(k);
  }

  void own_row(const ContactProblem& p, const std::string& solver, double map, Row& row) {
    SolveResult r;
    row.seconds = median_seconds(flags_.repeat, row.runs, [&] {
      r = solve_within(require_solver(solver), p, {.tol = row.asked}, flags_.time_limit);
    });
    row.iterations = r.iterations;
    judge(p, r.s, row);
    row.met = is_success(r.status) && row.map <= map;
  }

  static void print(const Row& r) {
    const auto ratio = [](double x) {
      return std::isfinite(x) ? fmt::format("{:.3g}", x) : std::string("–");
    };
    fmt::print(
        "| {} | {} | {:.0e} | {} | {:.1e} | {} | {}{:.4f} ({}) | {:.1e} | {:.1e} | {} | {} | {} | "
        "{} |\n",
        r.problem, r.contacts, r.tol, r.who, r.asked, r.iterations, r.met ? "" : "**not met** ",
        r.seconds, r.runs, r.map, r.guarded, ratio(r.planar), ratio(r.best),
        ratio(r.planar / kNewestGain), ratio(r.planar / kNewestFrozenGain));
    std::fflush(stdout);
  }

  const Flags& flags_;
};

void write_csv(const std::vector<Row>& rows, const std::string& path) {
  std::string text =
      "problem,contacts,siconos_tol,who,asked,met,iterations,cpu_s,runs,map,guarded,planar_over_this,best_over_this\n";
  for (const Row& r : rows) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_text(r.problem), r.contacts,
                        r.tol, csv_text(r.who), r.asked, r.met ? 1 : 0, r.iterations, r.seconds,
                        r.runs, r.map, r.guarded, r.planar, r.best);
  }
  write_text_file(path, text);
}

int run(const Flags& flags) {
  require_solvers(flags.solvers);
  for (const std::string& name : flags.variants) find_named("variant", name, kVariants);
  const std::vector<ProblemSource> sources = expand_targets(flags.targets);
  const BuildInfo build = build_info();
  fmt::print("bipot {} ({}), {}, {} cores\n", build.version, build.commit, build.cpu, build.cores);
  Bench::print_head();
  Bench bench(flags);
  for (const ProblemSource& source : sources) bench.measure(source);
  if (!flags.csv.empty()) write_csv(bench.rows, flags.csv);
  return 0;
}

#else

int run(const Flags&) {
  throw std::invalid_argument(
      "built without Siconos: nothing to compare with. Install libsiconos-numerics-dev and "
      "configure with -DBIPOT_WITH_SICONOS=ON");
}

#endif

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  using namespace bipot;
  Flags flags;
  CLI::App app{"Siconos' solvers and this project's at equal achieved error"};
  app.add_option("target", flags.targets, "Problems, as `bipot compare` takes them");
  app.add_option("--tols", flags.tols, "Tolerances that Siconos is given")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--solvers", flags.solvers, "Solvers of this project")->delimiter(',');
  app.add_option("--variants", flags.variants,
                 "planar, frozen10, frozen20, frozen100, newton, hybrid, projection, quartic, "
                 "nsn_ac, admm")
      ->delimiter(',');
  app.add_option("--repeat", flags.repeat, "Runs of a row, the median counts")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--map-only", flags.map_only, "Compare at equal natural map alone");
  app.add_option("--time-limit", flags.time_limit, "CPU seconds of one run")
      ->check(CLI::PositiveNumber);
  app.add_option("--csv", flags.csv, "The rows as CSV")->type_name("FILE");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    return run(flags);
  } catch (const FileError& e) {
    fmt::print(stderr, "peer_bench: {}\n", e.what());
    return 4;
  } catch (const std::exception& e) {
    fmt::print(stderr, "peer_bench: {}\n", e.what());
    return 2;
  }
}
