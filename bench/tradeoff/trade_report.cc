#include "bench/tradeoff/trade_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/report/csv_text.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

std::string three_digits(double x) { return std::isfinite(x) ? fmt::format("{:.3g}", x) : "–"; }
std::string model_name(const TradeSetting& s) { return s.dem() ? "dem" : "nscd"; }

/// What springs cost and do beside the rigid model at the tolerance that is enough.
std::string springs_sentence(const SceneTrade& s) {
  const TradeCell* rigid = s.sufficient_cell();
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
      text += fmt::format(", {} {} away", s.scene->quantities[q].name, share_label(error));
    }
  }
  if (text.empty()) return {};
  return fmt::format("Springs beside {} at tolerance {}: {}.", s.solver,
                     tolerance_label(rigid->setting.tol), text);
}

Json setting_json(const TradeSetting& s) {
  return {{"model", model_name(s)}, {"solver", s.dem() ? Json(nullptr) : Json(s.solver)},
          {"tol", s.tol},           {"step_factor", s.step_factor},
          {"overlap", s.overlap},   {"stiffness_asked", s.stiffness}};
}

Json outcomes_json(const SceneTrade& s) {
  Json outcomes = Json::array();
  for (std::size_t q = 0; q < s.quantities.size(); ++q) {
    const TradeQuantity& quantity = s.scene->quantities[q];
    const TradeQuantityErrors& e = s.quantities[q];
    Json solver = Json::array();
    for (std::size_t k = 0; k < e.solver_error.size(); ++k) {
      solver.push_back({{"tol", s.tols[k]}, {"error", e.solver_error[k]}});
    }
    outcomes.push_back(
        {{"name", quantity.name},
         {"unit", quantity.unit},
         {"meaning", quantity.meaning},
         {"exact", quantity.exact},
         {"reference", e.reference},
         {"reference_kind", e.reference_kind},
         {"step_error", e.step_error},
         {"step_error_kind", e.step_error_kind},
         {"noise", e.noise},
         {"choice", e.choice},
         {"solver_errors", solver},
         {"sufficient_tol", e.sufficient_tol ? Json(*e.sufficient_tol) : Json(nullptr)}});
  }
  return outcomes;
}

Json cells_json(const SceneTrade& s) {
  Json cells = Json::array();
  for (const TradeCell& cell : s.cells) {
    Json c = setting_json(cell.setting);
    c["status"] = cell.status;
    c["message"] = cell.message;
    c["runs"] = cell.runs;
    c["completed"] = cell.completed;
    c["cpu_per_simulated_second"] = cell.cpu_per_second;
    c["iterations"] = cell.iterations;
    c["penetration"] = cell.penetration;
    c["worst_guarded"] = cell.worst_guarded;
    c["stiffness"] = cell.stiffness;
    Json means = Json::object(), errors = Json::object();
    for (std::size_t q = 0; q < cell.means.size(); ++q) {
      means[s.scene->quantities[q].name] = cell.means[q];
      errors[s.scene->quantities[q].name] = s.error(cell, q);
    }
    c["outcomes"] = means;
    c["errors"] = errors;
    cells.push_back(std::move(c));
  }
  return cells;
}

Json scene_json(const SceneTrade& s) {
  return {{"name", s.scene->name},
          {"target", s.scene->target},
          {"title", s.scene->title},
          {"replicas", s.scene->replicas},
          {"step", s.scene->scene.step},
          {"duration", s.scene->scene.num_steps * s.scene->scene.step},
          {"answer", s.answer()},
          {"sufficient_tol", s.sufficient_tol ? Json(*s.sufficient_tol) : Json(nullptr)},
          {"step_tol", s.step_tol},
          {"outcomes", outcomes_json(s)},
          {"settings", cells_json(s)}};
}

Json rows_json(const Trade& trade) {
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
                    {"cpu_seconds", r.cpu},
                    {"iterations_mean", r.iterations},
                    {"worst_guarded", r.worst_guarded},
                    {"stiffness", r.stiffness},
                    {"penetration", r.penetration}});
    Json values = Json::array();
    for (const double x : r.values) values.push_back(x);
    row["values"] = values;
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

Json to_json(const AnalysedTrade& analysed, const TradeContext& context) {
  Json scenes = Json::array();
  for (const SceneTrade& s : analysed.scenes) scenes.push_back(scene_json(s));
  return {{"command", "trade"},
          {"version", context.build.version},
          {"commit", context.build.commit},
          {"compiler", context.build.compiler},
          {"flags", context.build.flags},
          {"cpu", context.build.cpu},
          {"date", context.date},
          {"command_line", context.command},
          {"time_limit", context.time_limit},
          {"complete", analysed.trade.complete},
          {"scenes", scenes},
          {"rows", rows_json(analysed.trade)}};
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

std::string to_text(const AnalysedTrade& analysed) {
  std::string text;
  for (const SceneTrade& s : analysed.scenes) {
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
                          cell.status, three_digits(cell.cpu_per_second),
                          three_digits(cell.iterations), compact_label(cell.penetration),
                          std::isfinite(worst) ? fmt::format("{} {}", compact_label(worst),
                                                             s.scene->quantities[q].name)
                                               : "–");
    }
    if (!s.tols.empty()) {
      text += fmt::format("  {:<16} {:>12} {:>10} {:>10} {:>10}  solver's error at", "outcome",
                          "reference", "time step", "noise", "choice");
      for (const double tol : s.tols) text += fmt::format(" {:>8}", tolerance_label(tol));
      text += "\n";
      for (std::size_t k = 0; k < s.quantities.size(); ++k) {
        const TradeQuantityErrors& e = s.quantities[k];
        text +=
            fmt::format("  {:<16} {:>12} {:>10} {:>10} {:>10}  {:17}", s.scene->quantities[k].name,
                        value_label(e.reference), compact_label(e.step_error),
                        compact_label(e.noise), compact_label(e.choice), "");
        for (const double x : e.solver_error) text += fmt::format(" {:>8}", compact_label(x));
        text += "\n";
      }
    }
    text += "\n";
  }
  return text;
}

}  // namespace bipot
