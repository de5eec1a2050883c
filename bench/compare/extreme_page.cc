#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bench/compare/extreme_report.h"
#include "bench/report/build_info.h"
#include "bench/report/chart.h"
#include "bench/report/labels.h"
#include "bench/report/page_style.h"

namespace bipot {
namespace {

constexpr std::string_view kMatrixRules = R"(
td.c,th.c{text-align:center;white-space:nowrap;padding:.25em .2em;border-left:1px solid #eee;
 font-size:.8rem}
td.c a{color:inherit;text-decoration:none}
.solved{background:#cfe8cf}.unsolved{background:#f6e3b4}.beyond{background:#e3dcf0}
.none{background:#d5e4f3}.refused{background:#e4e4e4}.wrong{background:#d33;color:#fff}
.key span{display:inline-block;padding:.1em .5em;margin:0 .6em .3em 0}
tr.group td{background:#f3f3f3;font-weight:600}
)";

std::string_view class_of(CellEnd end) {
  switch (end) {
    case CellEnd::kSolved:
      return "solved";
    case CellEnd::kUnsolved:
      return "unsolved";
    case CellEnd::kBeyond:
      return "beyond";
    case CellEnd::kNone:
      return "none";
    case CellEnd::kRefused:
      return "refused";
    case CellEnd::kNotForIt:
      return "";
    default:
      return "wrong";
  }
}

std::string matrix_table(const ExtremeMatrix& m) {
  std::string html = "<div class=\"scroll\"><table><thead><tr><th>case</th>";
  for (const std::string& solver : m.solvers) {
    html += "<th class=\"c\">" + escape_markup(solver) + "</th>";
  }
  html += "<th class=\"c\">missed by auto, solved by</th></tr></thead><tbody>\n";
  std::string group;
  for (const ExtremeCase& c : m.cases) {
    if (c.group != group) {
      group = c.group;
      html += fmt::format("<tr class=\"group\"><td colspan=\"{}\">{}</td></tr>\n",
                          m.solvers.size() + 2, escape_markup(group));
    }
    html += fmt::format("<tr><td><a href=\"#{0}\">{0}</a></td>", escape_markup(c.name));
    for (const std::string& solver : m.solvers) {
      const ExtremeCell* cell = m.find(c.name, solver);
      if (cell == nullptr) {
        html += "<td class=\"c\"></td>";
        continue;
      }
      const bool figure = std::isfinite(cell->guarded) && cell->end != CellEnd::kNotForIt;
      html += fmt::format("<td class=\"c {}\" title=\"{}: {}\">{}</td>", class_of(cell->end),
                          escape_markup(cell->status), escape_markup(cell->message),
                          figure ? error_label(cell->guarded) : "");
    }
    html +=
        fmt::format("<td class=\"c\">{}</td></tr>\n", fmt::join(solved_by_others(m, c.name), ", "));
  }
  return html + "</tbody></table></div>\n";
}

std::string case_section(const ExtremeMatrix& m, std::size_t k) {
  const ExtremeCase& c = m.cases[k];
  std::string html = fmt::format("<h3 id=\"{0}\">{0}</h3><p>{1}.</p><dl>", escape_markup(c.name),
                                 escape_markup(c.what));
  html += page_term("known", escape_markup(c.known));
  if (!m.existence[k].empty()) html += page_term("proved", escape_markup(m.existence[k]));
  if (!std::isnan(m.floors[k])) {
    html +=
        page_term("rounding", fmt::format("the known answer, rounded to double precision, has the "
                                          "guarded error {}",
                                          error_label(m.floors[k])));
  }
  if (const ExtremeCell* first = m.find(c.name, m.solvers.front())) {
    ExtremeCell any = *first;
    any.solver = "NAME";
    html += page_term("again", "<code>" + escape_markup(cell_command(any)) + "</code>");
  }
  html +=
      "</dl><div class=\"scroll\"><table><thead><tr><th>solver</th><th></th><th>status</th>"
      "<th class=\"n\">guarded</th><th class=\"n\">true error</th><th class=\"n\">energy created"
      "</th><th class=\"n\">iterations</th><th class=\"n\">CPU time</th></tr></thead><tbody>\n";
  for (const std::string& solver : m.solvers) {
    const ExtremeCell* cell = m.find(c.name, solver);
    if (cell == nullptr) continue;
    const std::string steps =
        cell->steps > 1 ? fmt::format(" ({} of {} steps)", cell->steps_solved, cell->steps) : "";
    html += fmt::format(
        "<tr{}><td>{}</td><td class=\"{}\">{}</td><td title=\"{}\">{}{}</td><td class=\"n\">{}</td>"
        "<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
        "</tr>\n",
        cell->end == CellEnd::kWrong ? " class=\"bad\"" : "", escape_markup(solver),
        class_of(cell->end), to_string(cell->end), escape_markup(cell->message),
        escape_markup(cell->status), steps, error_label(cell->guarded),
        error_label(cell->true_error), error_label(cell->energy_error), cell->iterations,
        seconds_label(cell->cpu_seconds));
  }
  return html + "</tbody></table></div>\n";
}

}  // namespace

std::string to_html(const ExtremeMatrix& m) {
  const CellCounts all = count_cells(m);
  std::string html = page_head("Contact solvers at the extremes", kMatrixRules);
  html += "<h1>Contact solvers at the extremes</h1>\n";
  html += fmt::format(
      "<p>{} cases, {} solvers, each asked for a guarded error of 1e-8 within its time limit: {} cells "
      "solved, {} not solved, {} beyond double precision, {} proved to have no solution, {} wrong "
      "(false claims, NaN, crashes, hangs, energy against theory).{}</p>\n",
      m.cases.size(), m.solvers.size(), all.solved, all.unsolved, all.beyond, all.none, all.wrong,
      m.complete ? "" : " The measurement was stopped before its end.");
  html +=
      "<p class=\"key\"><span class=\"solved\">solved</span><span class=\"unsolved\">not solved, and "
      "says why</span><span class=\"beyond\">beyond double precision</span><span class=\"none\">no "
      "solution exists</span><span class=\"refused\">data refused</span><span class=\"wrong\">wrong"
      "</span></p>\n";
  html +=
      "<p class=\"small\">The figure in a cell is the guarded error of the returned impulse in quadruple "
      "precision, by code that shares nothing with the solvers. Its status and message show when the "
      "pointer rests on it. <i>Beyond double precision</i>: the exact answer, known beforehand, "
      "misses the tolerance by the rounding of its own digits. Without a figure: data that are refused "
      "(grey), problems that are too large or of too many dimensions for a solver (white).</p>\n";
  const auto missed = std::count_if(m.cases.begin(), m.cases.end(), [&](const ExtremeCase& c) {
    return !solved_by_others(m, c.name).empty();
  });
  html += fmt::format("<p>Cases that <code>auto</code> misses and another solver solves: {}.</p>\n",
                      missed);
  html += matrix_table(m);
  html += "<h2>Cases</h2>\n";
  for (std::size_t k = 0; k < m.cases.size(); ++k) html += case_section(m, k);
  html += "<h2>How this was made</h2><dl>" + page_terms(build_info()) + "</dl>\n";
  return html + page_end();
}

}  // namespace bipot
