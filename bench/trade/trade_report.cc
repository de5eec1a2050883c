#include "bench/trade/trade_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/report/chart.h"
#include "bench/report/csv_text.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

std::string cell_text(const std::string& pattern, double x) {
  return std::isfinite(x) ? fmt::format(fmt::runtime(pattern), x) : "–";
}
/// 1.2e-3 and not 1.2e-03; 0 stays 0.
std::string error_text(double x) {
  if (x == 0) return "0";
  if (!std::isfinite(x)) return "–";
  const std::string text = fmt::format("{:.1e}", x);
  const std::size_t e = text.find('e');
  return fmt::format("{}e{}", text.substr(0, e), std::stoi(text.substr(e + 1)));
}
/// Per cent, where that is short.
std::string share_text(double x) {
  return x >= 1e-4 ? fmt::format("{:.2g} %", 100 * x) : error_text(x);
}
std::string value_text(double x) { return cell_text("{:.4g}", x); }
std::string model_name(const TradeSetting& s) { return s.dem() ? "dem" : "nscd"; }

const TradeCell* sufficient_cell(const SceneTrade& s) {
  if (s.tols.empty()) return nullptr;
  return s.find({.solver = s.solver, .tol = s.sufficient_tol.value_or(s.tols.back())});
}

/// What springs cost and do beside the rigid model at the tolerance that is enough.
std::string springs_sentence(const SceneTrade& s) {
  const TradeCell* rigid = sufficient_cell(s);
  if (rigid == nullptr) return {};
  std::string text;
  for (const TradeCell& cell : s.cells) {
    if (!cell.setting.dem()) continue;
    if (!text.empty()) text += "; ";
    const std::string name = std::isfinite(cell.setting.overlap)
                                 ? fmt::format("overlap {}", tolerance_label(cell.setting.overlap))
                                 : fmt::format("k_n = {:.3g} N/m", cell.setting.stiffness);
    if (!cell.done()) {
      text += fmt::format("{}: {}", name, cell.status);
      continue;
    }
    std::size_t q = 0;
    const double error = s.worst_error(cell, &q);
    text +=
        fmt::format("{}: {:.2g} times the cost", name, cell.cpu_per_second / rigid->cpu_per_second);
    if (std::isfinite(error)) {
      text += fmt::format(", {} {} away", s.scene->quantities[q].name, share_text(error));
    }
  }
  if (text.empty()) return {};
  return fmt::format("Springs beside {} at tolerance {}: {}.", s.solver,
                     tolerance_label(rigid->setting.tol), text);
}

Json setting_json(const TradeSetting& s) {
  return {{"model", model_name(s)},       {"solver", s.dem() ? Json(nullptr) : Json(s.solver)},
          {"tol", number(s.tol)},         {"step_factor", s.step_factor},
          {"overlap", number(s.overlap)}, {"stiffness_asked", number(s.stiffness)}};
}

class Section {
 public:
  Section(const std::vector<SceneTrade>& scenes, const TradeContext& context)
      : scenes_(scenes), context_(context) {}

