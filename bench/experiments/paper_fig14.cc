// Fig. 14: iterations against the number of particles.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/paper_item.h"
#include "bench/measure/iteration_growth.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

const std::vector<double> kTols = {1e-2, 1e-4, 1e-6, 1e-8};
/// The paper: "except for small samples".
constexpr double kFitFrom = 300;

/// For narrow columns: "1.04 ± 0.03 (5)".
std::string exponent(const PowerLaw& law) {
  const std::string label = exponent_label(law);
  return std::isfinite(law.exponent) ? fmt::format("{} ({})", label, law.points) : label;
}

std::string tol_text(double tol) { return fmt::format("1e{:.0f}", std::log10(tol)); }

struct CurveMethod {
  SolverVariant method;
  std::string id;
  int style;
  double work;  ///< largest number of contact updates of a solve; larger problems are not started
};

struct Case {
  GrowthScene scene;
  const char* what;  ///< in captions
  std::vector<double> sizes;
  double largest_ipm;  ///< disks
};

class Fig14 {
 public:
  explicit Fig14(const PaperItem::Context& context) : context_(context) {
    // Sweeps get about 3 s of one core, momentum eight times that.
    const double work = context.quick ? 1e7 : 3e8;
    methods_ = {{{"uzawa, paper's ρ", "uzawa", {{"rho", "paper"}}}, "uzawa_paper", 0, work},
                {{"uzawa, stable ρ", "uzawa", {{"rho", "stable"}}}, "uzawa_stable", 1, work},
                {{"pgs", "pgs"}, "pgs", 3, work},
                {{"apgd", "apgd"}, "apgd", 4, 8 * work},
                {{"ipm", "ipm"}, "ipm", 5, 1e300}};
    std::vector<double> sizes = {100, 178, 316, 562, 1000, 1778, 3162, 10000, 31623, 100000};
    std::vector<double> piles = {100, 324, 1024, 3025};
    if (context.quick) {
      sizes = {100, 316, 562, 1000};
      piles = {100, 324};
    }
    add_case("square", 0, "square lattice", sizes, 1e5);
    add_case("triangular", 10, "triangular lattice, gravity turned by 10°", sizes, 31623);
    add_case("diluted", 0, "random: triangular lattice with a tenth of the disks missing", sizes,
             10000);
    add_case("pile", 0, "random: settled pile of three sizes", piles, 1e5);
  }

  Findings run() {
    for (const Case& c : cases_) measure(c);
    fits_ = fit_growth(rows_, kFitFrom);
    result_.paper =
        "Iterations against the number of particles, square lattices, log–log: a straight line of "
        "slope 1.042, small samples apart.";
    numbers();
    charts();
    tables();
    result_.ours = {
        "The paper's method, paper's ρ, square lattices: exponent {uzawa_paper_1e-2} at 1e-2 and "
        "{uzawa_paper_1e-8} at 1e-8. Theory says 1: forces diffuse through √N rows, which takes N "
        "iterations (see Fig. 13). Time then grows with N². Sweeps that use new velocities at once "
        "(`pgs`) halve the count and keep the exponent: {pgs_1e-8}. Momentum (`apgd`) brings "
        "{apgd_1e-8}, an interior-point method (`ipm`) {ipm_1e-8}: its count hardly grows. On the "
        "other scenes, where contacts stick, the paper's ρ meets 1e-2 in {paper_rho_met} of "
        "{paper_rho_tried} first problems: it lies outside the stable range of a sticking contact "
        "(W_tt = 3 W_nn).",
        "The exponents stand with the half width of their 95 % confidence interval, from 300 disks "
        "on. Sweeps were given {work} contact updates a solve, some seconds, `apgd` eight times as "
        "many; what would take more, judged by the size before, was not begun, and what did not "
        "meet its tolerance is in no fit. `solver_bench` takes any sizes and limits."};
    if (context_.quick) {
      result_.ours.emplace_back("Quick: small sizes and limits; the exponents are rough.");
    }
    return std::move(result_);
  }

