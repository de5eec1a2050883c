#include "bench/tradeoff/advice_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "bench/report/text_lines.h"
#include "core/motion/time_stepping.h"

namespace bipot {
namespace {

Json to_json(const Accuracy& a) {
  Json j = Json::object();
  for (const auto& [m, key, name] : Accuracy::kMeasures) j[key] = a.*m;
  return j;
}

/// With its bars, those of largest values null.
Json to_json(const MeasuredError& e) {
  Json j = to_json(e.error);
  j["bar"] = to_json(e.bar);
  return j;
}

std::string_view verdict_name(Advice::SolverTrial::Verdict verdict) {
  constexpr std::string_view kNames[] = {"missed", "met", "chosen"};
  return kNames[static_cast<int>(verdict)];
}

Json to_json(const Advice::SolverTrial& t) {
  return {{"solver", t.solver.solver},
          {"parameters", t.solver.parameters},
          {"tol", t.tol},
          {"stretches", t.stretches},
          {"solved", t.solved},
          {"error", to_json(t.error)},
          {"guarded", t.guarded},
          {"seconds", t.seconds},
          {"iterations", t.iterations},
          {"pareto", t.pareto},
          {"verdict", verdict_name(t.verdict)},
          {"message", t.message}};
}

/// A column for each quantity with a goal.
void add_columns(const Accuracy& goal, std::vector<Table::Column>& columns) {
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (!std::isnan(goal.*m)) columns.push_back({.key = key, .name = name, .show = compact_label});
  }
}
void add_errors(const MeasuredError& measured, const Accuracy& goal,
                std::vector<Table::Cell>& cells) {
  const Accuracy bound = measured.bound();
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    cells.push_back(Table::Cell(measured.error.*m)
                        .shown(with_bar(measured.error.*m, measured.bar.*m))
                        .as(bound.*m > goal.*m ? "over" : ""));
  }
}

Table step_table(const Advice& a) {
  Table table{.columns = {{.name = " "}, {.name = "step", .show = value_label, .unit = "s"}}};
  add_columns(a.goal, table.columns);
  table.columns.push_back({.name = " "});
  for (std::size_t i = 0; i < a.steps.steps.size(); ++i) {
    const Advice::StepTrial& t = a.steps.steps[i];
    std::vector<Table::Cell> cells = {static_cast<int>(i) == a.step.index ? ">" : "", t.step};
    add_errors(t.error, a.goal, cells);
    cells.emplace_back(t.accuracy > 0  ? fmt::format("cut by accuracy {:.2g}", t.accuracy)
                       : t.factor == 1 ? std::string("the scene's")
                                       : std::string());
    table.add(std::move(cells));
  }
  return table;
}

Table trial_table(const Advice& a) {
  Table table{.columns = {{.key = "choice", .name = "choice"},
                          {.key = "solver", .name = "solver"},
                          {.key = "tol", .name = "tol", .show = tolerance_label},
                          {.key = "seconds", .name = "time of a solve", .show = duration_label}}};
  add_columns(a.goal, table.columns);
  table.columns.push_back({.key = "verdict", .name = "verdict"});
  for (std::size_t i = 0; i < a.trials.size(); ++i) {
    const Advice::SolverTrial& t = a.trials[i];
    const bool chosen = static_cast<int>(i) == a.choice;
    std::vector<Table::Cell> cells = {fmt::format("{}{}", chosen ? ">" : "", t.pareto ? "*" : ""),
                                      t.solver.label, t.tol, t.seconds};
    add_errors(t.error, a.goal, cells);
    cells.emplace_back(t.solved < t.stretches ? fmt::format("{} of {} stretches: {}", t.solved,
                                                            t.stretches, short_reason(t.message))
                                              : std::string(verdict_name(t.verdict)));
    table.add(std::move(cells), t.solved < t.stretches ? "bad" : "");
  }
  return table;
}

