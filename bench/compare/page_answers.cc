#include "bench/compare/page_answers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

/// A list of names with counts, most first: "ipm (12), auto (3)".
std::string ranked(const std::map<std::string, int>& counts, std::size_t longest) {
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [name, count] : counts) order.emplace_back(-count, name);
  std::sort(order.begin(), order.end());
  std::string list;
  for (std::size_t i = 0; i < order.size() && i < longest; ++i) {
    list += fmt::format("{}<strong>{}</strong> ({})", i == 0 ? "" : ", ",
                        escape_markup(order[i].second), -order[i].first);
  }
  return list.empty() ? "–" : list;
}

std::string error_word(const Ranking& rank) {
  switch (rank.measure) {
    case Ranking::Measure::kForce:
      return "force";
    case Ranking::Measure::kVelocity:
      return "velocity";
    case Ranking::Measure::kGuarded:
      return "guarded";
  }
  return "";
}

std::string best_label(const ComparisonRow& best) {
  return fmt::format("<strong>{}</strong> at {}<br>{}", escape_markup(best.solver),
                     tolerance_label(best.tol), seconds_label(best.time()));
}

}  // namespace

void add_answer(PageDraft& page, const PageContent& of) {
  page.add("<h1>Contact solvers: what accuracy costs</h1>\n");
  if (!of.comparison.complete) {
    page.add("<p><strong>This comparison was stopped; rows are missing.</strong></p>");
  }
  page.add(
      fmt::format("<p>{} problems, {} solvers. For each accuracy: on how many problems some "
                  "solver reaches it, which solvers get there first, with the number of "
                  "problems, and the tolerance that they need in the median. Errors are true "
                  "ones, measured against a reference solution.</p>\n",
                  of.comparison.problems.size(), of.solvers.size()));
  page.add(
      "<div class=\"scroll\"><table><thead><tr><th>true error</th><th class=\"n\">reached "
      "on</th><th class=\"n\">tolerance</th><th>fastest on</th></tr></thead><tbody>\n");
  for (double accuracy : kProfileAccuracies) {
    std::map<std::string, int> wins;
    std::vector<double> needed;
    for (const ProblemSummary& p : of.comparison.problems) {
      if (const ComparisonRow* best = fastest_to(p, of.comparison.rows, accuracy)) {
        ++wins[best->solver];
        needed.push_back(best->tol);
      }
    }
    std::sort(needed.begin(), needed.end());
    page.add(fmt::format(
        "<tr><td>{}</td><td class=\"n\">{} of {}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
        accuracy_label(accuracy), needed.size(), of.comparison.problems.size(),
        needed.empty() ? "–" : tolerance_label(needed[(needed.size() - 1) / 2]), ranked(wins, 4)));
  }
  page.add("</tbody></table></div>\n");
  const Regret r = regret_of(of.comparison, "auto");
  if (!r.entries.empty()) {
    page.add(fmt::format(
        "<p>Without a choice, <strong>auto</strong> takes {} times as long as the "
        "fastest other solver in the median, and {} in nine cases of ten.</p>\n",
        ratio_label(r.median),
        std::isfinite(r.ninth_decile) ? "at most " + ratio_label(r.ninth_decile) + " times as long"
                                      : "does not solve all"));
  }
}

