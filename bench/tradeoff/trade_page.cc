#include "bench/tradeoff/trade_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "bench/report/chart.h"
#include "bench/report/labels.h"
#include "bench/report/page_style.h"
#include "bench/tradeoff/trade_charts.h"

namespace bipot {
namespace {

// Where a page of its own differs from the common sheet: long headings of tables may wrap, scenes
// stand apart, figures keep their distance from the tables.
constexpr const char* kPageRules = R"(
h3{font-size:1.1rem;margin:2em 0 .3em;border-bottom:1px solid #ccc;padding-bottom:.2em}
th.n{white-space:normal}
thead th{vertical-align:bottom}
.grid{margin:1em 0}
@media print{table{font-size:7.5pt}th,td{padding:.15em .3em}}
)";

std::string times_label(double ratio) {
  return std::isfinite(ratio) ? fmt::format("{:.2g} ×", ratio) : "–";
}

class Section {
 public:
  Section(const std::vector<SceneTrade>& scenes, const TradeContext& context)
      : scenes_(scenes), context_(context) {}

  std::string write() {
    std::vector<Chart> charts;
    for (const SceneTrade& s : scenes_) {
      for (CaptionedChart& made : trade_charts(s)) {
        charts.push_back(std::move(made.chart));
        captions_.push_back(std::move(made.caption));
        owners_.push_back(&s);
      }
    }
    drawn_ = to_svg(charts);
    html_ = "<div class=\"trade\">\n";
    intro();
    answers();
    for (const SceneTrade& s : scenes_) scene(s);
    html_ += "</div>\n";
    return html_;
  }

 private:
  void add(const std::string& text) { html_ += text; }

  void intro() {
    add("<p>A tolerance is worth its cost as long as the solver's error in the outcome is larger "
        "than two others: that of the time step, which a better solver cannot reduce, and, where "
        "disks fly freely, the difference of runs with small initial perturbations. Each scene "
        "below is run as a whole, at several tolerances, at several time steps, and with springs "
        "and dashpots instead of rigid contacts.</p>\n");
  }

  void answers() {
    add("<div class=\"scroll\"><table><thead><tr><th>scene</th><th class=\"n\">tolerance that is "
        "enough</th><th class=\"n\">decided by</th><th class=\"n\">CPU per simulated second</th>"
        "<th class=\"n\">tightest costs</th></tr></thead><tbody>\n");
    for (const SceneTrade& s : scenes_) {
      const bool known = s.sufficient_tol.has_value();
      add(fmt::format(
          "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
          "<td class=\"n\">{}</td></tr>\n",
          escape_markup(s.scene->name), known ? tolerance_label(*s.sufficient_tol) : "–",
          known && *s.sufficient_tol < s.tols.front() ? escape_markup(s.decided_by) : "–",
          seconds_label(s.cpu_sufficient),
          s.tols.empty() ? "–"
                         : fmt::format("{} at {}", seconds_label(s.cpu_tightest),
                                       tolerance_label(s.tols.back()))));
    }
    add("</tbody></table></div>\n");
  }

  void scene(const SceneTrade& s) {
    const Scene<2>& scene = s.scene->scene;
    add(fmt::format("<h3>{}</h3>\n<p class=\"small\">{}: {} disk{}, {:g} s in steps of {:g} s.",
                    escape_markup(s.scene->title), escape_markup(s.scene->target),
                    scene.bodies.size(), scene.bodies.size() == 1 ? "" : "s",
                    scene.num_steps * scene.step, scene.step));
    if (s.scene->replicas > 1) {
      add(fmt::format(" {} runs of each setting; their means are compared.", s.scene->replicas));
    }
    add("</p>\n<p>" + escape_markup(s.answer()) + "</p>\n");
    error_table(s);
    spring_table(s);
    add("<div class=\"grid\">\n");
    for (; next_ < drawn_.size() && owners_[next_] == &s; ++next_) {
      add("<figure>" + drawn_[next_] + "<figcaption>" + captions_[next_] + "<br><code>" +
          escape_markup(fmt::format(fmt::runtime(context_.command_of_scene), s.scene->target)) +
          "</code></figcaption></figure>\n");
    }
    add("</div>\n");
    setting_table(s);
  }