/// Tolerance against time step: errors of both together over the goal, and the cost of a simulated
/// second where it was measured.
Table plane_table(const Advice& a) {
  Table table{.columns = {{.name = "time step", .show = value_label, .unit = "s"}},
              .caption = "Step and tolerance",
              .note =
                  "Worst bound over its goal, of the step and of the choice, else of the cheapest "
                  "solver; at most 1 meets the goal. Solvers were tried at the marked step; "
                  "at others their errors are taken from there. Below: CPU of the solves in a "
                  "simulated second, at the marked step."};
  std::vector<double> tols;
  for (const Advice::SolverTrial& t : a.trials) {
    if (t.solved == t.stretches && std::ranges::find(tols, t.tol) == tols.end()) {
      tols.push_back(t.tol);
    }
  }
  std::sort(tols.rbegin(), tols.rend());
  const Advice::SolverTrial* choice = a.choice < 0 ? nullptr : &a.trials[to_size(a.choice)];
  const auto cheapest = [&](double tol) {
    const Advice::SolverTrial* best = nullptr;
    if (choice != nullptr && choice->tol == tol) return choice;
    for (const Advice::SolverTrial& t : a.trials) {
      if (t.tol != tol || t.solved < t.stretches) continue;
      if (best == nullptr || t.seconds < best->seconds) best = &t;
    }
    return best;
  };
  for (const double tol : tols) {
    table.columns.push_back({.name = tolerance_label(tol), .show = compact_label});
  }
  for (std::size_t i = 0; i < a.steps.steps.size(); ++i) {
    const bool own = static_cast<int>(i) == a.step.index;
    const Advice::StepTrial& s = a.steps.steps[i];
    std::vector<Table::Cell> cells = {s.step};
    if (s.accuracy > 0) {
      cells[0].shown(fmt::format("{}, accuracy {:.2g}", value_label(s.step), s.accuracy));
    }
    for (const double tol : tols) {
      const Advice::SolverTrial* t = cheapest(tol);
      double share = 0;
      for (const auto& [m, key, name] : Accuracy::kMeasures) {
        const double solver = t->error.bound().*m;
        const double sum = s.error.bound().*m + (std::isnan(solver) ? 0 : solver);
        if (!std::isnan(a.goal.*m) && !std::isnan(sum)) share = std::max(share, sum / a.goal.*m);
      }
      std::string text = compact_label(share);
      if (own)
        text += fmt::format("\n{}, {}", t->solver.label, seconds_label(t->seconds / a.step_size));
      const bool chosen = own && a.choice >= 0 && tol == a.trials[to_size(a.choice)].tol;
      if (chosen) text = "**" + text + "**";
      cells.push_back(Table::Cell(share).shown(text).as(share > 1 ? "bad" : "good"));
    }
    table.add(std::move(cells));
  }
  return table;
}

/// Cost against error of the trials, a line for each solver.
Chart cost_chart(const Advice& a) {
  Chart chart{.title = "Cost and error of the solvers",
              .x = {"worst error over its goal", Chart::Axis::Kind::kLog},
              .y = {"CPU of a solve", Chart::Axis::Kind::kLogSeconds}};
  for (const Advice::SolverTrial& t : a.trials) {
    const double share = share_of(t.error.error, a.goal);
    if (t.solved < t.stretches) continue;
    if (chart.series.empty() || chart.series.back().name != t.solver.label) {
      chart.series.push_back({t.solver.label, static_cast<int>(chart.series.size()), {}});
    }
    chart.series.back().points.push_back(
        {share, t.seconds, &t - a.trials.data() != a.choice,
         fmt::format("{} to {}: {}", t.solver.label, tolerance_label(t.tol),
                     error_text(t.error.error, a.goal))});
  }
  return chart;
}

/// The evidence, one statement a line.
std::string confidence(const Advice& a) {
  std::string text = fmt::format(
      "the scene ran for {} of {} steps, {} with contacts (at most {}){}", a.sample.steps_run,
      a.sample.steps_planned, a.sample.contact_steps, a.sample.contacts_max,
      a.sample.note.empty() ? "" : "; " + short_reason(a.sample.note));
  text +=
      fmt::format("\nstretches that it was chosen on, that of the deepest overlap among them: {}",
                  a.steps.windows);
  if (a.run.steps > 0) {
    text += fmt::format("\nthe run as advised: {} of {} steps, ", a.run.steps, a.run.steps_planned);
    text += a.run.overlap > 0 ? fmt::format("largest overlap {} in step {}",
                                            overlap_label(a.run.overlap), a.run.overlap_step)
                              : "no overlap";
  }
  if (share_of(a.spread, a.goal) > 0) {
    text += "\ntwo tight runs of the same stretches, started differently: " +
            error_text(a.spread, a.goal) +
            "; nothing below that counts (several exact answers of a step, or chaos)";
  }
  if (a.steps.windows_dropped > 0 || a.steps.finest > 0.125 || a.out_of_time) {
    text += fmt::format(
        "\ntime was short ({} stretches dropped, finest step {:g} of the scene's{}): --time-limit "
        "gives more",
        a.steps.windows_dropped, a.steps.finest, a.out_of_time ? ", solvers left out" : "");
  }
  return text;
}