  std::string write() {
    std::vector<Chart> charts;
    for (const SceneTrade& s : scenes_) add_charts(s, charts);
    drawn_ = to_svg(charts);
    charts_ = std::move(charts);
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
        "than two others: that of the time step, which a better solver cannot mend, and what runs "
        "differ by that begin with tiny kicks, where disks fly freely. Each scene below is run as "
        "a "
        "whole, at several tolerances, at several time steps, and with springs and dashpots "
        "instead of rigid contacts.</p>\n");
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
    const Scene& scene = s.scene->scene;
    add(fmt::format("<h3>{}</h3>\n<p class=\"small\">{}: {} disk{}, {:g} s in steps of {:g} s.",
                    escape_markup(s.scene->title), escape_markup(s.scene->target),
                    scene.disks.size(), scene.disks.size() == 1 ? "" : "s",
                    scene.num_steps * scene.step, scene.step));
    if (s.scene->replicas > 1) {
      add(fmt::format(" {} runs of each setting; their means are compared.", s.scene->replicas));
    }
    add("</p>\n<p>" + escape_markup(s.answer()) + "</p>\n");
    error_table(s);
    spring_table(s);
    add("<div class=\"grid\">\n");
    for (; next_ < charts_.size() && owners_[next_] == &s; ++next_) {
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
                      escape_markup(e.reference_kind), value_text(e.reference), quantity.unit,
                      escape_markup(e.step_error_kind), error_text(e.step_error)));
      if (s.scene->replicas > 1) {
        add(fmt::format("<td class=\"n\">{}</td>", error_text(e.noise)));
      }
      for (const double x : e.solver_error) {
        const bool below = x <= e.bound();
        add(fmt::format("<td class=\"n{}\">{}</td>", below ? "" : " over", error_text(x)));
      }
      add(fmt::format("<td class=\"n\">{}</td></tr>\n",
                      e.sufficient_tol ? tolerance_label(*e.sufficient_tol) : "–"));
    }
    add("</tbody></table></div>\n<p class=\"small\">Relative errors. Time step: of the scene's "
        "own, "
        "against the exact value where it is known, else from shorter steps (how: rest the pointer "
        "on it). ");
    if (s.scene->replicas > 1) {
      add("Nearby runs: twice the standard error of a difference of two means. ");
    }
    add("Solver: difference to the tightest tolerance at the same time step; bold where it "
        "matters: "
        "larger than the others and than the accuracy asked for.</p>\n");
  }

  /// What springs cost and do beside rigid contacts at the tolerance that is enough.
  void spring_table(const SceneTrade& s) {
    const TradeCell* rigid = sufficient_cell(s);
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
          dem ? error_text(cell->stiffness) + " N/m" : "–",
          error_text(dem ? cell->iterations / h : 1 / h), seconds_label(cell->cpu_per_second),
          cell_text("{:.2g} ×", cell->cpu_per_second / rigid->cpu_per_second),
          error_text(cell->penetration),
          std::isfinite(worst)
              ? fmt::format("{}, {}", share_text(worst), escape_markup(s.scene->quantities[q].name))
              : "–"));
    }
    add("</tbody></table></div>\n<p class=\"small\">Worst outcome: the one that is furthest from "
        "the reference. Springs are another model: where statics leaves forces open, elasticity "
        "picks "
        "others, and tangential restitution is missing; such differences are not errors.</p>\n");
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
          cell_text("{:.3g}", cell.iterations), error_text(cell.penetration)));
      for (const double x : cell.means) add(fmt::format("<td class=\"n\">{}</td>", value_text(x)));
      std::size_t q = 0;
      const double worst = s.worst_error(cell, &q);
      add(std::isfinite(worst)
              ? fmt::format("<td class=\"n\" title=\"{}\">{}</td></tr>\n",
                            escape_markup(s.scene->quantities[q].name), error_text(worst))
              : "<td class=\"n\">–</td></tr>\n");
    }
    add("</tbody></table></div>\n<p class=\"small\">Iterations: mean of a step; for springs, "
        "substeps of a step. Penetration: largest overlap of the run over the smallest radius. "
        "Worst error: of the outcomes, against the reference (rest the pointer on it for which). "
        "Rows that were not completed are marked; the reason shows when the pointer rests on the "
        "status.</p></details>\n");
  }

  void keep(const SceneTrade& s, Chart chart, std::string caption, std::vector<Chart>& charts) {
    bool empty = true;
    for (const ChartSeries& series : chart.series) empty &= series.points.empty();
    if (empty) return;
    charts.push_back(std::move(chart));
    captions_.push_back(std::move(caption));
    owners_.push_back(&s);
  }

  void add_charts(const SceneTrade& s, std::vector<Chart>& charts) {
    Chart ratio;
    ratio.title = "Solver error over the others, " + s.scene->name;
    ratio.x = {"tolerance", ChartAxis::Kind::kLog};
    ratio.y = {"solver's error / other errors", ChartAxis::Kind::kLog, 1e-4};
    ratio.y_line = 1;
    ratio.y_line_label = "as large as the others";
    bool any = false;  // else there is nothing to see
    for (std::size_t q = 0; q < s.quantities.size(); ++q) {
      const TradeQuantityErrors& e = s.quantities[q];
      const double other = e.bound();
      if (!(other > 0)) continue;
      ChartSeries series{s.scene->quantities[q].name, static_cast<int>(q), {}};
      // The tightest is the reference of the others.
      for (std::size_t k = 0; k + 1 < s.tols.size(); ++k) {
        series.points.push_back(
            {s.tols[k], e.solver_error[k] / other, false,
             fmt::format("{} at {}: solver {:.1e}, others {:.1e}", series.name,
                         tolerance_label(s.tols[k]), e.solver_error[k], other)});
      }
      any |=
          std::any_of(e.solver_error.begin(), e.solver_error.end(), [](double x) { return x > 0; });
      ratio.series.push_back(std::move(series));
    }
    if (!any) ratio.series.clear();
    keep(s, std::move(ratio), "Below the line the solver is better than the outcome needs.",
         charts);

    Chart error, depth;
    error.title = "Error of the outcome against cost, " + s.scene->name;
    error.x = {"CPU time per simulated second", ChartAxis::Kind::kLogSeconds};
    error.y = {"worst error of an outcome", ChartAxis::Kind::kLog};
    depth.title = "Penetration against cost, " + s.scene->name;
    depth.x = error.x;
    depth.y = {"largest overlap / smallest radius", ChartAxis::Kind::kLog};
    struct Family {
      std::string name;
      int style;
      std::function<bool(const TradeSetting&)> has;
    };
    std::vector<Family> families;
    std::vector<std::string> solvers;
    for (const TradeCell& cell : s.cells) {
      const std::string& name = cell.setting.solver;
      if (!name.empty() && std::find(solvers.begin(), solvers.end(), name) == solvers.end()) {
        solvers.push_back(name);
      }
    }
    for (const std::string& name : solvers) {
      families.push_back(
          {name + ", tolerances", static_cast<int>(families.size()), [name](const TradeSetting& x) {
             return !x.dem() && x.solver == name && x.step_factor == 1;
           }});
    }
    families.push_back(
        {s.solver + ", time steps", static_cast<int>(families.size()), [&s](const TradeSetting& x) {
           return !x.dem() && x.solver == s.solver && x.tol == s.step_tol;
         }});
    families.push_back({"springs, stiffness", static_cast<int>(families.size()),
                        [](const TradeSetting& x) { return x.dem(); }});
    double noise = 0;
    for (const TradeQuantityErrors& e : s.quantities) noise = std::max(noise, e.noise);
    for (const Family& family : families) {
      ChartSeries in_error{family.name, family.style, {}}, in_depth = in_error;
      std::vector<const TradeCell*> cells;
      for (const TradeCell& cell : s.cells) {
        if (family.has(cell.setting) && cell.done()) cells.push_back(&cell);
      }
      // Along the family's own parameter, not in the order of the runs.
      std::stable_sort(cells.begin(), cells.end(), [](const TradeCell* a, const TradeCell* b) {
        return a->setting.step_factor > b->setting.step_factor;
      });
      for (const TradeCell* cell : cells) {
        std::size_t q = 0;
        const double worst = s.worst_error(*cell, &q);
        const std::string note = fmt::format("{}: {} per simulated second", cell->setting.label(),
                                             seconds_label(cell->cpu_per_second));
        if (worst > 0) {
          in_error.points.push_back(
              {cell->cpu_per_second, worst, false,
               note + fmt::format(", {} {:.1e}", s.scene->quantities[q].name, worst)});
        }
        if (cell->penetration > 0) {
          in_depth.points.push_back({cell->cpu_per_second, cell->penetration, false,
                                     note + fmt::format(", overlap {:.1e}", cell->penetration)});
        }
      }
      if (!in_error.points.empty()) error.series.push_back(std::move(in_error));
      if (!in_depth.points.empty()) depth.series.push_back(std::move(in_depth));
    }
    if (noise > 0) {
      error.y_line = noise;
      error.y_line_label = "nearby runs";
    }
    keep(
        s, std::move(error),
        "What cost buys: the outcome that is furthest from the reference. The reference itself has "
        "no marker.",
        charts);
    keep(s, std::move(depth), "How deep bodies enter each other, and what that costs.", charts);
  }

  const std::vector<SceneTrade>& scenes_;
  const TradeContext& context_;
  std::vector<Chart> charts_;
  std::vector<std::string> drawn_, captions_;
  std::vector<const SceneTrade*> owners_;
  std::size_t next_ = 0;
  std::string html_;
};

}  // namespace

