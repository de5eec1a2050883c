#include "bench/command/run_summary.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "bench/report/text_lines.h"
#include "core/base/counted.h"
#include "core/base/version.h"
#include "core/motion/sample_area.h"
#include "core/motion/sample_volume.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/motion/stress_tensor.h"

namespace bipot {
namespace {

template <int D>
const SpringDashpotSetup* springs_of(const RunSummary<D>& s) {
  return s.run.springs.get();
}

/// Cause of a failed step, else of the worst step that did not converge. The status says why a run
/// was cut short.
template <int D>
std::string message_of(const RunSummary<D>& s) {
  const SceneTotals<D>& t = s.run.totals;
  const bool cut_short = s.run.end == SceneRun<D>::End::kCancelled;
  if (s.run.failure && !cut_short) return s.run.failure->what();
  return t.worst_unconverged < 0 ? "" : fmt::format("step {}: {}", t.worst_unconverged, t.message);
}

/// Bodies through each outlet and inlet.
template <int D>
Json gates_json(const Scene<D>& scene, const State<D>& state) {
  Json gates = Json::array();
  const auto entry = [](const std::string& name, const char* kind, const GateFlow<D>& flow) {
    return Json{{"name", name},
                {"kind", kind},
                {"count", flow.count},
                {"mass", flow.mass},
                {"energy", flow.energy}};
  };
  for (std::size_t k = 0; k < scene.outlets.size(); ++k) {
    gates.push_back(entry(scene.outlets[k].name, "outlet", state.population.outlets[k]));
  }
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) {
    Json inlet = entry(scene.inlets[k].name, "inlet", state.population.inlets[k]);
    inlet["waiting"] = state.population.inlets[k].waiting;
    gates.push_back(std::move(inlet));
  }
  return gates;
}

/// The same as text; remaining bodies, and whether an inlet had to wait.
template <int D>
std::string gates_text(const Scene<D>& scene, const State<D>& state) {
  std::string text = fmt::format("  inside       {} {}s\n", state.bodies.size(), kBodyName<D>);
  for (std::size_t k = 0; k < scene.outlets.size(); ++k) {
    const GateFlow<D>& flow = state.population.outlets[k];
    text += fmt::format("  outlet       '{}': {} have left, {:.4g} kg\n", scene.outlets[k].name,
                        flow.count, flow.mass);
  }
  for (std::size_t k = 0; k < scene.inlets.size(); ++k) {
    const GateFlow<D>& flow = state.population.inlets[k];
    text += fmt::format("  inlet        '{}': {} have come in, {:.4g} kg", scene.inlets[k].name,
                        flow.count, flow.mass);
    if (flow.waiting > 0) {
      text += fmt::format("; no room in {}, what was due waited", counted(flow.waiting, "step"));
    }
    text += "\n";
  }
  return text;
}

/// Null if nothing overlapped.
Json start_json(const StartReport& start) {
  if (start.overlapping == 0) return nullptr;
  Json json{{"overlapping", start.overlapping},
            {"pair", start.pair},
            {"depth", start.depth},
            {"depth_over_radius", start.radii}};
  if (start.push) {
    json["pushed_apart"] = {{"rounds", start.push->rounds},
                            {"way", start.push->way},
                            {"way_over_radius", start.push->radii}};
  }
  return json;
}

/// Bodies of the scene at its start, and the height of their top.
template <int D>
std::string bodies_text(const Scene<D>& scene) {
  double top = -kInfinity;
  for (const Body<D>& body : scene.bodies) top = std::max(top, body.x[D - 1] + body.radius);
  if (scene.bodies.empty()) return {};
  return fmt::format("  bodies       {}, top at {:.4g} m at the start\n",
                     counted(static_cast<long>(scene.bodies.size()), kBodyName<D>), top);
}

/// How the accuracy cut the steps.
template <int D>
std::string parts_text(double accuracy, const SceneTotals<D>& t) {
  const StepParts& cut = t.cut;
  // Each step begins with a tenth of its size. Where none was smaller, that alone cuts the steps.
  const std::string why =
      cut.limited_by == "none" ? "as each step begins: longer steps cost less" : cut.limited_by;
  return fmt::format(
      "  accuracy     {:g}: {} parts; rejected {} for impacts, {} for drift, {} for accelerations, "
      "{} failed\n"
      "  parts        smallest {:.3g} s in step {} ({}); impacts misplaced by at most {:.2g} radii\n",
      accuracy, cut.parts, cut.misplacing, cut.drifting, cut.accelerating, cut.failed, cut.smallest,
      t.cut_step, why, cut.misplaced);
}

}  // namespace

