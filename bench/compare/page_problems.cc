#include "bench/compare/page_problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/compare/comparison_charts.h"
#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

std::string uniqueness(const ProblemSummary& p) {
  if (p.poor_reference()) {
    return " <strong>No trusted reference</strong>: solvers are ranked by the guarded error.";
  }
  if (p.several_velocities()) {
    return fmt::format(
        " <strong>Several exact answers</strong>: {} are known, velocities up to {} apart in the "
        "energy norm, the force on a body by {} of the largest. Errors are distances to the "
        "nearest.",
        p.answers, error_label(p.spread.velocity), error_label(p.spread.force));
  }
  if (std::isfinite(p.velocity_spread)) {
    return fmt::format(" Solvers below 1e-9 agree on the velocities to {}.",
                       error_label(p.velocity_spread));
  }
  return " No second solver stands below 1e-9, so nothing is known of other solutions.";
}

void add_pareto_sentence(PageDraft& page, const PageContent& of, const ProblemSummary& p) {
  auto best = pareto_rows(p, of.comparison.rows);
  std::sort(best.begin(), best.end(),
            [](const ComparisonRow* a, const ComparisonRow* b) { return a->time() < b->time(); });
  const Ranking rank = ranking(p, of.comparison.rows);
  std::string list;
  for (const ComparisonRow* row : best) {
    list += fmt::format("{}{} at {} ({}, {})", list.empty() ? "" : "; ", escape_markup(row->solver),
                        tolerance_label(row->tol), seconds_label(row->time()),
                        error_label(rank.of(*row)));
  }
  if (!list.empty()) {
    page.add(fmt::format("<p>Beaten by none in both time and {}: {}.</p>\n", rank.name(), list));
  }
}

void add_problem(PageDraft& page, const PageContent& of, const ProblemSummary& p) {
  if (!p.defect.empty()) {
    page.add(fmt::format("<p>Not solved by anyone: {}</p>\n", escape_markup(p.defect)));
    return;
  }
  page.add(fmt::format(
      "<p class=\"small\">{}. {} contacts, d = {}. Reference by {}, guarded error "
      "{}, natural map {}.{}</p>\n",
      escape_markup(p.origin), p.contacts, p.dim,
      p.reference_solver.empty() ? "nobody" : p.reference_solver, error_label(p.reference_guarded),
      error_label(p.reference_natural_map), uniqueness(p)));
  if (p.contacts == 0) return;
  add_pareto_sentence(page, of, p);
  const Ranking rank = ranking(p, of.comparison.rows);
  const std::string replay = fmt::format(fmt::runtime(of.report.command_of_target), p.target);
  const std::string name = escape_markup(p.name);
  const std::string column = rank.measure == Ranking::Measure::kForce      ? "force_error"
                             : rank.measure == Ranking::Measure::kVelocity ? "velocity_error"
                                                                           : "guarded";
  page.add("<div class=\"grid\">\n");
  page.figure(work_precision_chart(of.comparison, p), fmt::format("Work and precision, {}.", name),
              replay, "cpu_min and " + column + " in comparison.csv");
  page.figure(tolerance_chart(of.comparison, p), fmt::format("Error against tolerance, {}.", name),
              replay, "tol and " + column + " in comparison.csv");
  const bool history = std::any_of(of.comparison.histories.begin(), of.comparison.histories.end(),
                                   [&p](const History& h) { return h.problem == p.name; });
  if (history) {
    page.figure(history_chart(of.comparison, p),
                fmt::format("Guarded error against iteration, {}.", name), replay, "history.csv");
  }
  page.add("</div>\n");
}

}  // namespace

void add_problems(PageDraft& page, const PageContent& of) {
  page.heading("problems", "Problem by problem");
  page.add(
      "<p>Open a problem for its diagrams. First: what a solver's time buys; lower left is "
      "better, one line a solver, one marker a tolerance; an empty marker did not meet its "
      "tolerance. Then what a tolerance means: the true error that comes with it. Then how the "
      "guarded error falls along one solve at the tightest tolerance that was run. <button "
      "type=\"button\" id=\"open-all\">Open all</button></p>\n");
  for (const ProblemSummary& p : of.comparison.problems) {
    const ComparisonRow* best = fastest_to(p, of.comparison.rows, 1e-2);
    page.add(fmt::format(
        "<details id=\"{}\"{}><summary><strong>{}</strong> <span class=\"small\">{} contacts{}"
        "</span></summary>\n",
        of.id_of(p), of.comparison.problems.size() <= 2 ? " open" : "", escape_markup(p.name),
        p.contacts,
        best == nullptr ? ""
                        : fmt::format(", to 1 %: {} at {}, {}", escape_markup(best->solver),
                                      tolerance_label(best->tol), seconds_label(best->time()))));
    add_problem(page, of, p);
    page.add("</details>\n");
  }
}

}  // namespace bipot