nlohmann::ordered_json to_json(const Trade& trade, const TradeContext& context) {
  Json scenes = Json::array();
  for (const SceneTrade& s : analyse_trade(trade)) {
    Json outcomes = Json::array();
    for (std::size_t q = 0; q < s.quantities.size(); ++q) {
      const TradeQuantity& quantity = s.scene->quantities[q];
      const TradeQuantityErrors& e = s.quantities[q];
      Json solver = Json::array();
      for (std::size_t k = 0; k < e.solver_error.size(); ++k) {
        solver.push_back({{"tol", s.tols[k]}, {"error", number(e.solver_error[k])}});
      }
      outcomes.push_back(
          {{"name", quantity.name},
           {"unit", quantity.unit},
           {"meaning", quantity.meaning},
           {"exact", number(quantity.exact)},
           {"reference", number(e.reference)},
           {"reference_kind", e.reference_kind},
           {"step_error", number(e.step_error)},
           {"step_error_kind", e.step_error_kind},
           {"noise", number(e.noise)},
           {"solver_errors", solver},
           {"sufficient_tol", e.sufficient_tol ? Json(*e.sufficient_tol) : Json(nullptr)}});
    }
    Json cells = Json::array();
    for (const TradeCell& cell : s.cells) {
      Json c = setting_json(cell.setting);
      c["status"] = cell.status;
      c["message"] = cell.message;
      c["runs"] = cell.runs;
      c["completed"] = cell.completed;
      c["cpu_per_simulated_second"] = number(cell.cpu_per_second);
      c["iterations"] = number(cell.iterations);
      c["penetration"] = number(cell.penetration);
      c["worst_guarded"] = number(cell.worst_guarded);
      c["stiffness"] = number(cell.stiffness);
      Json means = Json::object(), errors = Json::object();
      for (std::size_t q = 0; q < cell.means.size(); ++q) {
        means[s.scene->quantities[q].name] = number(cell.means[q]);
        errors[s.scene->quantities[q].name] = number(s.error(cell, q));
      }
      c["outcomes"] = means;
      c["errors"] = errors;
      cells.push_back(std::move(c));
    }
    scenes.push_back(
        {{"name", s.scene->name},
         {"target", s.scene->target},
         {"title", s.scene->title},
         {"replicas", s.scene->replicas},
         {"step", s.scene->scene.step},
         {"duration", s.scene->scene.num_steps * s.scene->scene.step},
         {"answer", s.answer()},
         {"sufficient_tol", s.sufficient_tol ? Json(*s.sufficient_tol) : Json(nullptr)},
         {"step_tol", number(s.step_tol)},
         {"outcomes", outcomes},
         {"settings", cells}});
  }
  Json rows = Json::array();
  for (const TradeRow& r : trade.rows) {
    Json row{{"scene", r.scene}, {"replica", r.replica}};
    row.update(setting_json(r.setting));
    row.update(Json{{"status", r.status},
                    {"message", r.message},
                    {"step", r.step},
                    {"steps", r.steps},
                    {"steps_planned", r.steps_planned},
                    {"steps_converged", r.steps_converged},
                    {"simulated_seconds", r.simulated},
                    {"cpu_seconds", number(r.cpu)},
                    {"iterations_mean", number(r.iterations)},
                    {"worst_guarded", number(r.worst_guarded)},
                    {"stiffness", number(r.stiffness)},
                    {"penetration", number(r.penetration)}});
    Json values = Json::array();
    for (const double x : r.values) values.push_back(number(x));
    row["values"] = values;
    rows.push_back(std::move(row));
  }
  return {{"command", "trade"},
          {"version", context.build.version},
          {"commit", context.build.commit},
          {"compiler", context.build.compiler},
          {"flags", context.build.flags},
          {"cpu", context.build.cpu},
          {"date", context.date},
          {"command_line", context.command},
          {"time_limit", context.time_limit},
          {"complete", trade.complete},
          {"scenes", scenes},
          {"rows", rows}};
}

