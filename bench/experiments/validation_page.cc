#include "bench/experiments/validation_page.h"

#include <fmt/format.h>

#include <cmath>

#include "bench/experiments/validation_report.h"
#include "bench/report/build_info.h"
#include "bench/report/labels.h"
#include "bench/report/page_style.h"

namespace bipot {
namespace {

constexpr std::string_view kValidationRules = R"(
.yes{color:#1d5c2e;white-space:nowrap}
.no{color:#8a1c00;font-weight:600}
td.q{min-width:15em;white-space:normal}
td.why{min-width:18em;white-space:normal}
td.src{min-width:11em;white-space:normal;font-size:.85em}
figure img{display:block;max-width:100%;height:auto}
figcaption{font-size:.9rem;max-width:52em}
)";

std::string measured_text(const ValidationPoint& p) {
  return p.seen.bar > 0
             ? fmt::format("{} ± {}", value_label(p.seen.value), compact_label(p.seen.bar))
             : value_label(p.seen.value);
}

std::string row_line(const ValidationVerdict& v) {
  const ValidationPoint* p = v.measured();
  std::string note;
  if (p != nullptr) {
    note = fmt::format("<br><span class=\"small\">{}{}{}</span>",
                       v.row.takes_tolerance ? "at ε = " + tolerance_label(p->tol) : "no ε",
                       p->seen.note.empty() ? "" : "; ", escape_markup(p->seen.note));
  }
  return fmt::format(
      "<tr id=\"{}\"><td class=\"q\">{}<br><code>{}</code></td><td class=\"src\">{}</td>"
      "<td class=\"src\">{}</td><td class=\"n\">{}{}</td><td class=\"src\">{}</td>"
      "<td class=\"n\">{}</td><td class=\"why\">{}</td><td class=\"n\">{}</td>"
      "<td class=\"n\">{}{}</td></tr>\n",
      v.row.name, escape_markup(v.row.quantity), v.row.name, escape_markup(v.row.source),
      escape_markup(v.row.formula), p == nullptr ? "–" : measured_text(*p), note,
      escape_markup(v.row.bar), p == nullptr ? "–" : compact_label(p->error),
      v.holds
          ? fmt::format("<span class=\"yes\">✓ holds</span><br><span class=\"small\">{} allowed: "
                        "{}</span>",
                        compact_label(v.row.allowed), escape_markup(v.row.allowed_why))
          : fmt::format("<span class=\"no\">{}</span><br>{}",
                        v.undecided ? "undecided" : "✗ does not hold", escape_markup(v.reason)),
      !v.row.takes_tolerance  ? "no ε"
      : std::isnan(v.loosest) ? "none"
                              : tolerance_label(v.loosest),
      duration_label(v.seconds),
      v.shared > 1 ? fmt::format("<br><span class=\"small\">for {} rows</span>", v.shared) : "");
}

std::string group_table(const ValidationPage& page, const std::string& group) {
  std::string html =
      "<div class=\"scroll\"><table><thead><tr><th>observable</th><th>source</th><th>expected</th>"
      "<th class=\"n\">measured</th><th>error bar</th><th class=\"n\">relative error</th><th>verdict"
      "</th><th class=\"n\">right from ε =</th><th class=\"n\">CPU</th></tr></thead><tbody>\n";
  for (const ValidationVerdict& v : page.verdicts) {
    if (v.row.group == group) html += row_line(v);
  }
  return html + "</tbody></table></div>\n";
}

/// Every tolerance of every row of a group.
std::string points_table(const ValidationPage& page, const std::string& group) {
  std::string html =
      "<details><summary>every tolerance</summary><div class=\"scroll\"><table><thead><tr><th>row"
      "</th><th class=\"n\">ε</th><th class=\"n\">measured</th><th class=\"n\">relative error</th>"
      "<th>right</th><th class=\"n\">steps</th><th class=\"n\">not solved</th><th class=\"n\">CPU</th>"
      "<th>note</th></tr></thead><tbody>\n";
  for (const ValidationVerdict& v : page.verdicts) {
    if (v.row.group != group) continue;
    for (const ValidationPoint& p : v.points) {
      html += fmt::format(
          "<tr{}><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
          "<td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td>"
          "</tr>\n",
          p.failure.empty() ? "" : " class=\"bad\"", v.row.name, tolerance_label(p.tol),
          measured_text(p), compact_label(p.error), p.right ? "✓" : "✗", p.steps, p.unsolved,
          seconds_label(p.seconds), escape_markup(p.failure.empty() ? p.seen.note : p.failure));
    }
  }
  return html + "</tbody></table></div></details>\n";
}

std::string figure(const std::string& name, const std::string& title, const std::string& caption) {
  return fmt::format(
      "<figure><a href=\"{0}.svg\"><img src=\"{0}.svg\" alt=\"{1}\"></a><figcaption>{2} "
      "<a href=\"{0}.csv\">Data</a>, <a href=\"{0}.gp\">script</a>.</figcaption></figure>\n",
      escape_markup(name), escape_markup(title), escape_markup(caption));
}

}  // namespace

std::string to_html(const ValidationPage& page) {
  std::string html = page_head("Bipot: physics, checked", kValidationRules);
  html += "<h1>Physics, checked: at which tolerance does it break?</h1>\n";
  html += fmt::format(
      "<p>{} of {} rows hold, {} are undecided.{} Each row is an observable that theory, a proof, or published work "
      "says something of. It is measured with every step solved by <code>{}</code> (without islands) to "
      "the guarded error ε, for several ε.</p>\n",
      page.held(), page.verdicts.size(), page.undecided(),
      page.complete ? "" : " The measurement was stopped before its end.",
      escape_markup(page.solver));
  html +=
      "<p><b>Verdict</b>: at the tightest ε that the steps reached (all but 1 % of them), the relative error is at most "
      "what is allowed (the reason stands there) and the error bar. <b>Right from</b>: the loosest ε "
      "from which on the error is at most 1 % (or what is allowed, if that is more) and the bar, at that "
      "and all tighter ones. A bar of more than half the scale decides nothing. For bounds the error is the distance outside, 0 inside. In the figures, "
      "hollow marks are runs in which more than 1 % of the steps missed ε; an error of 0 stands on the axis. "
      "Values of which only memory, no readable source, is at hand are not tested: of those, the "
      "exponent or a bound that is derived.</p>\n";
  if (page.quick) {
    html +=
        "<p>This is the short form (<code>--quick</code>): fewer bodies, seeds and tolerances. Statistical "
        "rows have wide bars.</p>\n";
  }
  html += "<p>";
  for (const std::string& group : groups_of(page)) {
    html += fmt::format("<a href=\"#{}\">{}</a> · ", error_chart_name(page, group),
                        escape_markup(group));
  }
  html += "<a href=\"validate.csv\">all numbers</a>, <a href=\"verdicts.csv\">verdicts</a></p>\n";
  for (const std::string& group : groups_of(page)) {
    const std::string name = error_chart_name(page, group);
    html += fmt::format("<h2 id=\"{}\">{}</h2>\n", name, escape_markup(group));
    html += group_table(page, group);
    html += figure(name, "relative error against tolerance",
                   "Relative error of each observable against the tolerance of the steps.");
    for (const ValidationFigure& f : page.figures) {
      if (f.group == group) html += figure(f.name, f.chart.title, f.caption);
    }
    html += points_table(page, group);
  }
  html += "<h2>How this was made</h2><dl>" +
          page_term("command", "<code>" + escape_markup(page.command) + "</code>") +
          page_terms(build_info()) + page_term("date", date_and_time()) + "</dl>\n";
  return html + page_end();
}

}  // namespace bipot