void add_answer_by_problem(PageDraft& page, const PageContent& of) {
  page.heading("answer", "Fastest, by problem");
  page.add(
      "<p>Each entry: the fastest solver, the tolerance that it needs for this true error, and "
      "its time.</p>\n<div class=\"scroll\"><table class=\"cards\"><thead><tr><th>problem</th>"
      "<th class=\"n\">contacts</th><th>error in</th>");
  for (double a : kProfileAccuracies) page.add(fmt::format("<th>to {}</th>", accuracy_label(a)));
  page.add("</tr></thead><tbody>\n");
  for (const ProblemSummary& p : of.comparison.problems) {
    const Ranking rank = ranking(p, of.comparison.rows);
    page.add(fmt::format(
        "<tr><td><a href=\"#{}\">{}</a>{}</td><td class=\"n\" data-label=\"contacts\">{}</td>"
        "<td data-label=\"error in\">{}</td>",
        of.id_of(p), escape_markup(p.name),
        p.several_velocities() ? " †"
        : p.poor_reference()   ? " ‡"
                               : "",
        p.contacts, error_word(rank)));
    for (double a : kProfileAccuracies) {
      const ComparisonRow* best = fastest_to(p, of.comparison.rows, a);
      page.add(fmt::format("<td data-label=\"to {}\"><span>{}</span></td>", accuracy_label(a),
                           best == nullptr ? "–" : best_label(*best)));
    }
    page.add("</tr>\n");
  }
  page.add(
      "</tbody></table></div>\n"
      "<p class=\"small\">A dash: nothing that was tried got there. † several exact "
      "answers: errors are distances to the nearest that is known. ‡ no reference with a guarded "
      "error below 1e-9: ranked by the guarded error, because a distance to none says "
      "nothing.</p>\n");
}

void add_tolerance_meaning(PageDraft& page, const PageContent& of) {
  page.heading("tolerance", "What a tolerance means");
  page.add(
      "<p>The true errors of all rows that met a tolerance, whatever the solver.</p>\n<div "
      "class=\"scroll\"><table><thead><tr><th>tolerance</th><th class=\"n\">rows</th><th "
      "class=\"n\">median error</th><th class=\"n\">90 % below</th><th "
      "class=\"n\">worst</th><th>of</th></tr></thead><tbody>\n");
  for (const ToleranceMeaning& m : tolerance_meaning(of.comparison)) {
    page.add(fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
        tolerance_label(m.tol), m.rows, error_label(m.median), error_label(m.ninth_decile),
        error_label(m.worst),
        m.rows == 0 ? "–"
                    : escape_markup(m.worst_solver) + " on " + escape_markup(m.worst_problem)));
  }
  page.add(
      "</tbody></table></div>\n<p class=\"small\">The error in the force on the worst body, or "
      "in the velocities where a problem does not know its bodies. Problems with several "
      "exact answers († above) count by the distance to the nearest, problems without a trusted "
      "reference (‡) are left out.</p>\n");
}

void add_solver_summary(PageDraft& page, const PageContent& of) {
  page.heading("solvers", "Who solves what");
  page.add("<div class=\"scroll\"><table><thead><tr><th>solver</th>");
  for (double tol : of.tols) {
    page.add(fmt::format("<th class=\"n\">solved at {}</th><th class=\"n\">time / best</th>",
                         tolerance_label(tol)));
  }
  page.add("<th class=\"n\">natural map ≤ 1e-8</th></tr></thead><tbody>\n");
  std::vector<std::vector<SolvedCount>> counts;
  for (double tol : of.tols) counts.push_back(count_solved(of.comparison, tol));
  for (std::size_t s = 0; s < of.solvers.size(); ++s) {
    page.add(fmt::format("<tr><td>{}</td>", escape_markup(of.solvers[s])));
    for (const auto& at_tol : counts) {
      page.add(fmt::format("<td class=\"n\">{} of {}</td><td class=\"n\">{}</td>", at_tol[s].solved,
                           at_tol[s].problems,
                           std::isfinite(at_tol[s].median_ratio)
                               ? fmt::format("{:.{}f}", at_tol[s].median_ratio,
                                             at_tol[s].median_ratio < 9.95 ? 1 : 0)
                               : "–"));
    }
    page.add(fmt::format("<td class=\"n\">{} of {}</td></tr>\n", counts.back()[s].by_natural_map,
                         counts.back()[s].problems));
  }
  page.add(
      "</tbody></table></div>\n<p class=\"small\">Solved: the guarded error, recomputed from the "
      "impulses, is at most the tolerance. time / best: median over the solved problems of the "
      "solver's time over the fastest solver's. Natural map: at the tightest tolerance.</p>\n");
}

}  // namespace bipot
