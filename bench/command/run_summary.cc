#include "bench/command/run_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "core/motion/stress_tensor.h"

namespace bipot {
namespace {

const SpringDashpotSetup* springs_of(const RunSummary& s) {
  return s.run.springs ? &*s.run.springs : nullptr;
}

/// Why a step was not taken, else why the first one that did not converge did not.
std::string message_of(const RunSummary& s) {
  return s.run.failure ? s.run.failure->what() : s.run.totals.message;
}

}  // namespace

Json to_json(const RunSummary& s) {
  const Scene& scene = s.scene;
  const State& state = s.state;
  const SceneTotals& t = s.run.totals;
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
  j.update(Json{{"disks", state.disks.size()},
                {"steps", t.steps},
                {"steps_planned", s.run.planned},
                {"steps_converged", t.converged},
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
  j["penetration"] = t.penetration;
  j["energy"] = {{"kinetic", t.last.energy.kinetic},
                 {"potential", t.last.energy.potential},
                 {"wall_work", t.last.energy.wall_work},
                 {"friction_loss", t.last.energy.friction_loss},
                 {"shock_loss", t.last.energy.shock_loss}};
  if (dem != nullptr) j["energy"]["elastic"] = t.last.energy.elastic;
  const double area = sample_area(state, scene.step);
  if (area > 0) {
    const MeanStress stress = sample_stress(state, scene.step, area, contact_moments(state));
    const Mat2 total = stress.total();
    j["stress"] = {{"xx", total(0, 0)},
                   {"yy", total(1, 1)},
                   {"xy", 0.5 * (total(0, 1) + total(1, 0))},
                   {"pressure", stress.pressure()},
                   {"kinetic_pressure", 0.5 * stress.kinetic.trace()},
                   {"area", area}};
  } else {
    j["stress"] = nullptr;
  }
  j["seconds"] = {{"detection", t.detection_seconds},
                  {"assembly", t.assembly_seconds},
                  {"solve", t.solve_seconds},
                  {"output", s.run.output_seconds},
                  {"total", s.wall_seconds}};
  return j;
}

std::string to_text(const RunSummary& s) {
  const Scene& scene = s.scene;
  const SceneTotals& t = s.run.totals;
  const SpringDashpotSetup* dem = springs_of(s);
  const double steps = std::max(t.steps, 1);
  std::string text;
  const auto add = std::back_inserter(text);
  fmt::format_to(add, "{}\n", scene.title.empty() ? scene.source : scene.title);
  fmt::format_to(add, "  status       {}: {} of {} steps, {} converged, t = {:.6g} s\n", s.status,
                 t.steps, s.run.planned, t.converged, s.state.time);
  if (const std::string why = message_of(s); !why.empty()) {
    fmt::format_to(add, "  reason       {}\n", why);
  }
  if (t.split > 0) fmt::format_to(add, "  split        {} steps taken in smaller parts\n", t.split);
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
    fmt::format_to(add, "  solver       {} to {} {:.0e}\n", scene.solver.name, scene.solver.stop,
                   scene.solver.tol);
  }
  fmt::format_to(add, "  contacts     mean {:.1f}, max {}\n", t.contacts / steps, t.max_contacts);
  if (dem == nullptr) {
    fmt::format_to(add, "  iterations   mean {:.1f}, max {}\n", t.iterations / steps,
                   t.max_iterations);
    fmt::format_to(add, "  worst error  {:.2e} in step {} (ε {:.2e}, η {:.2e}, raw (42) {:.2e})\n",
                   t.worst.guarded(), t.worst_step, t.worst.epsilon, t.worst.eta, t.worst.raw42);
  }
  fmt::format_to(add, "  penetration  max {:.3e} m\n", t.penetration);
  fmt::format_to(add,
                 "  energy       kinetic {:.4e} J, potential {:.4e} J, wall work {:.4e} J,\n"
                 "               lost to friction {:.4e} J, to shocks {:.4e} J\n",
                 t.last.energy.kinetic, t.last.energy.potential, t.last.energy.wall_work,
                 t.last.energy.friction_loss, t.last.energy.shock_loss);
  fmt::format_to(add,
                 "  wall time    {:.2f} s: detection {:.2f}, assembly {:.2f}, solve {:.2f}, output "
                 "{:.2f}\n",
                 s.wall_seconds, t.detection_seconds, t.assembly_seconds, t.solve_seconds,
                 s.run.output_seconds);
  if (!s.out.empty()) fmt::format_to(add, "  results in   {}\n", s.out);
  return text;
}

}  // namespace bipot
