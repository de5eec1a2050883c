#include "bench/tradeoff/trade_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "bench/tradeoff/trade_charts.h"
#include "core/base/number_text.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

/// Rounded, without an exponent up to a million.
std::string digits(double x, int number) {
  if (!std::isfinite(x)) return "–";
  return short_exponent(fmt::format("{:g}", number_at(fmt::format("{:.{}g}", x, number))));
}
std::string three_digits(double x) { return digits(x, 3); }
std::string model_name(const RunSetting& s) { return s.dem() ? "dem" : "nscd"; }

std::string times_label(double ratio) {
  return digits(ratio, 2) + (std::isfinite(ratio) ? " ×" : "");
}

/// The worst outcome of a cell: "0.3 %, pressure".
Table::Cell worst_outcome(const SceneTrade& s, const SceneTrade::Cell& cell) {
  std::size_t q = 0;
  const double worst = s.worst_error(cell, &q);
  Table::Cell made(worst);
  if (std::isfinite(worst)) {
    made.shown(fmt::format("{}, {}", share_label(worst), s.scene->quantities[q].name));
  }
  return made;
}

Table answers_table(const std::vector<SceneTrade>& scenes) {
  Table table{.columns = {{.name = "scene"},
                          {.name = "loosest tol", .show = tolerance_label},
                          {.name = "decided by"},
                          {.name = "CPU per simulated s", .show = seconds_label},
                          {.name = "tightest costs", .show = seconds_label},
                          {.name = "at tol", .show = tolerance_label}}};
  for (const SceneTrade& s : scenes) {
    const bool known = s.sufficient_tol.has_value();
    table.add({s.scene->name,
               known ? Table::Cell(*s.sufficient_tol) : Table::Cell(kNaN).shown("undecided"),
               known && *s.sufficient_tol < s.tols.front() ? s.decided_by : "–", s.cpu_sufficient,
               s.cpu_tightest, s.tols.empty() ? kNaN : s.tols.back()});
  }
  return table;
}

Table error_table(const SceneTrade& s) {
  const bool nearby = s.scene->replicas > 1;
  const bool other = std::ranges::any_of(s.cells, [&](const SceneTrade::Cell& cell) {
    return !cell.setting.dem() && cell.setting.solver != s.solver;
  });
  Table table{.columns = {{.name = "outcome"},
                          {.name = "reference", .show = value_label},
                          {.name = "time step", .show = compact_label}},
              .caption = "Where the error comes from"};
  if (nearby) table.columns.push_back({.name = "nearby runs", .show = compact_label});
  if (other) table.columns.push_back({.name = "other solver", .show = compact_label});
  for (const double tol : s.tols) {
    table.columns.push_back({.name = "solver, " + tolerance_label(tol), .show = compact_label});
  }
  table.columns.push_back({.name = "enough", .show = tolerance_label});
  for (std::size_t q = 0; q < s.quantities.size(); ++q) {
    const TradeQuantity& quantity = s.scene->quantities[q];
    const SceneTrade::Errors& e = s.quantities[q];
    std::vector<Table::Cell> cells = {
        Table::Cell(quantity.name).tipped(quantity.meaning),
        Table::Cell(fmt::format("{} {}", value_label(e.reference), quantity.unit))
            .tipped(e.reference_kind),
        Table::Cell(e.step_error).tipped(e.step_error_kind)};
    if (nearby) cells.emplace_back(e.noise);
    if (other) {
      cells.push_back(Table::Cell(e.choice).shown(
          std::isnan(e.choice) ? "–"
                               : fmt::format("{} {}", compact_label(e.choice), e.other_solver)));
    }
    for (const double x : e.solver_error) {
      cells.push_back(Table::Cell(x).as(x <= e.bound() ? "" : "over"));
    }
    cells.emplace_back(e.sufficient_tol.value_or(kNaN));
    table.add(std::move(cells));
  }
  table.note =
      "Relative errors. Time step: of the scene's own, against the exact value where it is known, "
      "else from shorter steps. ";
  if (nearby) table.note += "Nearby runs: twice the standard error of a difference of two means. ";
  if (other) {
    table.note +=
        "Other solver: largest difference at the tightest tolerance, where several exact answers "
        "of a step, chaos and counts at a threshold show; a dash where none completed it. ";
  }
  table.note +=
      "Solver: difference to the tightest tolerance at the same time step; marked where it matters: "
      "larger than the others and not negligible. Outcomes";
  const char* sign = ": ";
  for (const TradeQuantity& q : s.scene->quantities) {
    table.note += fmt::format("{}{}: {}", std::exchange(sign, "; "), q.name, q.meaning);
  }
  table.note += ".";
  table.page_note = " How a reference was found shows when the pointer rests on it.";
  return table;
}

