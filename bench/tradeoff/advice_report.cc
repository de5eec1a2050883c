#include "bench/tradeoff/advice_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bench/report/labels.h"

namespace bipot {
namespace {

Json to_json(const Accuracy& a) {
  return {{"force", a.force}, {"penetration", a.penetration}, {"energy", a.energy}};
}

std::string_view verdict_name(SolverTrial::Verdict verdict) {
  switch (verdict) {
    case SolverTrial::Verdict::kNone:
      return "";
    case SolverTrial::Verdict::kStretchMissed:
      return "missed on stretches";
    case SolverTrial::Verdict::kStretchMet:
      return "met on stretches";
    case SolverTrial::Verdict::kFreshMissed:
      return "missed on fresh steps";
    case SolverTrial::Verdict::kChosen:
      return "chosen";
  }
  return "";
}

Json to_json(const SolverTrial& t) {
  return {{"solver", t.solver.solver},
          {"parameters", t.solver.parameters},
          {"tol", t.tol},
          {"warm_start", t.warm},
          {"problems", t.problems},
          {"solved", t.solved},
          {"error", to_json(t.error)},
          {"guarded", t.guarded},
          {"seconds", t.seconds},
          {"iterations", t.iterations},
          {"pareto", t.pareto},
          {"stretches", t.stretches},
          {"stretch_error", to_json(t.stretch)},
          {"stretch_seconds", t.run_seconds},
          {"verdict", verdict_name(t.verdict)},
          {"message", t.message}};
}

/// A number of a table; "failed" where it has no bound.
TableCell measured(double x) {
  TableCell made(x);
  if (std::isinf(x)) made.shown("failed");
  return made;
}

void add_errors(std::vector<TableCell>& cells, const Accuracy& error) {
  for (auto m : Accuracy::kMeasures) cells.push_back(measured(error.*m));
}

std::vector<TableColumn> error_columns() {
  return {{.name = "force", .show = compact_label},
          {.name = "penetr.", .show = compact_label},
          {.name = "energy", .show = compact_label}};
}

void append(std::vector<TableColumn>& columns, std::vector<TableColumn> more) {
  for (TableColumn& column : more) columns.push_back(std::move(column));
}

Table step_table(const Advice& a) {
  Table table{.columns = {{.name = ""}, {.name = "step", .show = value_label, .unit = "s"}}};
  table.columns[0].name = " ";
  append(table.columns, error_columns());
  table.columns.push_back({.name = " "});
  for (std::size_t i = 0; i < a.steps.steps.size(); ++i) {
    const StepTrial& t = a.steps.steps[i];
    std::vector<TableCell> cells = {static_cast<int>(i) == a.step.index ? ">" : "", t.step};
    add_errors(cells, t.error);
    cells.emplace_back(t.factor == 1 ? "the scene's" : "");
    table.add(std::move(cells));
  }
  return table;
}

/// The trials on stretches, else all. The number of the others in `left_out`.
Table trial_table(const Advice& a, int& left_out) {
  const bool any_stretch = std::any_of(a.trials.begin(), a.trials.end(),
                                       [](const SolverTrial& t) { return t.stretches > 0; });
  Table table{.columns = {{.name = " "},
                          {.name = "solver"},
                          {.name = "tol", .show = tolerance_label},
                          {.name = "start"}}};
  for (int part = 0; part < 2; ++part) {
    append(table.columns, error_columns());
    table.columns.push_back({.name = "time", .show = duration_label});
  }
  table.columns.push_back({.name = " "});
  for (std::size_t i = 0; i < a.trials.size(); ++i) {
    const SolverTrial& t = a.trials[i];
    const bool tried = t.stretches > 0, chosen = static_cast<int>(i) == a.choice;
    if (any_stretch && t.verdict == SolverTrial::Verdict::kNone && !chosen) {
      ++left_out;
      continue;
    }
    std::string note;
    if (t.solved < t.problems) note = fmt::format("solved {} of {} ", t.solved, t.problems);
    if (!tried && t.verdict == SolverTrial::Verdict::kStretchMissed) note += t.message;
    std::vector<TableCell> cells = {fmt::format("{}{}", chosen ? ">" : "", t.pareto ? "*" : ""),
                                    t.solver.label, t.tol, t.warm ? "warm" : "cold"};
    add_errors(cells, t.error);
    cells.emplace_back(t.seconds);
    add_errors(cells, tried ? t.stretch : Accuracy{});
    cells.emplace_back(tried ? t.run_seconds : kNaN);
    cells.emplace_back(note);
    table.add(std::move(cells));
  }
  return table;
}

/// The evidence, one statement a line.
std::string confidence(const Advice& a) {
  std::string text =
      fmt::format("the scene ran for {} of {} steps, {} with contacts (at most {}){}",
                  a.sample.steps_run, a.sample.steps_planned, a.sample.contact_steps,
                  a.sample.contacts_max, a.sample.note.empty() ? "" : "; " + a.sample.note);
  text += fmt::format("\nsteps that it was chosen on: {}; ", a.problems);
  text += a.fresh.problems > 0 ? fmt::format("the worst on {} others: {}", a.fresh.problems,
                                             error_text(a.fresh.error, a.goal))
                               : "no others were solved to verify it";
  if (a.whole_windows > 0) {
    text +=
        fmt::format("\nthe advice as a whole, on {} other stretches, against the finest steps: {}",
                    a.whole_windows, error_text(a.whole_window, a.goal));
  }
  text += fmt::format("\nreferences: guarded error at most {:.0e}; two solvers agree to {:.0e}",
                      a.worst_reference, a.reference_spread);
  if (a.several_solutions > 0) {
    text += fmt::format(
        "\nsteps with several exact answers: {}, apart by at most {}; errors there are distances "
        "to the nearest answer, and nothing below half of that counts",
        a.several_solutions, error_text(a.spread, a.goal));
  }
  if (share_of(a.stretch_spread, a.goal) > 0) {
    text += fmt::format("\ntwo tight runs of the same stretches, started differently: {}",
                        error_text(a.stretch_spread, a.goal));
  }
  if (a.without_reference > 0) {
    text +=
        fmt::format("\nsteps left out because no solver got far enough below the goal in time: {}",
                    a.without_reference);
  }
  if (a.steps.windows_dropped > 0 || a.steps.finest > 0.125) {
    text += fmt::format(
        "\ntime was short for the step study ({} stretches dropped, finest step {:g} of the "
        "scene's): --time-limit gives more",
        a.steps.windows_dropped, a.steps.finest);
  }
  return text;
}

}  // namespace

Json to_json(const Scene<2>& scene, const Advice& a, const Provenance& made) {
  Json j = to_json(made);
  j["scene"] = scene.source;
  j["title"] = scene.title;
  j["status"] = to_string(a.status);
  j["message"] = a.message;
  j["goal"] = to_json(a.goal);
  if (a.choice >= 0) {
    const SolverTrial& t = a.trials[a.choice];
    j["advice"] = {{"solver", t.solver.solver},
                   {"parameters", t.solver.parameters},
                   {"tol", t.tol},
                   {"warm_start", t.warm},
                   {"step", a.step_size},
                   {"steps", a.num_steps},
                   {"seconds_per_step", a.seconds_per_step},
                   {"seconds", a.seconds_in_all}};
  } else {
    j["advice"] = nullptr;
  }
  j["run"] = {{"steps_planned", a.sample.steps_planned},
              {"steps_run", a.sample.steps_run},
              {"steps_with_contacts", a.sample.contact_steps},
              {"contacts_max", a.sample.contacts_max},
              {"note", a.sample.note}};
  j["step_study"] = {{"window", a.steps.window},
                     {"windows", a.steps.windows},
                     {"windows_dropped", a.steps.windows_dropped},
                     {"finest_step", a.steps.finest * scene.step},
                     {"met", a.step.met},
                     {"steps", Json::array()}};
  for (const StepTrial& t : a.steps.steps) {
    j["step_study"]["steps"].push_back({{"step", t.step}, {"error", to_json(t.error)}});
  }
  j["budget"] = to_json(a.budget);
  j["trials"] = Json::array();
  for (const SolverTrial& t : a.trials) j["trials"].push_back(to_json(t));
  j["fresh"] = {{"problems", a.fresh.problems},
                {"solved", a.fresh.solved},
                {"error", to_json(a.fresh.error)}};
  j["whole"] = {{"stretches", a.whole_windows}, {"error", to_json(a.whole_window)}};
  j["problems"] = {{"sampled", a.problems},
                   {"fresh", a.fresh_problems},
                   {"several_solutions", a.several_solutions},
                   {"spread", to_json(a.spread)},
                   {"stretch_spread", to_json(a.stretch_spread)},
                   {"without_reference", a.without_reference},
                   {"worst_reference", a.worst_reference},
                   {"reference_spread", a.reference_spread}};
  j["seconds"] = a.seconds_spent;
  return j;
}

std::string error_text(const Accuracy& error, const Accuracy& goal) {
  std::string text;
  for (auto m : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name_of(m),
                        std::isnan(error.*m) ? "not measured" : compact_label(error.*m));
  }
  return text;
}