/// What the cost is that of: the run itself, a part of it, or the stretches.
std::string basis_of(const Advice& a) {
  if (a.run.whole()) return ", measured on the whole run";
  if (a.run.steps == 0) return ", measured on the stretches";
  return fmt::format(", measured on its first {} steps", a.run.steps);
}

std::vector<std::pair<std::string, std::string>> five_lines(const Advice& a) {
  std::vector<std::pair<std::string, std::string>> lines;
  const auto line = [&](std::string_view name, std::string text) {
    lines.emplace_back(name, std::move(text));
  };
  const char* whose =
      a.default_goal ? " (no goal given: 5 % in overlaps and in means over time)" : "";
  if (a.choice < 0) {
    line("asked for", error_text(a.goal, a.goal) + whose);
    line("verdict", fmt::format("{}: {}", to_string(a.status), a.message));
    if (a.cut > 0 && !a.sample.mostly_unsolved()) {
      // Each step begins with a tenth of its size: longer ones cost less.
      const double steps = std::max(1.0, std::round(0.1 * a.duration / a.scene_step));
      line("or", fmt::format("bipot run {} --accuracy {:.2g} --step-size {:g} --steps {:g}",
                             shell_word(a.scene), a.cut, a.duration / steps, steps));
    }
    return lines;
  }
  const Advice::SolverTrial& t = a.trials[to_size(a.choice)];
  const bool own_step = std::abs(a.step_size / a.scene_step - 1) < 1e-9;
  line("choice",
       fmt::format("{} to {}, time step {:g} s (the scene's{}){}", t.solver.label,
                   tolerance_label(t.tol), a.step_size,
                   own_step ? "" : fmt::format(": {:g} s", a.scene_step),
                   a.accuracy > 0 ? fmt::format(", cut by accuracy {:.2g}", a.accuracy) : ""));
  const MeasuredError expected = expected_error(a);
  std::string error = error_against(expected, a.goal) + whose;
  if (std::isnan(a.goal.penetration) && expected.error.penetration > kDeepOverlap) {
    error += fmt::format("; overlaps up to {}", overlap_label(expected.error.penetration));
  }
  constexpr double kLargeEnergyError = 5e-2;
  if (std::isnan(a.goal.energy) && expected.least().energy > kLargeEnergyError) {
    error += fmt::format("; energy, not asked for, {}",
                         with_bar(expected.error.energy, expected.bar.energy));
  }
  line("expected error", std::move(error));
  line("cost", fmt::format("{} a step, {} for the {:g} s of the scene ({} steps), without files{}",
                           duration_label(a.seconds_per_step), duration_label(a.seconds_in_all),
                           a.duration, a.num_steps, basis_of(a)));
  line("verdict",
       fmt::format("{}: {}; {} limits the error", to_string(a.status), a.message,
                   share_of(a.step_error.bound(), a.goal) > share_of(t.error.bound(), a.goal)
                       ? (a.accuracy > 0 ? "the accuracy" : "the time step")
                       : "the solver"));
  if (a.cohesion_without_range) {
    line("note",
         "without [contact] cohesion_range a contact holds an impulse of cohesion times the step: "
         "in blows shorter steps are less cohesive");
  }
  line("run it", run_command_of(a));
  return lines;
}

}  // namespace