/// What springs cost and do beside rigid contacts at the tolerance that is enough; no rows without
/// both.
Table spring_table(const SceneTrade& s) {
  Table table{.columns = {{.name = "contacts"},
                          {.name = "stiffness", .show = compact_label, .unit = "N/m"},
                          {.name = "steps per second", .show = compact_label},
                          {.name = "CPU per simulated s", .show = seconds_label},
                          {.name = "over rigid", .show = times_label},
                          {.name = "overlap / radius", .show = compact_label},
                          {.name = "worst outcome", .show = share_label}},
              .caption = "Springs instead of rigid contacts",
              .note =
                  "Worst outcome: the one that is furthest from the reference. Springs are "
                  "another model: where statics leaves forces open, elasticity picks others, "
                  "and tangential restitution is missing; such differences are not errors."};
  const SceneTrade::Cell* rigid = s.sufficient_cell();
  if (rigid == nullptr) return table;
  const auto add = [&](const SceneTrade::Cell& cell, const std::string& name) {
    const bool dem = cell.setting.dem();
    const double h = s.scene->step;
    table.add(
        {name, dem ? cell.stiffness : kNaN, dem ? cell.iterations / h : 1 / h, cell.cpu_per_second,
         cell.cpu_per_second / rigid->cpu_per_second, cell.penetration, worst_outcome(s, cell)},
        cell.done() ? "" : "bad");
  };
  add(*rigid,
      fmt::format("rigid, {} at tolerance {}", s.solver, tolerance_label(rigid->setting.tol)));
  for (const SceneTrade::Cell& cell : s.cells) {
    if (!cell.setting.dem()) continue;
    add(cell, cell.setting.label() + (cell.done() ? "" : " (" + cell.status + ")"));
    if (cell.done() || table.note.find(cell.message) != std::string::npos) continue;
    table.note += fmt::format(" {}: {}.", cell.status, cell.message);
  }
  if (table.rows.size() == 1) table.rows.clear();
  return table;
}

Table setting_table(const SceneTrade& s) {
  Table table{
      .columns = {{.name = "setting"},
                  {.name = "status"},
                  {.name = "CPU per simulated s", .show = seconds_label},
                  {.name = "iterations", .show = three_digits},
                  {.name = "overlap / radius", .show = compact_label},
                  {.name = "worst error", .show = compact_label}},
      .note =
          "Iterations: mean of a step; for springs, substeps of a step. Overlap: the largest "
          "of the run over the smaller radius. Worst error: of the outcomes, against the "
          "reference.",
      .page_note = " Why a row was not completed shows when the pointer rests on its status."};
  for (const TradeQuantity& q : s.scene->quantities) {
    table.columns.push_back(
        {.name = q.name, .show = value_label, .unit = q.unit, .meaning = q.meaning});
  }
  for (const SceneTrade::Cell& cell : s.cells) {
    std::string name = cell.setting.label();
    if (cell.setting.dem() && std::isfinite(cell.stiffness) &&
        !std::isfinite(cell.setting.stiffness)) {
      name += fmt::format(", {} N/m", compact_label(cell.stiffness));
    }
    std::vector<Table::Cell> cells = {name,
                                      Table::Cell(cell.status).tipped(cell.message),
                                      cell.cpu_per_second,
                                      cell.iterations,
                                      cell.penetration,
                                      worst_outcome(s, cell)};
    for (const double x : cell.means) cells.emplace_back(x);
    cells.resize(table.columns.size());
    table.add(std::move(cells), cell.done() ? "" : "bad");
  }
  return table;
}

void add_scene(const SceneTrade& s, const std::string& id, const std::string& command,
               Document& report) {
  const Trade::Scene& scene = *s.scene;
  const char* body = std::holds_alternative<Scene<2>>(scene.scene) ? "disk" : "sphere";
  report.heading(s.scene->title, id, 3);
  std::string run =
      fmt::format("{}: {} {}{}, {:g} s in steps of {:g} s.", scene.target, scene.bodies, body,
                  scene.bodies == 1 ? "" : "s", scene.num_steps * scene.step, scene.step);
  if (scene.num_steps < scene.whole_steps) {
    run += fmt::format(" Shortened from {:g} s: leave out --quick, or name {}:steps=N.",
                       scene.whole_steps * scene.step, scene.target);
  }
  if (s.scene->replicas > 1) {
    run += fmt::format(" {} runs of each setting; their means are compared.", s.scene->replicas);
  }
  report.say(run, "small");
  if (!s.tols.empty()) report.add(error_table(s));
  if (Table springs = spring_table(s); !springs.rows.empty()) report.add(std::move(springs));
  for (Figure& figure : trade_charts(s)) {
    figure.command = fmt::format(fmt::runtime(command), s.scene->target);
    report.add(std::move(figure));
  }
  report.fold("All settings and outcomes", setting_table(s));
}

Json setting_json(const RunSetting& s) {
  return {{"model", model_name(s)},
          {"solver", s.dem() ? Json(nullptr) : Json(s.solver)},
          {"tol", s.tol},
          {"step_factor", s.step_factor},
          {"accuracy", s.accuracy},
          {"overlap", s.overlap},
          {"stiffness_asked", s.stiffness}};
}