 private:
  void add_case(const std::string& family, double tilt, const char* what,
                const std::vector<double>& sizes, double largest_ipm) {
    cases_.push_back({{.family = family, .tilt_degrees = tilt}, what, sizes, largest_ipm});
  }

  void measure(const Case& c) {
    // Iterations at the previous size, for each method and tolerance; infinite if not met.
    std::vector<std::vector<double>> before(methods_.size(), std::vector<double>(kTols.size(), 0));
    double disks_before = 0;
    for (const double size : c.sizes) {
      context_.report(fmt::format("{}, {:.0f} disks: making it", c.scene.family, size));
      const GrowthScene::Problem problem =
          make_growth_problem(c.scene, side_of(c.scene.family, size));
      const double disks = static_cast<double>(problem.bodies);
      for (std::size_t m = 0; m < methods_.size(); ++m) {
        const CurveMethod& method = methods_[m];
        if (method.method.solver == "ipm" && size > 1.01 * c.largest_ipm) continue;
        const double cap = method.work / problem.problem.num_contacts();
        // Assumes growth no faster than N; the limit of iterations holds in any case.
        std::vector<double> tols;
        for (std::size_t t = 0; t < kTols.size(); ++t) {
          const double expected =
              disks_before > 0 && method.work < 1e300 ? before[m][t] * disks / disks_before : 0;
          if (expected <= cap) tols.push_back(kTols[t]);
        }
        if (tols.empty()) continue;
        context_.report(
            fmt::format("{}, {:.0f} disks, {}", c.scene.family, disks, method.method.label));
        GrowthRow::Limits limits{
            .max_iterations = static_cast<int>(std::min(cap, method.work < 1e300 ? 1e9 : 500.0)),
            .cancelled = context_.interrupted};
        const auto rows = growth_rows(c.scene, problem, method.method, tols, limits);
        std::ranges::fill(before[m], kInfinity);
        for (const GrowthRow& row : rows) {
          rows_.push_back(row);
          const auto t = std::ranges::find(kTols, row.tol) - kTols.begin();
          if (is_success(row.status)) before[m][static_cast<std::size_t>(t)] = row.iterations;
        }
      }
      disks_before = disks;
    }
  }

  /// Without numbers if nothing was measured.
  GrowthFit fit_of(const std::string& family, const std::string& method, double tol) const {
    for (const GrowthFit& fit : fits_) {
      if (fit.family == family && fit.method == method && fit.tol == tol) return fit;
    }
    return {};
  }

  std::string command(const Case& c, const CurveMethod& m, const std::string& tols) const {
    std::string line = fmt::format("solver_bench --family={} --solver={} --tol={}", c.scene.family,
                                   m.method.solver, tols);
    for (const auto& [name, value] : m.method.parameters) {
      line += fmt::format(" --set={}:{}", name, value);
    }
    if (c.scene.tilt_degrees != 0) line += fmt::format(" --tilt={:g}", c.scene.tilt_degrees);
    std::vector<int> sides;
    for (const GrowthRow& row : rows_) {
      if (row.family == c.scene.family && row.method == m.method.label && is_success(row.status) &&
          std::ranges::find(sides, row.side) == sides.end()) {
        sides.push_back(row.side);
      }
    }
    return line + fmt::format(" --side={}", fmt::join(sides, ","));
  }

