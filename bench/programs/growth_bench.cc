// Growth of iterations, CPU seconds of each phase of a step and memory with the number of disks N,
// on one page. Scenes: a lattice (triangular, tilted by 10°), a settled pile (three sizes, brought
// to rest by a run first) and a step of a pour. All start cold and go to --tol by --solver. Power
// laws have their 95 % confidence. Writes index.html and rows.csv into --out and prints the tables
// in Markdown.
//   growth_bench [--sizes=100,316,...,1000000] [--pile-sizes=...] [--pour-sizes=...]
//                [--solver=auto] [--tol=1e-6] [--time-limit=120] [--fit-from=1000]
//                [--threads=1] [--out=out/growth]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "bench/command/blas_kernels.h"
#include "bench/measure/iteration_growth.h"
#include "bench/problems/settled_pile.h"
#include "bench/report/chart.h"
#include "bench/report/document.h"
#include "bench/report/labels.h"
#include "core/base/release.h"
#include "core/criterion/contact_error.h"
#include "core/files/atomic_file.h"
#include "core/motion/midpoint.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

struct Flags {
  std::vector<double> sizes{100, 316, 1000, 3162, 10000, 31623, 100000, 316228, 1000000};
  std::vector<double> pile_sizes{100, 316, 1000, 3162, 10000}, pour_sizes{100, 316, 1000, 3162};
  std::string solver = "auto", out = "out/growth";
  double tol = 1e-6, time_limit = 120, fit_from = 1000;
  int threads = 1;
};

/// A measured quantity of a row against the number of disks.
struct Quantity {
  const char* name;
  const char* unit;
};
constexpr Quantity kQuantities[] = {
    {"iterations", ""}, {"detection", "s"}, {"assembly", "s"},         {"criterion", "s"},
    {"set-up", "s"},    {"solve", "s"},     {"set-up and solve", "s"}, {"memory", "kB"}};
constexpr int kCount = static_cast<int>(std::size(kQuantities));
enum { kIterations, kDetection, kAssembly, kCriterion, kSetup, kSolve, kWhole, kMemory };

struct Row {
  std::string family;
  double bodies = 0;
  int contacts = 0;
  bool met = false;
  std::string status;
  double error = kNaN;
  double value[kCount];  ///< NaN: not measured
};

/// Median CPU seconds of one call, over the calls within 0.05 s, at least three.
double seconds_of(const std::function<void()>& call) {
  std::vector<double> seconds;
  double sum = 0;
  while (seconds.size() < 3 || (sum < 0.05 && seconds.size() < 100)) {
    const std::clock_t before = std::clock();
    call();
    seconds.push_back(static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    sum += seconds.back();
  }
  return median(seconds);
}

/// A line of /proc/self/status [kB]; NaN if the system has none.
double status_line(const std::string& name) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    double kilobytes = 0;
    if (word == name + ":" && file >> kilobytes) return kilobytes;
  }
  return kNaN;
}

/// Largest memory in use from construction on.
class MemoryPeak {
 public:
  MemoryPeak() {
    return_freed_memory();  // returns memory that earlier rows have freed
    std::ofstream reset("/proc/self/clear_refs");
    reset << 5;  // resets the peak to the memory in use
    reset.close();
    before_ = reset ? status_line("VmRSS") : kNaN;
  }
  double kilobytes() const { return status_line("VmHWM") - before_; }

 private:
  double before_;
};

void measure_solve(const ContactProblem& problem, const Flags& flags, Row& row) {
  row.contacts = problem.num_contacts();
  {
    ContactErrorEvaluator evaluate(problem, flags.threads);
    const Vector zero = Vector::Zero(problem.num_rows());
    row.value[kCriterion] = seconds_of([&] { (void)evaluate(zero); });
  }
  SolverOptions options{
      .tol = flags.tol, .max_iterations = 1000000000, .time_limit = flags.time_limit};
  options.execution.threads = flags.threads;
  const SolveResult result = solve(flags.solver, problem, options);
  row.met = is_success(result.status);
  row.status = to_string(result.status);
  row.error = result.error.guarded();
  row.value[kIterations] = result.iterations;
  row.value[kSetup] = result.setup_seconds;
  row.value[kSolve] = result.solve_seconds;
  row.value[kWhole] = result.setup_seconds + result.solve_seconds;
}

Row empty_row(const std::string& family) {
  Row row;
  row.family = family;
  std::fill(std::begin(row.value), std::end(row.value), kNaN);
  return row;
}