Json outcomes_json(const SceneTrade& s) {
  Json outcomes = Json::array();
  for (std::size_t q = 0; q < s.quantities.size(); ++q) {
    const TradeQuantity& quantity = s.scene->quantities[q];
    const SceneTrade::Errors& e = s.quantities[q];
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
  for (const SceneTrade::Cell& cell : s.cells) {
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
          {"step", s.scene->step},
          {"duration", s.scene->num_steps * s.scene->step},
          {"answer", s.answer()},
          {"sufficient_tol", s.sufficient_tol ? Json(*s.sufficient_tol) : Json(nullptr)},
          {"step_tol", s.step_tol},
          {"outcomes", outcomes_json(s)},
          {"settings", cells_json(s)}};
}

Json row_json(const Trade::Row& r) {
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
                  {"penetration", r.penetration},
                  {"values", r.values}});
  return row;
}

}  // namespace

FinishedTrade finished_trade(const Trade::Options& options, const std::string& command,
                             const std::string& command_of_scene) {
  FinishedTrade finished(run_trade(options));
  finished.made = provenance("trade", command);
  finished.command_of_scene = command_of_scene;
  finished.time_limit = options.time_limit;
  return finished;
}

Json to_json(const FinishedTrade& finished) {
  Json json = to_json(finished.made);
  json["time_limit"] = finished.time_limit;
  json["complete"] = finished.trade.complete;
  json["scenes"] = json_list(finished.scenes, scene_json);
  json["rows"] = json_list(finished.trade.rows, row_json);
  return json;
}

Table outcome_table(const Trade& trade) {
  Table table{.columns = Table::keyed({"scene",         "model",           "solver",
                                       "tol",           "step_factor",     "accuracy",
                                       "overlap",       "stiffness [N/m]", "replica",
                                       "status",        "step [s]",        "steps",
                                       "steps_planned", "steps_converged", "simulated [s]",
                                       "cpu [s]",       "iterations_mean", "worst_guarded",
                                       "penetration",   "outcome",         "unit",
                                       "value",         "message"})};
  for (const Trade::Row& r : trade.rows) {
    const auto scene = std::ranges::find_if(
        trade.scenes, [&](const Trade::Scene& s) { return s.name == r.scene; });
    const RunSetting& s = r.setting;
    for (std::size_t q = 0; q < r.values.size(); ++q) {
      const TradeQuantity& quantity = scene->quantities[q];
      table.add({r.scene,         model_name(s),     s.solver,      s.tol,
                 s.step_factor,   s.accuracy,        s.overlap,     r.stiffness,
                 r.replica,       r.status,          r.step,        r.steps,
                 r.steps_planned, r.steps_converged, r.simulated,   r.cpu,
                 r.iterations,    r.worst_guarded,   r.penetration, quantity.name,
                 quantity.unit,   r.values[q],       r.message});
    }
  }
  return table;
}

Document trade_document(const FinishedTrade& finished) {
  Document report;
  const auto id_of = [](std::size_t k) { return fmt::format("scene-{}", k + 1); };
  for (std::size_t k = 0; k < finished.scenes.size(); ++k) {
    const SceneTrade& s = finished.scenes[k];
    report.say(fmt::format("**[{}](#{})**: {}", s.scene->title, id_of(k), s.answer()));
  }
  report.say(
      "A tolerance is worth its cost as long as the solver's error in the outcome is larger than "
      "two others: that of the time step, which a better solver cannot reduce, and, where disks "
      "fly freely, the difference of runs with small initial perturbations. Each scene below is "
      "run as a whole, at several tolerances, at several time steps, and with springs and dashpots "
      "instead of rigid contacts.",
      "small");
  report.add(answers_table(finished.scenes));
  for (std::size_t k = 0; k < finished.scenes.size(); ++k) {
    add_scene(finished.scenes[k], id_of(k), finished.command_of_scene, report);
  }
  return report;
}

Document trade_page(const FinishedTrade& finished) {
  Document page{.title = "What a tolerance, a time step and a model buy over a whole simulation",
                .made = finished.made};
  if (!finished.trade.complete) page.say("**This run was interrupted; rows are missing.**");
  page.append(trade_document(finished));
  page.heading("How this was made", "made");
  Terms terms = to_terms(finished.made);
  terms.entries.emplace_back("limit",
                             fmt::format("{:g} s of CPU time for one run", finished.time_limit));
  page.add(std::move(terms));
  page.say("Every run and outcome: [trade.csv](trade.csv), [trade.json](trade.json).", "small");
  return page;
}

void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished) {
  write_text_file(folder / "trade.csv", to_csv(outcome_table(finished.trade)));
  write_json(to_json(finished), (folder / "trade.json").string());
  write_text_file(folder / "trade.html", to_html(trade_page(finished)));
}

}  // namespace bipot
