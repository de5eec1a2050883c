// Fig. 13: the error against the iteration, square lattices from zero impulses.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

#include "bench/experiments/paper_item.h"
#include "bench/measure/statistics.h"
#include "core/motion/time_stepping.h"
#include "core/scene/scene_family.h"
#include "solvers/registry.h"
#include "solvers/solve.h"
#include "solvers/stop_rule.h"

namespace bipot {
namespace {

struct ErrorMethod {
  const char* id;    ///< in the names of numbers
  const char* name;  ///< in the key
  const char* solver;
  std::map<std::string, std::string> parameters;
  int style;
};
const std::vector<ErrorMethod>& methods() {
  static const std::vector<ErrorMethod> all = {
      {"uzawa_paper", "uzawa, paper's ρ", "uzawa", {{"rho", "paper"}}, 0},
      {"uzawa_stable", "uzawa, stable ρ", "uzawa", {{"rho", "stable"}}, 1},
      {"classical", "classical", "classical", {}, 2},
      {"pgs", "pgs", "pgs", {}, 3},
      {"apgd", "apgd", "apgd", {}, 4},
      {"ipm", "ipm", "ipm", {}, 5}};
  return all;
}
const ErrorMethod& method_of(std::string_view id) {
  return *std::ranges::find_if(methods(), [&](const ErrorMethod& m) { return m.id == id; });
}

struct History {
  std::vector<IterationRecord> records;
  int all_rows_reached = -1;  // first judged iteration at which the forces of all rows have begun
  SolveResult result;
  int side = 0;
};

constexpr double kExactTol = 1e-10;
constexpr double kMu = 0.3;  // where there is friction

History history(const ErrorMethod& method, int side, double mu, double tilt, int max_iterations,
                const PaperItem::Context& context) {
  const Scene<2> scene = make_family_scene("square", side, {.mu = mu, .tilt_degrees = tilt});
  const SolverEntry& entry = require_solver(method.solver);
  const ContactProblem problem = step_problem(scene, initial_state(scene));
  History h{.side = side};
  SolverOptions options{.tol = kExactTol,
                        .max_iterations = max_iterations,
                        .parameters = method.parameters,
                        .cancelled = context.interrupted};
  options.on_iteration = [&h](const IterationRecord& record) {
    h.records.push_back(record);
    if (h.all_rows_reached >= 0) return;
    const ContactCount count = record.count();
    if (count.stick + count.slip >= h.side * h.side) h.all_rows_reached = record.iteration;
  };
  h.result = solve(entry, problem, options);
  return h;
}

/// `value` against the iteration, about one marker in half a decade.
Chart::Series curve(const std::string& name, int style, const History& h,
                    double (*value)(const IterationRecord&)) {
  Chart::Series series{name, style, {}};
  double next = std::pow(10, 0.08 * style);
  for (const IterationRecord& r : h.records) {
    if (r.iteration < 1) continue;
    const bool marked = r.iteration >= next;
    while (next <= r.iteration) next *= std::sqrt(10.0);
    series.points.push_back(
        {static_cast<double>(r.iteration), value(r), !is_success(h.result.status), "", marked});
  }
  return series;
}

double guarded(const IterationRecord& r) { return r.error.guarded(); }
double raw(const IterationRecord& r) { return r.error.raw42; }

/// Decrease of ln ε in an iteration, by least squares over the last four decades.
double decay(const History& h) {
  std::vector<double> iterations, logarithms;
  const double last = h.records.back().error.guarded();
  for (const IterationRecord& r : h.records) {
    const double e = r.error.guarded();
    if (!(e > 0) || e > 1e4 * last) continue;
    iterations.push_back(r.iteration);
    logarithms.push_back(std::log(e));
  }
  return -fitted_slope(iterations, logarithms);
}

/// First judged iteration at which ε is at most `error`.
int first_below(const History& h, double error) {
  for (const IterationRecord& r : h.records) {
    if (r.error.guarded() <= error) return r.iteration;
  }
  return -1;
}

Chart error_chart(const std::string& title, const char* ordinate) {
  return Chart{.title = title,
               .x = {"iteration", Chart::Axis::Kind::kLog},
               .y = {ordinate, Chart::Axis::Kind::kLog, 1e-10, {}}};
}
constexpr const char* kLawError = "error in the contact law, ε";

// Frictionless, the paper's step: every contact of a column is a Jacobi iteration of the column's
// equations 2 s_k - s_{k-1} - s_{k+1} = m g h. Here s_n = 0 above the top. At the floor, whose
// own step is twice as long, there is a mirror. Its modes are cos(theta k), theta = (2j - 1) pi /
// 2n, and shrink by cos theta: the slowest by cos(pi / 2n) in an iteration.
double slowest_time_constant(int side) {
  return -1 / std::log(std::cos(std::numbers::pi / (2 * side)));
}

void transient_numbers(int side, int reached, double measured, Findings& result) {
  const double theory = slowest_time_constant(side);
  int first_judged = 0;
  while (first_judged < side) first_judged = next_judged(first_judged);
  result.check(
      fmt::format("reached_{}", side), reached, "iterations",
      fmt::format("{0} × {0}: until every row carries force", side),
      fmt::format("{}, one row an iteration; seen at {}, the first one judged from there on", side,
                  first_judged),
      reached == first_judged);
  result.check(fmt::format("tau_{}", side), measured, "iterations",
               fmt::format("{0} × {0}: time constant of the decay", side),
               fmt::format("−1/ln cos(π/2n) = {:.1f}, within 2 %", theory),
               std::abs(measured / theory - 1) <= 0.02);
}

/// The paper's method on lattices of several sizes, from zero impulses.
void transient(const PaperItem::Context& context, Findings& result) {
  Findings::Table rows{.name = "transient"};
  rows.caption =
      "`uzawa` with the paper's ρ, μ = 0. Reached: first iteration in which every row carries "
      "force. Time constant: iterations for a factor e, measured over the last four decades and "
      "by theory, −1/ln cos(π/2n).";
  rows.columns = {"rows n", "reached", "time constant", "theory", "iterations to 1e-8"};
  Chart sizes =
      error_chart("Error of the paper's solver against the iteration, square lattices", kLawError);
  int style = 0;
  for (const int side : context.quick ? std::vector<int>{5, 10} : std::vector<int>{5, 10, 20, 50}) {
    context.report(fmt::format("paper's ρ, {0} × {0}", side));
    const History h = history(method_of("uzawa_paper"), side, 0, 0, 200000, context);
    if (!is_success(h.result.status)) {
      throw std::runtime_error(fmt::format("uzawa, {} rows: {}", side, h.result.message));
    }
    sizes.series.push_back(curve(fmt::format("{0} × {0}", side), style++, h, guarded));
    const int reached = h.all_rows_reached;
    const double measured = 1 / decay(h);
    rows.rows.push_back(
        {std::to_string(side), std::to_string(reached), fmt::format("{:.1f}", measured),
         fmt::format("{:.1f}", slowest_time_constant(side)), std::to_string(first_below(h, 1e-8))});
    transient_numbers(side, reached, measured, result);
  }
  result.tables.push_back(rows);
  result.check("tau_theory_5", slowest_time_constant(5), "iterations",
               "time constant of five rows by theory", "about 20 in the paper's figure",
               std::nullopt, 3);
  result.ours.emplace_back(
      "The start has two parts. First the floor's push travels up: one row of contacts an "
      "iteration, so that n rows carry force only after n iterations. Then the forces diffuse to "
      "their values: each iteration averages a contact with its neighbours, and the slowest mode "
      "of a column shrinks by cos(π/2n) an iteration, a time constant of about 0.81 n² "
      "iterations. An exponential decay drawn log–log stays level until about its time constant "
      "and then plunges; nothing accelerates. Measured: {tau_5} for 5 rows (theory "
      "{tau_theory_5}), {tau_10} for 10. The paper does not give its size: twenty iterations "
      "would be the travel through twenty rows, or the time constant of five. Better initial "
      "forces shorten the second part, and more rows lengthen it.");
  result.draw("fig13_paper", "`uzawa` with the paper's ρ, μ = 0, several sizes.", sizes, 0);
}

void iterations_number(const ErrorMethod& method, int side, const SolveResult& solved,
                       Findings& result) {
  const std::string outcome =
      is_success(solved.status)
          ? " to 1e-10"
          : fmt::format(" done, ε = {} ({})", to_text(solved.error.guarded(), "", 2),
                        to_string(solved.status));
  result.state(fmt::format("its_{}_{}", method.id, side), solved.iterations, "",
               fmt::format("{1} × {1}, μ = 0.3, {0}: iterations{2}", method.name, side, outcome));
}

/// All methods on upright lattices.
void with_friction(const PaperItem::Context& context, Findings& result) {
  int undefined = 0, judged = 0;
  for (const int side : context.quick ? std::vector<int>{10} : std::vector<int>{10, 20, 50, 100}) {
    Chart chart = error_chart(
        fmt::format("Error against the iteration, square lattice {0} × {0}", side), kLawError);
    // Limits contact updates so that the largest lattice ends in seconds.
    const int cap = static_cast<int>(std::min(2e5, 3e8 / (2.0 * side * side + side)));
    for (const ErrorMethod& method : methods()) {
      context.report(fmt::format("{0}, {1} × {1}", method.name, side));
      const History h = history(method, side, kMu, 0, cap, context);
      chart.series.push_back(curve(method.name, method.style, h, guarded));
      for (const IterationRecord& r : h.records) {
        ++judged;
        if (!std::isfinite(r.error.raw42)) ++undefined;
      }
      if (side == 10 || side == 100) iterations_number(method, side, h.result, result);
    }
    result.draw(fmt::format("fig13_{}", side),
                fmt::format("All methods, {0} × {0}, μ = 0.3. Hollow: did not reach 1e-10 in {1} "
                            "iterations.",
                            side, to_text(cap, "", 6)),
                chart, 1);
  }
  result.state("raw_undefined", 100.0 * undefined / judged, "%",
               "upright lattices, μ = 0.3: judged iterations in which raw (42) is 0/0 or x/0", 3);
  result.ours.emplace_back(
      "Momentum (`apgd`) turns the n² into n, and an interior-point step couples all rows at "
      "once (`ipm`: {its_ipm_10} iterations for 10 × 10 where `uzawa` needs "
      "{its_uzawa_stable_10} with the stable ρ and {its_uzawa_paper_10} with the paper's).");
}

/// The lattice is tilted: friction acts, and raw (42) has a denominator.
void leaning(const PaperItem::Context& context, Findings& result) {
  const int side = context.quick ? 10 : 20;
  Chart chart =
      error_chart("Raw and guarded error against the iteration, leaning square lattice", "error");
  for (const char* id : {"uzawa_stable", "pgs", "ipm"}) {
    const ErrorMethod& method = method_of(id);
    context.report(fmt::format("{}, leaning", method.name));
    const History h = history(method, side, kMu, 10, 200000, context);
    chart.series.push_back(curve(fmt::format("ε, {}", method.name), method.style, h, guarded));
    chart.series.push_back(
        curve(fmt::format("raw (42), {}", method.name), method.style + 8, h, raw));
    result.state(fmt::format("raw_end_{}", method.id), h.result.error.raw42, "",
                 fmt::format("leaning lattice, {}: raw (42) where ε = {}", method.name,
                             to_text(h.result.error.guarded(), "", 1)),
                 2);
  }
  result.draw(
      "fig13_raw",
      fmt::format("Lattice {0} × {0} with gravity turned by 10°, μ = 0.3: it stays at rest, "
                  "and raw (42) never tells.",
                  side),
      chart, 2);
  result.ours.emplace_back(
      "The ordinate here is the guarded ε. Raw (42) divides by the dissipation of friction, and "
      "in a packing at rest nothing slides: it is undefined in {raw_undefined} of the judged "
      "iterations of the upright lattices, and in a lattice that leans by 10° it ends at "
      "{raw_end_uzawa_stable}, {raw_end_pgs} and {raw_end_ipm} (`uzawa`, `pgs`, `ipm`) where ε "
      "is below 1e-10.");
}

}  // namespace

Findings run_fig13(const PaperItem::Context& context) {
  Findings result;
  result.paper =
      "ε against the iteration number, log–log, for a rectangular array: about twenty iterations "
      "of an unsteady start, put down to the zero initial forces, then fast convergence.";
  transient(context, result);
  with_friction(context, result);
  leaning(context, result);
  return result;
}

}  // namespace bipot