  void numbers() {
    const Case& square = cases_[0];
    for (const CurveMethod& m : methods_) {
      for (const double tol : kTols) {
        const PowerLaw law = fit_of("square", m.method.label, tol).iterations;
        Claim& n = result_.state(
            fmt::format("{}_{}", m.id, tol_text(tol)), law.exponent, "",
            fmt::format(
                "square lattice, {}, ε ≤ {}: exponent of the iterations, ± {} ({} sizes)",
                m.method.label, tol_text(tol),
                std::isfinite(law.confidence) ? fmt::format("{:.3f}", law.confidence) : "unknown",
                law.points));
        n.command = command(square, m, "1e-2,1e-4,1e-6,1e-8");
        const bool fitted = !context_.quick && std::isfinite(law.exponent) && law.points >= 3;
        if (m.id == "uzawa_paper" || m.id == "pgs") {
          n.expected = "1 by theory, within 0.1; the paper: 1.042 for its method";
          if (fitted) n.holds = std::abs(law.exponent - 1) <= 0.1;
        } else if (m.id == "apgd") {
          n.expected = "about ½ (momentum), within 0.15";
          if (fitted) n.holds = std::abs(law.exponent - 0.5) <= 0.15;
        } else if (m.id == "ipm") {
          n.expected = "at most 0.15";
          if (fitted) n.holds = law.exponent <= 0.15;
        }
      }
    }
    int met = 0, tried = 0;
    for (const GrowthRow& row : rows_) {
      if (row.family == "square" || row.method != methods_[0].method.label || row.tol != 1e-2) {
        continue;
      }
      ++tried;
      met += is_success(row.status) ? 1 : 0;
    }
    result_.state("work", methods_[0].work, "", "contact updates that a sweep method may take");
    const std::string other = command(cases_[1], methods_[0], "1e-2");
    result_
        .state("paper_rho_tried", tried, "",
               "problems of the other scenes begun with the paper's ρ")
        .command = other + "10";
    result_.state("paper_rho_met", met, "", "of them, those in which ε ≤ 1e-2 was met").command =
        other + "10";
  }

  Chart::Series series(const std::string& name, int style, const std::string& family,
                       const std::string& method, double tol, bool seconds) const {
    Chart::Series s{name, style, {}};
    for (const GrowthRow& row : rows_) {
      if (row.family != family || row.method != method || row.tol != tol) continue;
      if (!is_success(row.status)) continue;
      s.points.push_back(
          {static_cast<double>(row.bodies),
           seconds ? row.setup_seconds + row.solve_seconds : static_cast<double>(row.iterations),
           false,
           fmt::format("{} disks: {} iterations, {:.2g} s", row.bodies, row.iterations,
                       row.setup_seconds + row.solve_seconds)});
    }
    return s;
  }

  void figure(const std::string& name, const std::string& title, const std::string& caption,
              std::vector<Chart::Series> all, bool seconds) {
    Chart chart{.title = title,
                .x = {"number of disks", Chart::Axis::Kind::kLog},
                .y = {seconds ? "time of the solve" : "iterations",
                      seconds ? Chart::Axis::Kind::kLogSeconds : Chart::Axis::Kind::kLog}};
    std::erase_if(all, [](const Chart::Series& s) { return s.points.empty(); });
    chart.series = std::move(all);
    result_.draw(name, caption, std::move(chart));
  }

