#include "bench/compare/page_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/compare/comparison_charts.h"
#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

std::string law_label(const PowerLaw& law) {
  if (!std::isfinite(law.exponent)) return "–";
  if (!std::isfinite(law.confidence)) return fmt::format("{:.2f}", law.exponent);
  return fmt::format("{:.2f} ± {:.2f}", law.exponent, law.confidence);
}

}  // namespace

void add_regret(PageDraft& page, const PageContent& of) {
  if (!of.has_auto()) return;
  page.heading("auto", "What it costs to let auto choose");
  const Regret all = regret_of(of.comparison, "auto"),
               longer = regret_of(of.comparison, "auto", 1e-3);
  page.add(fmt::format(
      "<p>The time of <code>auto</code> over the time of the fastest other solver "
      "that met the same tolerance on the same problem: {} cases. Below 1, auto is "
      "faster than all others. A case that auto does not solve counts as "
      "infinite.{}</p>\n",
      all.entries.size(),
      all.alone > 0 ? fmt::format(" In {} more, auto alone met the tolerance.", all.alone) : ""));
  if (all.entries.empty()) return;
  page.add(
      "<div class=\"grid\"><div><div class=\"scroll\"><table><thead><tr><th>cases</th><th "
      "class=\"n\">number</th><th class=\"n\">not solved</th><th class=\"n\">median</th><th "
      "class=\"n\">90 % below</th><th class=\"n\">worst</th></tr></thead><tbody>\n");
  const auto line = [&page](const std::string& name, const Regret& r) {
    page.add(
        fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
                    "class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                    name, r.entries.size(), r.failed, ratio_label(r.median),
                    ratio_label(r.ninth_decile), ratio_label(r.worst)));
  };
  line("all", all);
  line("fastest other ≥ 1 ms", longer);
  for (double tol : of.tols) {
    Comparison part;
    for (const ComparisonRow& row : of.comparison.rows) {
      if (row.tol == tol) part.rows.push_back(row);
    }
    line("tolerance " + tolerance_label(tol), regret_of(part, "auto"));
  }
  page.add(
      "</tbody></table></div>\n<h3>The ten worst cases</h3>\n<div class=\"scroll\"><table><thead>"
      "<tr><th>problem</th><th class=\"n\">tolerance</th><th class=\"n\">ratio</th><th "
      "class=\"n\">auto</th><th>fastest other</th></tr></thead><tbody>\n");
  for (std::size_t i = 0; i < all.entries.size() && i < 10; ++i) {
    const Regret::Entry& e = all.entries[i];
    page.add(
        fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
                    "class=\"n\">{}</td><td>{}, {}</td></tr>\n",
                    escape_markup(e.problem), tolerance_label(e.tol), ratio_label(e.ratio),
                    seconds_label(e.time), escape_markup(e.best), seconds_label(e.best_time)));
  }
  page.add("</tbody></table></div></div>\n");
  page.figure(regret_chart({all, longer}, {"all cases", "fastest other at least 1 ms"}),
              "How often auto is within a multiple of the fastest other solver's time.",
              of.report.command, "cpu_min of the rows with guarded ≤ tol in comparison.csv");
  page.add("</div>\n");
}

void add_success(PageDraft& page, const PageContent& of) {
  if (of.success.empty()) return;
  page.heading("success", "Success against tolerance");
  page.add(
      "<p>The share of the problems of a size that a solver brings below a tolerance within the "
      "time limit, whatever it was asked for. The curves end at the tightest tolerance of this "
      "comparison: beyond it nobody was asked.</p>\n<div class=\"grid\">\n");
  for (const SizeClass& size : size_classes()) {
    const auto has_size = [&](const SuccessCurve& curve) { return curve.size == size.name; };
    const auto first = std::find_if(of.success.begin(), of.success.end(), has_size);
    if (first == of.success.end()) continue;
    page.figure(success_chart(of.success, size.name),
                fmt::format("{} problem{} of {}.", first->problems, first->problems == 1 ? "" : "s",
                            size.name),
                of.report.command, "success.csv");
  }
  page.add("</div>\n");
}