template <int D>
Json to_json(const RunSummary<D>& s) {
  const Scene<D>& scene = s.scene;
  const State<D>& state = s.state;
  const SceneTotals<D>& t = s.run.totals;
  const SpringDashpotSetup* dem = springs_of(s);
  const double steps = std::max(t.steps, 1);
  Json j{{"command", "run"},
         {"version", program_version()},
         {"scene", scene.source},
         {"title", scene.title},
         {"status", s.status},
         {"exit_code", s.exit_code},
         {"model", dem != nullptr ? "dem" : "nscd"}};
  if (dem != nullptr) {
    j["dem"] = {{"stiffness", dem->stiffness},
                {"tangential_stiffness", dem->tangential_stiffness},
                {"substep", dem->substep},
                {"critical_step", dem->critical_step},
                {"substeps_per_step", dem->substeps},
                {"departures", dem->departures}};
  } else {
    j["solver"] = scene.solver.name;
    j["tol"] = scene.solver.tol;
    j["stop"] = scene.solver.stop;
  }
  j.update(Json{{D == 2 ? "disks" : "spheres", state.bodies.size()},
                {"steps", t.steps},
                {"steps_planned", s.run.planned},
                {"steps_converged", t.converged},
                {"steps_without_solution", t.unsolvable},
                {"steps_split", t.split},
                {"message", message_of(s)},
                {"first_unconverged_step", t.first_unconverged},
                {"last_step", state.step},
                {"time", state.time},
                {"contacts_mean", t.contacts / steps},
                {"contacts_max", t.max_contacts},
                {"iterations_mean", t.iterations / steps},
                {"iterations_max", t.max_iterations}});
  add_error(j, t.worst);
  j["worst_step"] = t.worst_step;
  j["start"] = start_json(s.start);
  j["note"] = s.note;
  const auto of_steps = [&t](double x) { return t.steps > 0 ? Json(x) : Json(nullptr); };
  j["penetration"] = of_steps(t.penetration);
  j["overlap"] = {{"largest", of_steps(t.overlap)},
                  {"step", t.overlap_step},
                  {"pair", t.overlap_pair},
                  {"steps_beyond", t.deep_overlaps},
                  {"beyond", kDeepOverlap}};
  j["travel"] = {{"largest", t.travel}, {"step", t.travel_step}};
  if (scene.accuracy > 0) {
    j["accuracy"] = {{"asked", scene.accuracy},
                     {"parts", t.cut.parts},
                     {"rejected",
                      {{"impact", t.cut.misplacing},
                       {"drift", t.cut.drifting},
                       {"acceleration", t.cut.accelerating},
                       {"failure", t.cut.failed}}},
                     {"smallest_part", of_steps(t.cut.smallest)},
                     {"smallest_part_step", t.cut_step},
                     {"limited_by", t.cut.limited_by},
                     {"misplaced", of_steps(t.cut.misplaced)},
                     {"misplaced_step", t.misplaced_step},
                     {"misplaced_sum", of_steps(t.cut.misplaced_sum)}};
  }
  j["passages"] = {{"count", t.passages}, {"first_step", t.passage_step}, {"first", t.passage}};
  j["energy"] = {{"kinetic", of_steps(t.last.energy.kinetic)},
                 {"potential", of_steps(t.last.energy.potential)},
                 {"wall_work", of_steps(t.last.energy.wall_work)},
                 {"friction_loss", of_steps(t.last.energy.friction_loss)},
                 {"shock_loss", of_steps(t.last.energy.shock_loss)}};
  if (scene.has_gates()) {
    j["energy"]["passed"] = t.last.energy.passed;
    j["gates"] = gates_json(scene, state);
  }
  if (scene.has_cohesion()) j["energy"]["cohesion_loss"] = of_steps(t.last.energy.cohesion_loss);
  if (dem != nullptr) j["energy"]["elastic"] = t.last.energy.elastic;
  const double area = sample_measure(state, scene.step);
  if (area > 0) {
    const MeanStress<D> stress = sample_stress<D>(state, scene.step, area, contact_moments(state));
    const Mat<D> total = stress.total();
    Json entries{{"xx", total(0, 0)}, {"yy", total(1, 1)}};
    if constexpr (D == 3) entries["zz"] = total(2, 2);
    entries["xy"] = 0.5 * (total(0, 1) + total(1, 0));
    if constexpr (D == 3) {
      entries["xz"] = 0.5 * (total(0, 2) + total(2, 0));
      entries["yz"] = 0.5 * (total(1, 2) + total(2, 1));
    }
    entries["pressure"] = stress.pressure();
    entries["kinetic_pressure"] = stress.kinetic.trace() / D;
    entries[D == 2 ? "area" : "volume"] = area;
    j["stress"] = std::move(entries);
  } else {
    j["stress"] = nullptr;
  }
  j["units"] = {{"time", "s"},        {"penetration", "m"}, {"energy", "J"},  {"stress", "Pa"},
                {"area", "m2"},       {"volume", "m3"},     {"seconds", "s"}, {"mass", "kg"},
                {"stiffness", "N/m"}, {"substep", "s"}};
  j["seconds"] = {{"detection", t.detection_seconds},
                  {"assembly", t.assembly_seconds},
                  {"solve", t.solve_seconds},
                  {"output", s.run.output_seconds},
                  {"total", s.wall_seconds}};
  return j;
}

