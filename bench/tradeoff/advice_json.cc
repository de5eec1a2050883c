#include "bench/tradeoff/advice_json.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "bench/report/build_info.h"

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

}  // namespace

Json to_json(const Scene<2>& scene, const Advice& a) {
  Json j{{"version", build_info().version},
         {"commit", build_info().commit},
         {"cpu", build_info().cpu},
         {"scene", scene.source},
         {"title", scene.title},
         {"status", to_string(a.status)},
         {"message", a.message},
         {"goal", to_json(a.goal)}};
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

}  // namespace bipot