Json to_json(const Advice& a, const Provenance& made) {
  Json j = to_json(made);
  j["scene"] = a.scene;
  j["title"] = a.title;
  j["status"] = to_string(a.status);
  j["message"] = a.message;
  j["goal"] = to_json(a.goal);
  j["default_goal"] = a.default_goal;
  if (a.choice >= 0) {
    const Advice::SolverTrial& t = a.trials[to_size(a.choice)];
    j["advice"] = {{"solver", t.solver.solver},
                   {"parameters", t.solver.parameters},
                   {"tol", t.tol},
                   {"warm_start", a.warm_start},
                   {"cohesion_without_range", a.cohesion_without_range},
                   {"step", a.step_size},
                   {"accuracy", a.accuracy},
                   {"steps", a.num_steps},
                   {"seconds_per_step", a.seconds_per_step},
                   {"seconds", a.seconds_in_all},
                   {"error", to_json(expected_error(a))},
                   {"run", run_command_of(a)}};
  } else {
    j["advice"] = nullptr;
  }
  j["run"] = {{"steps_planned", a.sample.steps_planned},
              {"steps_run", a.sample.steps_run},
              {"steps_with_contacts", a.sample.contact_steps},
              {"contacts_max", a.sample.contacts_max},
              {"overlap", a.sample.overlap},
              {"note", a.sample.note}};
  const auto step_json = [](const Advice::StepTrial& t) {
    return Json{{"step", t.step},
                {"accuracy", t.accuracy},
                {"seconds", t.seconds},
                {"error", to_json(t.error)}};
  };
  j["step_study"] = {{"window", a.steps.window},
                     {"windows", a.steps.windows},
                     {"windows_dropped", a.steps.windows_dropped},
                     {"finest_step", a.steps.finest * a.scene_step},
                     {"met", a.step.met},
                     {"steps", json_list(a.steps.steps, step_json)}};
  j["budget"] = to_json(a.budget);
  j["trials"] = json_list(a.trials, [](const auto& trial) { return to_json(trial); });
  j["out_of_time"] = a.out_of_time;
  j["spread"] = to_json(a.spread);
  j["advised_run"] = {{"steps_planned", a.run.steps_planned}, {"steps_run", a.run.steps},
                      {"steps_unsolved", a.run.unsolved},     {"overlap", a.run.overlap},
                      {"overlap_step", a.run.overlap_step},   {"failure", a.run.failure}};
  j["seconds"] = a.seconds_spent;
  return j;
}

std::string run_command_of(const Advice& a, const std::string& plan) {
  if (a.choice < 0) return {};
  const Advice::SolverTrial& t = a.trials[to_size(a.choice)];
  const SolverVariant solver =
      plan.empty() ? t.solver : SolverVariant{"auto", "auto", {{"plan", plan}}};
  std::string line = fmt::format("bipot run {} --solver {} --tol {}", shell_word(a.scene),
                                 solver.solver, tolerance_label(t.tol));
  for (const auto& [name, value] : solver.parameters) {
    std::string flag = name;
    std::ranges::replace(flag, '_', '-');
    line += fmt::format(" --{} {}", flag, shell_word(value));
  }
  if (a.other_stop) line += " --stop guarded";
  if (a.accuracy > 0) line += fmt::format(" --accuracy {:.2g}", a.accuracy);
  if (a.step_size != a.scene_step) {
    line += fmt::format(" --step-size {} --steps {}", a.step_size, a.num_steps);
  }
  return line;
}

std::string error_text(const Accuracy& error, const Accuracy& goal) {
  std::string text;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name,
                        std::isnan(error.*m) ? "not measured" : compact_label(error.*m));
  }
  return text;
}

std::string advice_summary(const Advice& a) {
  std::string text;
  for (const auto& [name, said] : five_lines(a)) {
    std::string_view before = name;
    const std::size_t width = said.starts_with("bipot ") ? said.size() : 84;  // a command is copied
    for (const std::string& line : wrapped_lines(said, width)) {
      text += fmt::format("{:<15} {}\n", std::exchange(before, ""), line);
    }
  }
  return text;
}

std::string advice_csv(const Advice& a) { return to_csv(trial_table(a)); }

Document advice_document(const Advice& a, const Provenance* made) {
  Document d{.title = a.title.empty() ? a.scene : a.title};
  d.add(Terms{five_lines(a)});
  if (a.choice >= 0) {
    if (made != nullptr) {
      d.add(plane_table(a));
      d.add(Figure{.chart = cost_chart(a),
                   .caption = "Filled: the choice. Left of 1 the goal is met, step aside. An error "
                              "of 0 stands on the axis."});
    }
    d.heading("Time step");
    d.say(fmt::format(
        "Error that the step alone makes, solved tightly, over {} stretch{} of {:g} s, against "
        "steps of {:g} s. Bold, in a text with * behind: with its ± above the goal.",
        a.steps.windows, a.steps.windows == 1 ? "" : "es", a.steps.window,
        a.steps.finest * a.scene_step));
    d.add(step_table(a));
    d.heading("Solvers");
    d.say(fmt::format(
        "Error that the solver adds over the same stretches, and mean CPU time of a solve. * in "
        "front: nothing is better in both time and error. Left to the solver: {}.",
        error_text(a.budget, a.goal)));
    d.add(trial_table(a));
    d.heading("How far to trust it");
    d.say(confidence(a));
  }
  if (made != nullptr) {
    d.made = *made;
    d.heading("How this was made");
    d.add(to_terms(*made));
    d.say("[Solvers as CSV](advice.csv), [all numbers](advice.json).", "small");
  }
  return d;
}

}  // namespace bipot