template <int D>
std::string to_text(const RunSummary<D>& s) {
  const Scene<D>& scene = s.scene;
  const SceneTotals<D>& t = s.run.totals;
  const SpringDashpotSetup* dem = springs_of(s);
  const double steps = std::max(t.steps, 1);
  std::string text;
  const auto add = std::back_inserter(text);
  fmt::format_to(add, "{}\n", scene.title.empty() ? scene.source : scene.title);
  fmt::format_to(add, "  status       {}: {} of {} steps, {} converged, t = {:.6g} s\n", s.status,
                 t.steps, s.run.planned, t.converged, s.state.time);
  if (const std::string why = message_of(s); !why.empty()) {
    fmt::format_to(add, "  reason       {}\n", short_reason(why));
  }
  if (!s.start.text.empty()) fmt::format_to(add, "  start        {}\n", s.start.text);
  if (!s.note.empty()) fmt::format_to(add, "  note         {}\n", s.note);
  if (t.unsolvable > 0) {
    fmt::format_to(add, "  no solution  in {} (proved)\n", counted(t.unsolvable, "step"));
  }
  text += bodies_text(scene);
  if (t.split > 0)
    fmt::format_to(add, "  split        {} taken in smaller parts\n", counted(t.split, "step"));
  if (dem != nullptr) {
    fmt::format_to(add,
                   "  model        springs and dashpots, k_n = {:.4g} N/m, k_t = {:.4g} N/m\n"
                   "  substeps     {} a step of {:.4g} s; stable up to {:.4g} s\n",
                   dem->stiffness, dem->tangential_stiffness, dem->substeps, dem->substep,
                   dem->critical_step);
    for (const std::string& line : dem->departures) {
      fmt::format_to(add, "  note         {}\n", line);
    }
  } else {
    fmt::format_to(add, "  solver       {} to {} {}\n", scene.solver.name, scene.solver.stop,
                   tolerance_label(scene.solver.tol));
  }
  if (t.steps == 0) {
    fmt::format_to(add, "  results in   {}\n", s.out);
    return text;
  }
  fmt::format_to(add, "  contacts     mean {:.1f}, max {}\n", t.contacts / steps, t.max_contacts);
  if (dem == nullptr) {
    fmt::format_to(add, "  iterations   mean {:.1f}, max {}\n", t.iterations / steps,
                   t.max_iterations);
    fmt::format_to(add, "  worst error  {:.2e} in step {} (energy ε {:.2e}, residual η {:.2e})\n",
                   t.worst.guarded(), t.worst_step, t.worst.epsilon, t.worst.eta);
  }
  fmt::format_to(add, "  penetration  max {:.3e} m; over the smaller radius max {:.3g} %\n",
                 t.penetration, 100 * t.overlap);
  if (scene.accuracy > 0) text += parts_text(scene.accuracy, t);
  if (t.deep_overlaps > 0) {
    fmt::format_to(add, "  overlaps     beyond {:g} % in {}, most in step {}{}{}\n",
                   100 * kDeepOverlap, counted(t.deep_overlaps, "step"), t.overlap_step,
                   t.overlap_pair.empty() ? "" : ": ", t.overlap_pair);
  }
  if (t.passages > 0) {
    fmt::format_to(add, "  passages     {} pair{}, first in step {}: {}\n", t.passages,
                   t.passages == 1 ? "" : "s", t.passage_step, t.passage);
  }
  if (scene.observables && !(s.state.time >= scene.observables->starts)) {
    fmt::format_to(add, "  observables  no means: these begin at {:g} s\n",
                   scene.observables->starts);
  }
  if (!scene.joints.empty()) text += "  stresses     without the forces of pins and ropes\n";
  if (scene.has_gates()) text += gates_text(scene, s.state);
  fmt::format_to(add,
                 "  energy       kinetic {:.4e} J, potential {:.4e} J, work of walls {:.4e} J,\n"
                 "               lost to friction {:.4e} J, to shocks {:.4e} J\n",
                 t.last.energy.kinetic, t.last.energy.potential, t.last.energy.wall_work,
                 t.last.energy.friction_loss, t.last.energy.shock_loss);
  if (scene.has_cohesion()) {
    fmt::format_to(add, "               taken by cohesion {:.4e} J\n", t.last.energy.cohesion_loss);
  }
  if (scene.has_gates()) {
    fmt::format_to(add, "               brought in by inlets less taken out by outlets {:.4e} J\n",
                   t.last.energy.passed);
  }
  fmt::format_to(add,
                 "  wall time    {:.2f} s: detection {:.2f}, assembly {:.2f}, solve {:.2f}, output "
                 "{:.2f}\n",
                 s.wall_seconds, t.detection_seconds, t.assembly_seconds, t.solve_seconds,
                 s.run.output_seconds);
  fmt::format_to(add, "  results in   {}\n", s.out);
  if (dem == nullptr) text += "  ε: defect of the contact law as energy, η: as impulses\n";
  return text;
}

template Json to_json(const RunSummary<2>&);
template Json to_json(const RunSummary<3>&);
template std::string to_text(const RunSummary<2>&);
template std::string to_text(const RunSummary<3>&);

}  // namespace bipot
