// Table 1 and Fig. 7: a ball dropped from h0 on a plane.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/paper_item.h"
#include "bench/problems/scene_catalogue.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

/// Quantities from a film of the ball: the greatest height and the duration of each flight between
/// two impacts, both to within a time step.
struct Bounces {
  std::vector<double> height, flight_time;  ///< of the whole flights, from the first impact on
  int impacts = 0, max_iterations = 0;
  std::vector<Chart::Point> film;  ///< time, height of the gap
};

Bounces bounce(const Scene<2>& shipped, double e_n, double step,
               const PaperItem::Context& context) {
  Scene<2> scene = shipped;
  scene.laws[0].e_n = e_n;
  scene.step = step;
  scene.num_steps = static_cast<int>(std::ceil(0.75 / step));
  Bounces b;
  double last_impact = -1, highest = 0;
  bool touching = false;
  const int film_every = std::max(1, static_cast<int>(2e-3 / step));
  b.film.push_back({0, scene.bodies[0].x[1] - scene.bodies[0].radius, false, "", false});
  run_paper_scene(scene, context, [&](const State<2>& state, const StepReport<2>& report) {
    const double gap = state.bodies[0].x[1] - state.bodies[0].radius;
    if (report.active > 0) {
      b.max_iterations = std::max(b.max_iterations, report.iterations);
      if (!touching) {
        ++b.impacts;
        if (last_impact >= 0) {
          b.height.push_back(highest);
          b.flight_time.push_back(report.time - last_impact);
        }
        last_impact = report.time;
        highest = 0;
      }
    }
    touching = report.active > 0;
    highest = std::max(highest, gap);
    if (report.step % film_every == 0) b.film.push_back({report.time, gap, false, "", false});
  });
  return b;
}

}  // namespace

Findings run_table1(const PaperItem::Context& context) {
  constexpr double kHeight = 0.1;
  const Scene<2> shipped = read_scene(find_scene("bouncing_ball"));
  const double g = -shipped.gravity[1];
  Findings result;
  result.paper =
      "A ball dropped from 0.10 m on a plane, time step 1e-4 s. With e_n = 1 heights and times of "
      "the bounces are exact to the digits printed; with e_n = 0.9 the heights of the first two "
      "bounces are 2.1 % and 5.6 % off, the times 0.3 % and 0.4 %; 2 iterations an impact.";
  Chart film{.title = "Height of the ball against time for two restitution coefficients",
             .x = {"time (s)", Chart::Axis::Kind::kLinear, 0.0, 0.8},
             .y = {"height above the plane (m)", Chart::Axis::Kind::kLinear, 0.0, 0.1}};
  // The paper's relative errors in percent: heights and times of the bounces 1 and 2.
  constexpr double kPaper[2][2][2] = {{{0, 0}, {0, 0}}, {{2.1, 5.6}, {0.3, 0.4}}};
  // An impact is located within one step of length |v| h <= 0.14 mm of the plane. Errors of heights
  // are at most twice that (before and after the flight), of times two steps.
  const double h = 1e-4, v0 = std::sqrt(2 * g * kHeight);
  int iterations = 0;
  for (int k = 0; k < 2; ++k) {
    const double e = k == 0 ? 1.0 : 0.9;
    context.report(fmt::format("e_n = {:g}", e));
    const Bounces b = bounce(shipped, e, h, context);
    iterations = std::max(iterations, b.max_iterations);
    film.series.push_back({fmt::format("e_n = {:g}", e), k, b.film});
    for (int p = 1; p <= 2; ++p) {
      const double height = kHeight * std::pow(e, 2 * p);
      const double time = 2 * std::pow(e, p) * std::sqrt(2 * kHeight / g);
      const auto has = [&](const std::vector<double>& x) {
        return x.size() >= static_cast<std::size_t>(p) ? x[p - 1] : std::nan("");
      };
      const double here_h = has(b.height), here_t = has(b.flight_time);
      const auto compared = [&](const char* what, const char* unit, double here, double exact,
                                double bound, double paper) {
        const std::string id = fmt::format("{}{}_e{}", what[0], p, k == 0 ? "1" : "09");
        result.check(id, here, unit, fmt::format("{} of bounce {}, e_n = {:g}", what, p, e),
                     fmt::format("{:.4f} {}", exact, unit), std::nullopt);
        const double error = 100 * std::abs(here / exact - 1);
        result.check(id + "_error", error, "%",
                     fmt::format("relative error of the {} of bounce {}, e_n = {:g}", what, p, e),
                     fmt::format("at most {:.2f} %, the length of a step; the paper's: {:g} %",
                                 100 * bound, paper),
                     error <= 100 * bound, 2);
      };
      compared("height", "m", here_h, height, 2 * v0 * h / kHeight, kPaper[k][0][p - 1]);
      compared("time", "s", here_t, time, 2 * h / time, kPaper[k][1][p - 1]);
    }
  }
  result.check("iterations", iterations, "", "most iterations in an impact", "2 in the paper",
               iterations >= 1 && iterations <= 2);

  Chart steps{
      .title = "Relative error of the first bounce's height against the time step, e_n = 0.9",
      .x = {"time step h (s)", Chart::Axis::Kind::kLog},
      .y = {"relative error of the height", Chart::Axis::Kind::kLog}};
  Chart::Series here{"here", 0, {}}, first_order{"|v| h / h0", 1, {}};
  for (const double step : {2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5, 2e-6}) {
    if (context.quick && step < 1e-5) continue;
    context.report(fmt::format("h = {:g} s", step));
    const Bounces b = bounce(shipped, 0.9, step, context);
    const double exact = kHeight * 0.81;
    if (b.height.empty()) continue;
    here.points.push_back({step, std::abs(b.height[0] / exact - 1)});
    first_order.points.push_back({step, v0 * step / kHeight, false, "", false});
  }
  steps.series = {here, first_order, {"the paper", 2, {{1e-4, 0.021}}}};

  result.ours = {
      "At the paper's step, e_n = 0.9, the heights are {h1_e09_error} and {h2_e09_error} off and "
      "the times {t1_e09_error} and {t2_e09_error}. What is left is the place of the impact within "
      "a step: it falls with the step length, unevenly, because it depends on where the steps "
      "happen to fall. Most iterations in an impact: {iterations}."};
  result.draw("table1_film", "Height against time (the paper's Fig. 7), h = 1e-4 s.", film);
  result.draw("table1_step",
              "Error of the first bounce's height, e_n = 0.9, against the time step; "
              "dashed: the distance fallen in one step over h0.",
              steps);
  return result;
}

}  // namespace bipot