  void charts() {
    std::vector<Chart::Series> all;
    for (std::size_t t = 0; t < kTols.size(); ++t) {
      all.push_back(series("ε ≤ " + tol_text(kTols[t]), static_cast<int>(t), "square",
                           methods_[0].method.label, kTols[t], false));
    }
    Chart::Series slope{"slope 1.042", 9, {}, Chart::Series::Kind::kLine};
    if (!all[0].points.empty()) {
      const Chart::Point& first = all[0].points.front();
      for (const double factor : {1.0, all[0].points.back().x / first.x}) {
        slope.points.push_back({factor * first.x, 0.5 * first.y * std::pow(factor, 1.042)});
      }
    }
    all.push_back(std::move(slope));
    figure("fig14_paper", "Iterations of the paper's method against the number of disks",
           "The paper's method on square lattices, μ = 0.3; the line has the paper's slope.",
           std::move(all), false);
    for (const Case& c : cases_) {
      for (const double tol : {1e-4, 1e-8}) {
        if (tol == 1e-8 && c.scene.family != "square" && c.scene.family != "pile") continue;
        std::vector<Chart::Series> methods;
        for (const CurveMethod& m : methods_) {
          methods.push_back(
              series(m.method.label, m.style, c.scene.family, m.method.label, tol, false));
        }
        figure(fmt::format("fig14_{}_{}", c.scene.family, tol == 1e-4 ? 4 : 8),
               fmt::format("Iterations against the number of disks, {}", c.what),
               fmt::format("Iterations to ε ≤ {}, {}.", tol_text(tol), c.what), std::move(methods),
               false);
      }
    }
    std::vector<Chart::Series> times;
    for (const CurveMethod& m : methods_) {
      times.push_back(series(m.method.label, m.style, "square", m.method.label, 1e-8, true));
    }
    figure("fig14_time", "Time against the number of disks, square lattice",
           "Wall time to ε ≤ 1e-8, square lattice, one core.", std::move(times), true);
  }

  void tables() {
    for (const Case& c : cases_) {
      Findings::Table table{
          .name = "exponents_" + c.scene.family,
          .caption = fmt::format(
              "{}: exponent of the iterations in the number of disks, ± half of its 95 % confidence "
              "interval; last, that of the wall time to 1e-4. In parentheses the number of sizes.",
              c.what),
          .columns = {"method"}};
      for (const double tol : kTols) table.columns.push_back(tol_text(tol));
      table.columns.emplace_back("time to 1e-4");
      for (const CurveMethod& m : methods_) {
        std::vector<std::string> cells = {m.method.label};
        for (const double tol : kTols) {
          cells.push_back(exponent(fit_of(c.scene.family, m.method.label, tol).iterations));
        }
        cells.push_back(exponent(fit_of(c.scene.family, m.method.label, 1e-4).seconds));
        table.rows.push_back(std::move(cells));
      }
      result_.tables.push_back(std::move(table));
    }
    Findings::Table rows{
        .name = "rows",
        .caption = "Every problem: iterations to each tolerance, and what the tightest achieved.",
        .columns = {"scene", "method", "disks", "contacts"}};
    for (const double tol : kTols) rows.columns.push_back(tol_text(tol));
    for (const char* name : {"ε", "natural map", "time"}) rows.columns.emplace_back(name);
    for (std::size_t i = 0; i < rows_.size();) {
      const GrowthRow& first = rows_[i];
      std::vector<std::string> cells = {first.family, first.method, std::to_string(first.bodies),
                                        std::to_string(first.contacts)};
      std::vector<std::string> its(kTols.size(), "not begun");
      const GrowthRow* last = &first;
      for (; i < rows_.size() && rows_[i].family == first.family &&
             rows_[i].method == first.method && rows_[i].bodies == first.bodies;
           ++i) {
        const GrowthRow& row = rows_[i];
        const auto t = std::ranges::find(kTols, row.tol) - kTols.begin();
        its[static_cast<std::size_t>(t)] = is_success(row.status)
                                               ? std::to_string(row.iterations)
                                               : std::string(to_string(row.status));
        last = &row;
      }
      cells.insert(cells.end(), its.begin(), its.end());
      cells.push_back(error_label(last->error.guarded()));
      cells.push_back(error_label(last->error.natural_map));
      cells.push_back(to_text(last->setup_seconds + last->solve_seconds, "s", 2));
      rows.rows.push_back(std::move(cells));
    }
    result_.tables.push_back(std::move(rows));
  }

  const PaperItem::Context& context_;
  std::vector<CurveMethod> methods_;
  std::vector<Case> cases_;
  std::vector<GrowthRow> rows_;
  std::vector<GrowthFit> fits_;
  Findings result_;
};

}  // namespace

Findings run_fig14(const PaperItem::Context& context) { return Fig14(context).run(); }

}  // namespace bipot