  void error_table(const SceneTrade& s) {
    if (s.tols.empty()) return;
    add("<h4>Where the error comes from</h4>\n<div class=\"scroll\"><table><thead><tr><th>outcome"
        "</th><th class=\"n\">reference</th><th class=\"n\">time step</th>");
    if (s.scene->replicas > 1) add("<th class=\"n\">nearby runs</th>");
    if (!s.other_solver.empty()) add("<th class=\"n\">other solver</th>");
    for (const double tol : s.tols) {
      add(fmt::format("<th class=\"n\">solver, {}</th>", tolerance_label(tol)));
    }
    add("<th class=\"n\">enough</th></tr></thead><tbody>\n");
    for (std::size_t q = 0; q < s.quantities.size(); ++q) {
      const TradeQuantity& quantity = s.scene->quantities[q];
      const TradeQuantityErrors& e = s.quantities[q];
      add(
          fmt::format("<tr><td title=\"{}\">{}</td><td class=\"n\" title=\"{}\">{} {}</td>"
                      "<td class=\"n\" title=\"{}\">{}</td>",
                      escape_markup(quantity.meaning), escape_markup(quantity.name),
                      escape_markup(e.reference_kind), value_label(e.reference), quantity.unit,
                      escape_markup(e.step_error_kind), compact_label(e.step_error)));
      if (s.scene->replicas > 1) {
        add(fmt::format("<td class=\"n\">{}</td>", compact_label(e.noise)));
      }
      if (!s.other_solver.empty()) {
        add(fmt::format("<td class=\"n\">{}</td>", compact_label(e.choice)));
      }
      for (const double x : e.solver_error) {
        const bool below = x <= e.bound();
        add(fmt::format("<td class=\"n{}\">{}</td>", below ? "" : " over", compact_label(x)));
      }
      add(fmt::format("<td class=\"n\">{}</td></tr>\n",
                      e.sufficient_tol ? tolerance_label(*e.sufficient_tol) : "–"));
    }
    add("</tbody></table></div>\n<p class=\"small\">Relative errors. Time step: of the scene's "
        "own, against the exact value where it is known, else from shorter steps (how: rest the "
        "pointer on it). ");
    if (s.scene->replicas > 1) {
      add("Nearby runs: twice the standard error of a difference of two means. ");
    }
    if (!s.other_solver.empty()) {
      add(
          fmt::format("Other solver: difference of {} at the tightest tolerance, where steps with "
                      "several exact answers show. ",
                      escape_markup(s.other_solver)));
    }
    add("Solver: difference to the tightest tolerance at the same time step; bold where it "
        "matters: larger than the others and than the accuracy asked for.</p>\n");
  }

  /// What springs cost and do beside rigid contacts at the tolerance that is enough.
  void spring_table(const SceneTrade& s) {
    const TradeCell* rigid = s.sufficient_cell();
    if (rigid == nullptr) return;
    std::vector<const TradeCell*> cells = {rigid};
    for (const TradeCell& cell : s.cells) {
      if (cell.setting.dem()) cells.push_back(&cell);
    }
    if (cells.size() == 1) return;
    add("<h4>Springs instead of rigid contacts</h4>\n<div class=\"scroll\"><table><thead><tr>"
        "<th>contacts</th><th class=\"n\">stiffness</th><th class=\"n\">steps per second</th>"
        "<th class=\"n\">CPU per simulated second</th><th class=\"n\">over rigid</th>"
        "<th class=\"n\">deepest overlap / radius</th><th class=\"n\">worst outcome</th></tr>"
        "</thead><tbody>\n");
    for (const TradeCell* cell : cells) {
      const bool dem = cell->setting.dem();
      const double h = s.scene->scene.step;
      std::size_t q = 0;
      const double worst = s.worst_error(*cell, &q);
      add(fmt::format(
          "<tr{}><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
          "<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
          cell->done() ? "" : " class=\"bad\"",
          escape_markup(dem ? cell->setting.label() +
                                  (cell->done() ? "" : " (" + cell->status + ")")
                            : fmt::format("rigid, {} at tolerance {}", s.solver,
                                          tolerance_label(cell->setting.tol))),
          dem ? compact_label(cell->stiffness) + " N/m" : "–",
          compact_label(dem ? cell->iterations / h : 1 / h), seconds_label(cell->cpu_per_second),
          times_label(cell->cpu_per_second / rigid->cpu_per_second),
          compact_label(cell->penetration),
          std::isfinite(worst) ? fmt::format("{}, {}", share_label(worst),
                                             escape_markup(s.scene->quantities[q].name))
                               : "–"));
    }
    add("</tbody></table></div>\n<p class=\"small\">Worst outcome: the one that is furthest from "
        "the reference. Springs are another model: where statics leaves forces open, elasticity "
        "picks others, and tangential restitution is missing; such differences are not "
        "errors.</p>\n");
  }