/// All phases for a scene at a state.
Row scene_row(const std::string& family, const Scene<2>& scene, const State<2>& state,
              const Flags& flags) {
  Row row = empty_row(family);
  row.bodies = static_cast<double>(scene.bodies.size());
  const MemoryPeak memory;
  row.value[kDetection] = seconds_of([&] { (void)make_midpoint(scene, state, flags.threads); });
  const Midpoint<2> mid = make_midpoint(scene, state, flags.threads);
  row.value[kAssembly] = seconds_of([&] { (void)assemble_step(scene, mid, false, flags.threads); });
  const AssembledStep step = assemble_step(scene, mid, false, flags.threads);
  measure_solve(step.problem, flags, row);
  row.value[kMemory] = memory.kilobytes();
  return row;
}

Row lattice_row(double disks, const Flags& flags) {
  const Scene<2> scene = make_family_scene("triangular", side_of("triangular", disks),
                                           {.mu = 0.3, .tilt_degrees = 10});
  return scene_row("lattice", scene, initial_state(scene), flags);
}

Row pile_row(double disks, const Flags& flags) {
  const SettledPile pile = settle_pile({.count = static_cast<int>(disks)});
  return scene_row("pile", pile.scene, pile.state, flags);
}

Row pour_row(double disks, const Flags& flags) {
  const GrowthProblem made =
      make_growth_problem({.family = "pour"}, static_cast<int>(std::lround(std::sqrt(disks))));
  Row row = empty_row("pour");
  row.bodies = static_cast<double>(made.bodies);
  const MemoryPeak memory;
  measure_solve(made.problem, flags, row);
  row.value[kMemory] = memory.kilobytes();
  return row;
}

/// Seconds and counts: three digits, "–" if undefined.
std::string number(double x) { return std::isfinite(x) ? fmt::format("{:.3g}", x) : "–"; }

PowerLaw law(const std::vector<Row>& rows, const std::string& family, int quantity,
             double fit_from) {
  std::vector<double> x, y;
  for (const Row& row : rows) {
    if (row.family != family || row.bodies < fit_from || !row.met) continue;
    x.push_back(row.bodies);
    y.push_back(row.value[quantity]);
  }
  return fit_power_law(x, y);
}

Table table_of(const std::vector<Row>& rows) {
  Table t{.columns = {{"scene", "scene"},
                      {"disks", "disks", count_label},
                      {"contacts", "contacts", count_label},
                      {"status", ""},
                      {"error", "error", error_label}}};
  for (const Quantity& q : kQuantities) t.columns.push_back({q.name, q.name, number, q.unit});
  t.columns.push_back({"", "bytes a disk", number});
  for (const Row& row : rows) {
    TableCell error(row.error);
    if (!row.met) error.shown(fmt::format("{}: {:.1e}", row.status, row.error));
    std::vector<TableCell> cells{row.family, row.bodies, row.contacts, row.status, error};
    for (const double value : row.value) cells.emplace_back(value);
    cells.emplace_back(1024 * row.value[kMemory] / row.bodies);
    t.add(std::move(cells), row.met ? "" : "bad");
  }
  return t;
}

Table exponents_of(const std::vector<Row>& rows, const std::vector<std::string>& families,
                   double fit_from) {
  Table t{.columns = {{"", "exponent of"}}};
  for (const std::string& family : families) t.columns.push_back({"", family, number});
  for (int q = 0; q < kCount; ++q) {
    std::vector<TableCell> cells{kQuantities[q].name};
    for (const std::string& family : families) {
      cells.emplace_back(to_text(law(rows, family, q, fit_from)));
    }
    t.add(std::move(cells));
  }
  return t;
}

/// The quantities of a family, log-log, with their power laws as lines.
Chart chart_of(const std::vector<Row>& rows, const std::string& family, std::vector<int> which,
               const std::string& y, double fit_from) {
  Chart chart;
  chart.title = fmt::format("{}: {} against the number of disks", family, y);
  chart.x = {.label = "disks (" + family + ")", .kind = ChartAxis::Kind::kLog};
  chart.y = {.label = y, .kind = ChartAxis::Kind::kLog};
  int style = 0;
  for (const int q : which) {
    ChartSeries points{
        .name = kQuantities[q].name, .style = style++, .kind = ChartSeries::Kind::kPoints};
    for (const Row& row : rows) {
      if (row.family != family || !(row.value[q] > 0)) continue;
      points.points.push_back({.x = row.bodies, .y = row.value[q], .hollow = !row.met});
    }
    const PowerLaw fit = law(rows, family, q, fit_from);
    if (std::isfinite(fit.exponent)) {
      points.name += fmt::format(", N^{:.2f}", fit.exponent);
      ChartSeries line{.name = "", .style = points.style, .kind = ChartSeries::Kind::kLine};
      for (const ChartPoint& p : points.points) {
        if (p.x >= fit_from) {
          line.points.push_back({.x = p.x, .y = fit.prefactor * std::pow(p.x, fit.exponent)});
        }
      }
      chart.series.push_back(std::move(line));
    }
    if (!points.points.empty()) chart.series.push_back(std::move(points));
  }
  return chart;
}

