// Error of the observables over step and tolerance.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/report/labels.h"
#include "bench/study/study.h"

namespace bipot {
namespace {

const std::string kPlane = "plane", kPlaneMethod = "apgd";
constexpr double kFinestFactor = 0.125, kFinestTol = 1e-5;  // of the reference

Study::Job plane_job(const std::string& scene, const Study::Sample& sample, double tol,
                     double factor) {
  return {{kPlane, scene, sample.size, sample.seed, kPlaneMethod, tol, factor},
          [=](const Study::Stopped& stopped) {
            return Study::run(sample,
                              {.solver = kPlaneMethod,
                               .tol = tol,
                               .step_factor = factor,
                               .parameters = {{"islands", "off"}}},
                              stopped);
          }};
}

std::vector<Study::Job> plane_jobs(bool quick) {
  std::vector<Study::Job> jobs;
  const std::vector<double> factors =
      quick ? std::vector<double>{2, 1} : std::vector<double>{4, 2, 1, 0.5};
  const std::vector<double> tols =
      quick ? std::vector<double>{1, 1e-2} : std::vector<double>{10, 1, 1e-1, 1e-2, 1e-3};
  for (int seed = 1; seed <= (quick ? 3 : 20); ++seed) {
    for (const char* scene : {"pour", "collapse", "shear", "drum"}) {
      const bool drum = scene == std::string("drum");  // costs ten times more
      if (drum && seed > 10) continue;
      const Study::Sample sample{.scene = scene, .size = quick ? 36 : 64, .seed = seed};
      jobs.push_back(plane_job(scene, sample, kFinestTol, quick ? 0.5 : kFinestFactor));
      for (const double factor : factors) {
        for (const double tol : tols) {
          if (!drum || tol > 5e-3) jobs.push_back(plane_job(scene, sample, tol, factor));
        }
      }
    }
  }
  return jobs;
}

/// Median relative error of a case's observables against the reference, and their median bar.
struct OverallError {
  double error = kNaN, bar = kNaN, cpu = kNaN;
  int seeds = 0;
};
OverallError overall_error(const Study::Measured& measured, const Study::Case& of,
                           const Study::Case& reference) {
  std::vector<double> errors, bars;
  OverallError overall;
  for (const std::string& quantity : classed_quantities(measured, of.part, of.scene)) {
    const Study::PairedError e = paired_error(measured, of, reference, quantity);
    if (!std::isfinite(e.bar)) continue;
    errors.push_back(e.error);
    bars.push_back(e.bar);
    overall.seeds = std::max(overall.seeds, e.seeds);
  }
  overall.error = median(errors);
  overall.bar = median(bars);
  overall.cpu = over_seeds(by_seed(measured, of, "cpu")).mean;
  return overall;
}

/// The case of the shortest step and tightest tolerance of a scene.
Study::Case finest(const Study::Measured& measured, const std::string& part,
                   const std::string& scene) {
  const auto here = [&](const Study::Case& c) {
    return c.part == part && c.scene == scene && c.method == kPlaneMethod;
  };
  Study::Case best;
  for (const auto& [of, values] : measured) {
    if (!here(of)) continue;
    if (best.part.empty() || std::pair(of.x, of.tol) < std::pair(best.x, best.tol)) best = of;
  }
  best.seed = 0;
  return best;
}

Document plane_report(const Study::Measured& measured) {
  Document part;
  Table table{.columns = {{"scene", "scene"},
                          {"step_factor", "step over the scene's", &ratio_label},
                          {"tol", "ε", &tolerance_label},
                          {"error", "median error", &share_label},
                          {"bar", "median bar", &share_label},
                          {"overlap", "largest overlap", &share_label},
                          {"cpu", "CPU", &seconds_label},
                          {"seeds", "seeds that ended", &count_label}},
              .key = "plane",
              .sortable = true};
  Table ridge{.columns = {{"scene", "scene"},
                          {"step_factor", "step over the scene's", &ratio_label},
                          {"tol", "ε that is enough", &tolerance_label},
                          {"error", "error there", &share_label},
                          {"bar", "bar", &share_label},
                          {"saved", "time saved against the tightest", &ratio_label}},
              .key = "ridge",
              .note =
                  "Enough: the median error is at most that of the tightest tolerance and its "
                  "bar."};
  for (const std::string& scene : distinct(measured, kPlane, &Study::Case::scene)) {
    const Study::Case reference = finest(measured, kPlane, scene);
    Chart chart{.title = scene,
                .x = {.label = "tolerance ε", .kind = Chart::Axis::Kind::kLog},
                .y = {.label = "median relative error", .kind = Chart::Axis::Kind::kLog}};
    auto factors = distinct<double>(measured, kPlane, &Study::Case::x,
                                    [&](const Study::Case& c) { return c.scene == scene; });
    std::ranges::reverse(factors);
    int style = 0;
    for (const double factor : factors) {
      if (factor == reference.x) continue;
      Chart::Series line{fmt::format("{:g} h", factor), style++, {}};
      std::vector<std::pair<double, OverallError>> at;
      for (const double tol : distinct(measured, kPlane, &Study::Case::tol)) {
        Study::Case of = reference;
        of.x = factor;
        of.tol = tol;
        const OverallError e = overall_error(measured, of, reference);
        if (e.seeds < 2) continue;
        at.emplace_back(tol, e);
        table.add({scene, factor, tol, e.error, e.bar,
                   over_seeds(by_seed(measured, of, "overlap")).mean, e.cpu, e.seeds});
        line.points.push_back(
            {.x = tol, .y = e.error, .note = {}, .y_low = e.error, .y_high = e.error + e.bar});
      }
      chart.series.push_back(std::move(line));
      for (std::size_t k = at.size(); k-- > 0;) {
        if (at[k].second.error > at[0].second.error + at[0].second.bar) continue;
        ridge.add({scene, factor, at[k].first, at[k].second.error, at[k].second.bar,
                   at[0].second.cpu / at[k].second.cpu});
        break;
      }
    }
    part.add(Figure{.chart = std::move(chart),
                    .file = "plane_" + scene + ".svg",
                    .caption = fmt::format("{}: median relative error of the observables over "
                                           "tolerance, with the median bar, for several steps.",
                                           scene)});
  }
  part.add(std::move(ridge));
  part.fold("The whole plane", std::move(table));
  return part;
}

}  // namespace

Study::Part plane_part() {
  return {kPlane, "The plane of step and tolerance", &plane_jobs, &plane_report};
}

}  // namespace bipot