  void setting_table(const SceneTrade& s) {
    add("<details><summary>All settings and outcomes</summary>\n<div class=\"scroll\"><table>"
        "<thead><tr><th>setting</th><th>status</th><th class=\"n\">CPU per simulated second</th>"
        "<th class=\"n\">iterations</th><th class=\"n\">penetration</th>");
    for (const TradeQuantity& q : s.scene->quantities) {
      add(fmt::format("<th class=\"n\" title=\"{}\">{}{}</th>", escape_markup(q.meaning),
                      escape_markup(q.name), q.unit.empty() ? "" : " (" + q.unit + ")"));
    }
    add("<th class=\"n\">worst error</th></tr></thead><tbody>\n");
    for (const TradeCell& cell : s.cells) {
      std::string name = cell.setting.label();
      if (cell.setting.dem() && std::isfinite(cell.stiffness) &&
          !std::isfinite(cell.setting.stiffness)) {
        name += fmt::format(", k_n = {:.3g} N/m", cell.stiffness);
      }
      add(fmt::format(
          "<tr{}><td>{}</td><td title=\"{}\">{}</td><td class=\"n\">{}</td>"
          "<td class=\"n\">{}</td><td class=\"n\">{}</td>",
          cell.done() ? "" : " class=\"bad\"", escape_markup(name), escape_markup(cell.message),
          escape_markup(cell.status), seconds_label(cell.cpu_per_second),
          std::isfinite(cell.iterations) ? fmt::format("{:.3g}", cell.iterations) : "–",
          compact_label(cell.penetration)));
      for (const double x : cell.means) add(fmt::format("<td class=\"n\">{}</td>", value_label(x)));
      std::size_t q = 0;
      const double worst = s.worst_error(cell, &q);
      add(std::isfinite(worst)
              ? fmt::format("<td class=\"n\" title=\"{}\">{}</td></tr>\n",
                            escape_markup(s.scene->quantities[q].name), compact_label(worst))
              : "<td class=\"n\">–</td></tr>\n");
    }
    add("</tbody></table></div>\n<p class=\"small\">Iterations: mean of a step; for springs, "
        "substeps of a step. Penetration: largest overlap of the run over the smallest radius. "
        "Worst error: of the outcomes, against the reference (rest the pointer on it for which). "
        "Rows that were not completed are marked; the reason shows when the pointer rests on the "
        "status.</p></details>\n");
  }

  const std::vector<SceneTrade>& scenes_;
  const TradeContext& context_;
  std::vector<std::string> drawn_, captions_;
  std::vector<const SceneTrade*> owners_;
  std::size_t next_ = 0;
  std::string html_;
};

}  // namespace

std::string trade_style() {
  return R"(
.trade h4{font-size:.95rem;margin:1.2em 0 .3em}
.trade td.over{font-weight:700}
.trade details{margin:1em 0}
.trade summary{cursor:pointer}
)";
}

std::string trade_section(const AnalysedTrade& analysed, const TradeContext& context) {
  return Section(analysed.scenes, context).write();
}

std::string trade_page(const AnalysedTrade& analysed, const TradeContext& context) {
  std::string page =
      page_head("Whole simulations: tolerance, time step, model", kPageRules + trade_style());
  page += "<h1>What a tolerance, a time step and a model buy over a whole simulation</h1>\n";
  if (!analysed.trade.complete) {
    page += "<p><strong>This run was interrupted; rows are missing.</strong></p>\n";
  }
  page += trade_section(analysed, context);
  page += "<h2>How this was made</h2>\n<dl>";
  page += page_term("command", "<code>" + escape_markup(context.command) + "</code>");
  page += page_terms(context.build);
  page += page_term("limit", fmt::format("{:g} s of CPU time for one run", context.time_limit));
  page += page_term("date", context.date);
  page +=
      "</dl>\n<p class=\"small\">Every run and outcome stands in trade.csv and trade.json beside "
      "this page.</p>\n";
  return page + page_end();
}

}  // namespace bipot