void add_profiles(PageDraft& page, const PageContent& of) {
  if (of.comparison.problems.size() < 2) return;
  const std::size_t total = of.comparison.problems.size();
  page.heading("profiles", "Performance profiles");
  page.add(
      "<p>How far up a curve starts at the left: the share of problems on which the solver is "
      "the cheapest. How high it ends at the right: the share that it solves at all, within a "
      "thousand times the least cost. In between, the share solved within that multiple of the "
      "least cost (Dolan and Moré 2002).</p>\n<h3>At a fixed tolerance</h3>\n<div "
      "class=\"grid\">\n");
  for (double tol : of.tols) {
    const std::string at = tolerance_label(tol);
    page.figure(profile_chart(performance_profiles(of.comparison, time_at(of.comparison, tol)),
                              "time", "Time profile at tolerance " + at),
                fmt::format("Time to meet tolerance {}, {} problems.", at, total),
                of.report.command, "cpu_min of the rows with guarded ≤ tol in comparison.csv");
    page.figure(
        profile_chart(performance_profiles(of.comparison, iterations_at(of.comparison, tol)),
                      "iterations", "Iteration profile at tolerance " + at),
        fmt::format("Iterations to meet tolerance {}, {} problems. An iteration costs much "
                    "more in some solvers than in others.",
                    at, total),
        of.report.command, "iterations of the rows with guarded ≤ tol in comparison.csv");
  }
  page.add(
      "</div>\n<h3>At a fixed true error</h3>\n<p>Time of each solver's cheapest row whose true "
      "error is that small, whatever its tolerance.</p>\n<div class=\"grid\">\n");
  for (double accuracy : kProfileAccuracies) {
    const std::string to = accuracy_label(accuracy);
    page.figure(profile_chart(performance_profiles(of.comparison, time_to(of.comparison, accuracy)),
                              "time", "Time profile to a true error of " + to),
                fmt::format("Time to a true error of {}, {} problems.", to, total),
                of.report.command,
                "cpu_min and the error of the ranking (ranked_by) in comparison.csv and "
                "comparison.json");
  }
  page.add(
      "</div>\n<h3>Within a fixed time</h3>\n<p>How the least true error that a solver reaches "
      "within the time is distributed over the problems: the share of problems with an error of "
      "at most that on the axis. Higher is better. Only what the tolerances of this comparison "
      "gave is counted.</p>\n<div class=\"grid\">\n");
  for (double budget : kBudgets) {
    page.figure(
        budget_chart(errors_within(of.comparison, budget),
                     "Errors within " + seconds_label(budget)),
        fmt::format("True error reached within {}, {} problems.", seconds_label(budget), total),
        of.report.command, "cpu_min and the error of the ranking in comparison.csv");
  }
  page.add("</div>\n");
}

void add_growth(PageDraft& page, const PageContent& of) {
  if (of.growth.empty()) return;
  page.heading("growth", "Growth with size");
  page.add(
      "<p>Problems that differ in size alone. Iterations and time are fitted by N<sup>p</sup>, N "
      "the number of disks, over the sizes that the solver solved; p is given with its 95 % "
      "confidence (Student's t), which needs three sizes. Empty markers were not solved and are "
      "not fitted; a solver that was out of time is not tried on larger sizes.</p>\n");
  std::vector<std::string> series;
  for (const Growth& g : of.growth) {
    if (series.empty() || series.back() != g.series) series.push_back(g.series);
  }
  for (const std::string& name : series) {
    std::string targets;
    for (const ProblemSummary& p : of.comparison.problems) {
      if (p.series == name) targets += (targets.empty() ? "" : " ") + p.target;
    }
    const std::string replay = fmt::format(fmt::runtime(of.report.command_of_target), targets);
    page.add(fmt::format("<details><summary>{}</summary>\n", escape_markup(name)));
    page.add("<div class=\"scroll\"><table><thead><tr><th>solver</th>");
    for (double tol : of.tols) {
      page.add(fmt::format("<th class=\"n\">iterations, {0}</th><th class=\"n\">time, {0}</th>",
                           tolerance_label(tol)));
    }
    page.add("</tr></thead><tbody>\n");
    for (const std::string& solver : of.solvers) {
      page.add(fmt::format("<tr><td>{}</td>", escape_markup(solver)));
      for (double tol : of.tols) {
        for (const Growth& g : of.growth) {
          if (g.series != name || g.solver != solver || g.tol != tol) continue;
          page.add(fmt::format("<td class=\"n\">{}</td><td class=\"n\">{}</td>",
                               law_label(g.iterations), law_label(g.time)));
        }
      }
      page.add("</tr>\n");
    }
    page.add("</tbody></table></div>\n<div class=\"grid\">\n");
    std::vector<double> shown = {of.tols.front()};
    if (of.tols.size() > 1) shown.push_back(of.tols.back());
    for (double tol : shown) {
      for (GrowthOf quantity : {GrowthOf::kIterations, GrowthOf::kTime}) {
        const bool time = quantity == GrowthOf::kTime;
        page.figure(growth_chart(of.growth, name, tol, quantity),
                    fmt::format("{} at tolerance {}, {}.", time ? "Time" : "Iterations",
                                tolerance_label(tol), escape_markup(name)),
                    replay,
                    fmt::format("{} in comparison.csv, dofs / 3 in comparison.json",
                                time ? "cpu_min" : "iterations"));
      }
    }
    page.add("</div></details>\n");
  }
}

}  // namespace bipot