std::string to_csv(const Trade& trade) {
  std::string text =
      "scene,model,solver,tol,step_factor,overlap,stiffness [N/m],replica,status,step [s],steps,"
      "steps_planned,steps_converged,simulated [s],cpu [s],iterations_mean,worst_guarded,"
      "penetration,outcome,unit,value,message\n";
  for (const TradeRow& r : trade.rows) {
    const auto scene = std::find_if(trade.scenes.begin(), trade.scenes.end(),
                                    [&](const TradeScene& s) { return s.name == r.scene; });
    for (std::size_t q = 0; q < r.values.size(); ++q) {
      text += fmt::format(
          "{},{},{},{:.17g},{:.17g},{:.17g},{:.17g},{},{},{:.17g},{},{},{},{:.17g},{:.6g},{:.17g},"
          "{:.17g},{:.17g},{},{},{:.17g},{}\n",
          csv_text(r.scene), model_name(r.setting), r.setting.solver, r.setting.tol,
          r.setting.step_factor, r.setting.overlap, r.stiffness, r.replica, r.status, r.step,
          r.steps, r.steps_planned, r.steps_converged, r.simulated, r.cpu, r.iterations,
          r.worst_guarded, r.penetration, csv_text(scene->quantities[q].name),
          scene->quantities[q].unit, r.values[q], csv_text(r.message));
    }
  }
  return text;
}