Document advice_document(const Scene<2>& scene, const Advice& a) {
  Document d{.title = scene.title.empty() ? scene.source : scene.title};
  Terms terms{{{"asked for", error_text(a.goal, a.goal)},
               {"status", fmt::format("{}: {}", to_string(a.status), a.message)}}};
  if (a.choice >= 0) {
    const SolverTrial& t = a.trials[a.choice];
    const bool own_step = std::abs(a.step_size / scene.step - 1) < 1e-9;
    terms.entries.emplace_back(
        "advice", fmt::format("{} to {}, {} start, time step {:g} s (the scene's{})",
                              t.solver.label, tolerance_label(t.tol), t.warm ? "warm" : "cold",
                              a.step_size, own_step ? "" : fmt::format(": {:g} s", scene.step)));
    terms.entries.emplace_back("error of the time step", error_text(a.step_error, a.goal));
    terms.entries.emplace_back("error of the solver",
                               error_text(worst_of(t.error, t.stretch), a.goal));
    terms.entries.emplace_back(
        "cost", fmt::format("{} a step, {} for the {:g} s of the scene ({} steps), files aside",
                            duration_label(a.seconds_per_step), duration_label(a.seconds_in_all),
                            scene.num_steps * scene.step, a.num_steps));
  }
  d.add(std::move(terms));
  if (a.choice < 0) return d;
  d.heading("Time step");
  if (a.steps.steps.empty()) {
    d.say("Not measured; time was up or solves failed.");
  } else {
    d.say(fmt::format(
        "Error that the step alone makes, solved tightly, over {} stretch{} of {:g} s, against "
        "steps of {:g} s. Force: mean over the stretch; penetration: added by a step, over the "
        "smallest radius.",
        a.steps.windows, a.steps.windows == 1 ? "" : "es", a.steps.window,
        a.steps.finest * scene.step));
    d.add(step_table(a));
  }
  d.heading("Solvers");
  d.say(fmt::format(
      "Worst error over {} steps of the run and mean CPU time of a solve, on the left on single "
      "steps, on the right on stretches of {:g} s, where each step starts from the errors of the "
      "one before. *: nothing is better in both time and error. Left to the solver: {}.",
      a.problems, a.steps.window, error_text(a.budget, a.goal)));
  int left_out = 0;
  d.add(trial_table(a, left_out));
  if (left_out > 0) {
    d.say(fmt::format(
        "{} more trials were too inaccurate or too slow for stretches; --json has them.",
        left_out));
  }
  d.heading("How far to trust it");
  d.say(confidence(a));
  return d;
}

}  // namespace bipot