void write_page(const std::vector<Row>& rows, const std::vector<std::string>& families,
                const Flags& flags) {
  Document page{.title = "Growth with the number of disks",
                .made = provenance("growth_bench", "growth_bench")};
  page.made.threads = flags.threads;
  page.say(fmt::format(
      "`{}` from s = 0 to a guarded error of {:.0e}, {} thread{}, {} s at most. Lines are power "
      "laws fitted from {:.0f} disks on, to problems that met the tolerance; hollow points did "
      "not. Detection, assembly and one criterion are medians; memory is the largest in use above "
      "what was in use before the step.",
      flags.solver, flags.tol, flags.threads, flags.threads == 1 ? "" : "s", flags.time_limit,
      flags.fit_from));
  const auto figure = [&](const std::string& family, std::vector<int> which, const std::string& y) {
    page.add(Figure{.chart = chart_of(rows, family, std::move(which), y, flags.fit_from)});
  };
  for (const std::string& family : families) {
    figure(family, {kIterations}, "iterations");
    figure(family, {kDetection, kAssembly, kCriterion, kSetup, kSolve}, "seconds of a phase");
    figure(family, {kMemory}, "memory [kB]");
  }
  page.heading("Exponents, with the half width of their 95 % confidence");
  page.add(exponents_of(rows, families, flags.fit_from));
  page.heading("Rows");
  page.add(table_of(rows));
  page.add(to_terms(page.made));
  const std::filesystem::path out(flags.out);
  std::filesystem::create_directories(out);
  write_text_file(out / "index.html", to_html(page));
  write_text_file(out / "rows.csv", to_csv(table_of(rows)));
}

void run(const Flags& flags) {
  require_solver(flags.solver);
  require_plotting_tool();
  std::vector<Row> rows;
  const auto measure = [&](const std::vector<double>& sizes, const auto& make) {
    for (const double size : sizes) {
      if (size == 0) continue;
      rows.push_back(make(size, flags));
      const Row& row = rows.back();
      fmt::print(stderr, "{} {:.0f}: {}, {} iterations, {:.3g} s\n", row.family, row.bodies,
                 row.status, row.value[kIterations], row.value[kWhole]);
    }
  };
  measure(flags.sizes, lattice_row);
  measure(flags.pile_sizes, pile_row);
  measure(flags.pour_sizes, pour_row);
  std::vector<std::string> families;
  for (const Row& row : rows) {
    if (std::find(families.begin(), families.end(), row.family) == families.end()) {
      families.push_back(row.family);
    }
  }
  fmt::print("{}\n{}\n", to_markdown(table_of(rows)),
             to_markdown(exponents_of(rows, families, flags.fit_from)));
  write_page(rows, families, flags);
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  bipot::take_kernels_of_this_processor(argv);
  using namespace bipot;
  Flags flags;
  CLI::App app{"Growth of iterations, phases and memory with the number of disks"};
  const auto sizes = [&](const char* name, std::vector<double>& to, const char* help) {
    app.add_option(name, to, help)->delimiter(',')->check(CLI::Range(0.0, 1e7));
  };
  sizes("--sizes", flags.sizes, "Numbers of disks of the lattice, 0: none");
  sizes("--pile-sizes", flags.pile_sizes, "of settled piles, each made by a run");
  sizes("--pour-sizes", flags.pour_sizes, "of pours, each made by a run and kept in the cache");
  app.add_option("--solver", flags.solver, "Solver");
  app.add_option("--tol", flags.tol, "Guarded error")->check(CLI::PositiveNumber);
  app.add_option("--time-limit", flags.time_limit, "Seconds for one solve");
  app.add_option("--fit-from", flags.fit_from, "Fewest disks of a problem that enters the fits");
  app.add_option("--threads", flags.threads, "Threads of solver, detection and assembly")
      ->check(CLI::PositiveNumber);
  app.add_option("--out", flags.out, "Folder of the page");
  CLI11_PARSE(app, argc, argv);
  try {
    run(flags);
  } catch (const std::exception& e) {
    fmt::print(stderr, "growth_bench: {}\n", e.what());
    return 4;
  }
  return 0;
}