std::string to_text(const Trade& trade) {
  std::string text;
  for (const SceneTrade& s : analyse_trade(trade)) {
    text += fmt::format("{}\n  {}\n", s.scene->title, s.answer());
    if (const std::string springs = springs_sentence(s); !springs.empty()) {
      text += "  " + springs + "\n";
    }
    text += fmt::format("  {:<32} {:<14} {:>12} {:>10} {:>11}  {}\n", "setting", "status",
                        "CPU s / s", "iter.", "overlap / r", "worst error");
    for (const TradeCell& cell : s.cells) {
      std::size_t q = 0;
      const double worst = s.worst_error(cell, &q);
      text += fmt::format("  {:<32} {:<14} {:>12} {:>10} {:>11}  {}\n", cell.setting.label(),
                          cell.status, cell_text("{:.3g}", cell.cpu_per_second),
                          cell_text("{:.3g}", cell.iterations), error_text(cell.penetration),
                          std::isfinite(worst)
                              ? fmt::format("{} {}", error_text(worst), s.scene->quantities[q].name)
                              : "–");
    }
    if (!s.tols.empty()) {
      text += fmt::format("  {:<16} {:>12} {:>10} {:>10}  solver's error at", "outcome",
                          "reference", "time step", "noise");
      for (const double tol : s.tols) text += fmt::format(" {:>8}", tolerance_label(tol));
      text += "\n";
      for (std::size_t k = 0; k < s.quantities.size(); ++k) {
        const TradeQuantityErrors& e = s.quantities[k];
        text +=
            fmt::format("  {:<16} {:>12} {:>10} {:>10}  {:17}", s.scene->quantities[k].name,
                        value_text(e.reference), error_text(e.step_error), error_text(e.noise), "");
        for (const double x : e.solver_error) text += fmt::format(" {:>8}", error_text(x));
        text += "\n";
      }
    }
    text += "\n";
  }
  return text;
}

std::string trade_style() {
  return R"(
.trade h4{font-size:.95rem;margin:1.2em 0 .3em}
.trade td.over{font-weight:700}
.trade details{margin:1em 0}
.trade summary{cursor:pointer}
)";
}

std::string trade_section(const Trade& trade, const TradeContext& context) {
  const std::vector<SceneTrade> scenes = analyse_trade(trade);
  return Section(scenes, context).write();
}

std::string trade_page(const Trade& trade, const TradeContext& context) {
  std::string page = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width,initial-scale=1">
<title>Whole simulations: tolerance, time step, model</title>
<style>
:root{color-scheme:light}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1180px;padding:16px;font:15px/1.5 system-ui,sans-serif;color:#1b1b1b;
 background:#fff}
h1{font-size:1.5rem;line-height:1.2;margin:.4em 0}
h2{font-size:1.2rem;margin:2em 0 .4em;border-bottom:1px solid #ccc;padding-bottom:.2em}
h3{font-size:1.1rem;margin:2em 0 .3em;border-bottom:1px solid #ccc;padding-bottom:.2em}
p,li{max-width:46em}
code{font:.88em ui-monospace,monospace;background:#f3f3f3;padding:.1em .3em;overflow-wrap:anywhere}
.small{color:#555;font-size:.87rem}
.scroll{overflow-x:auto;border:1px solid #ddd}
table{border-collapse:separate;border-spacing:0;font-variant-numeric:tabular-nums;font-size:.87rem;
 width:100%}
th,td{padding:.3em .6em;text-align:left;border-bottom:1px solid #e6e6e6;vertical-align:top}
td.n,th.n{text-align:right}
td.n{white-space:nowrap}
thead th{background:#f3f3f3;vertical-align:bottom}
th:first-child,td:first-child{position:sticky;left:0;background:#fff}
thead th:first-child{background:#f3f3f3}
tr.bad td{color:#8a1c00}
tr.bad td:first-child{box-shadow:inset 3px 0 #8a1c00}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr));
 gap:12px 28px;margin:1em 0}
figure{margin:0;break-inside:avoid;min-width:0}
figure svg{display:block;width:100%;max-width:560px;height:auto}
figcaption{font-size:.87rem;color:#333;max-width:560px}
dl{display:grid;grid-template-columns:minmax(7em,max-content) 1fr;gap:.3em 1em}
dt{font-weight:600}dd{margin:0;max-width:42em}
@media(max-width:600px){body{padding:10px}dl{display:block}dd{margin:0 0 .5em}}
@media print{body{max-width:none;padding:0;font-size:10pt}.scroll{overflow:visible;border:0}
 th:first-child,td:first-child{position:static}table{font-size:7.5pt}th,td{padding:.15em .3em}
 h2,h3,h4{break-after:avoid}tr{break-inside:avoid}}
)";
  page += trade_style() +
          "</style></head><body>\n<h1>What a tolerance, a time step and a model buy "
          "over a whole simulation</h1>\n";
  if (!trade.complete)
    page += "<p><strong>This run was interrupted; rows are missing.</strong></p>\n";
  page += trade_section(trade, context);
  page += "<h2>How this was made</h2>\n<dl>";
  const auto item = [&](const char* name, const std::string& value) {
    page += fmt::format("<dt>{}</dt><dd>{}</dd>", name, value);
  };
  item("command", "<code>" + escape_markup(context.command) + "</code>");
  item("program", fmt::format("bipot {}, commit {}", context.build.version,
                              escape_markup(context.build.commit)));
  item("compiler", escape_markup(context.build.compiler));
  item("flags", "<code>" + escape_markup(context.build.flags) + "</code>");
  item("machine", fmt::format("{}, {} logical cores, 1 used", escape_markup(context.build.cpu),
                              context.build.cores));
  item("limit", fmt::format("{:g} s of CPU time for one run", context.time_limit));
  item("date", context.date);
  page +=
      "</dl>\n<p class=\"small\">Every run and outcome stands in trade.csv and trade.json "
      "beside this page.</p>\n</body></html>\n";
  return page;
}

}  // namespace bipot
