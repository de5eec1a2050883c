#include "bench/command/failure_text.h"

#include <fmt/format.h>

#include "bench/report/labels.h"
#include "core/base/interrupt.h"
#include "core/motion/midpoint.h"
#include "core/motion/population.h"
#include "core/motion/spring_dashpot_setup.h"
#include "core/motion/step_outcome.h"
#include "solvers/analysis/existence.h"

namespace bipot {
namespace {

constexpr double kCertificateSeconds = 10;

template <int D>
std::string body_name(const Scene<D>& scene, const State<D>& state, int body) {
  if (to_size(body) < state.bodies.size()) {
    return fmt::format("{} {}", kBodyName<D>, body_number(state, body));
  }
  return fmt::format("wall '{}'", scene.walls[to_size(body) - state.bodies.size()].name);
}

/// A cause and its remedy, if the step shows it.
struct Cause {
  bool seen;
  std::string text;
};

template <int D>
double mass_ratio(const Scene<D>& scene) {
  double least = kInfinity, most = 0;
  const auto add = [&](double mass) {
    if (mass == 0) return;  // glued to a wall, or part of a cluster
    least = std::min(least, mass);
    most = std::max(most, mass);
  };
  for (const Body<D>& d : scene.bodies) add(d.mass);
  for (const Cluster<D>& cluster : scene.clusters.bodies) add(cluster.mass);
  return most / least;
}

/// The largest path of a disk in a step, over the smallest radius.
template <int D>
double way(const Scene<D>& scene, const State<D>& state) {
  double speed = 0;
  for (const Body<D>& d : state.bodies) speed = std::max(speed, d.v.norm());
  return speed * scene.step / smallest_radius(scene);
}

template <int D>
bool coefficients_differ(const Scene<D>& scene) {
  return std::ranges::any_of(scene.laws, [&](const ContactLaw& law) {
    return law.e_n != scene.laws[0].e_n || (law.mu > 0 && law.e_t != scene.laws[0].e_n);
  });
}

template <int D>
std::vector<Cause> causes(const Scene<D>& scene, const State<D>& state,
                          const ExistenceCertificate& c, bool smaller_steps_tried) {
  const bool walls_move = std::ranges::any_of(
      scene.walls, [](const Wall<D>& w) { return w.motion == Wall<D>::Motion::kMoving; });
  bool cell_moves = false;
  for (int k = 0; k < 3; ++k) cell_moves |= scene.cell.side(k).motion == CellSide::Motion::kMoving;
  const char* exact = D == 2 ? "homotopy or ipm" : "ipm";  // homotopy knows the plane alone
  double mu = 0;
  for (const ContactLaw& law : scene.laws) mu = std::max(mu, law.mu);
  const double ratio = mass_ratio(scene), path = way(scene, state);
  const bool differ = scene.impact == ContactLaw::Impact::kNewton && coefficients_differ(scene);
  const bool exists = c.verdict == Existence::kExists || c.verdict == Existence::kExistsNearby;
  std::vector<Cause> list = {
      {c.verdict == Existence::kNone,
       walls_move
           ? "no solution: a wall is driven into what is jammed; let it move by a force, or slower"
       : cell_moves
           ? "no solution: the cell is driven into what is jammed; move it by stresses, or slower"
           : "no solution: contacts are driven together; give all materials one e = e_n = e_t"},
      {c.verdict == Existence::kUndecided && differ,
       "perhaps no solution: coefficients of restitution differ in a jammed place; try e_n = e_t"},
      {c.verdict == Existence::kUndecided && walls_move,
       "perhaps no solution: friction jams bodies between moving walls; try less friction or slower "
       "walls"},
      {path > 0.1,
       fmt::format("the step is long: {}s move {:.2g} of the smallest radius in it; try "
                   "--step-size {:.2g}{}",
                   kBodyName<D>, path, scene.step * std::max(0.1 / path, 0.01),
                   smaller_steps_tried ? "" : " or --on-failure smaller-step")},
      {mu > 2,
       fmt::format("friction is large (mu = {:g}): many solutions or none, and paths between "
                   "them; try --solver {}",
                   mu, exact)},
      {ratio > 1e5,
       fmt::format("masses differ by {:.0e}: rounding may hide the light ones; try --solver "
                   "ipm or a looser --tol",
                   ratio)},
      {exists && scene.solver.name != "auto",
       fmt::format("the solver: {} did not get there, though a solution exists; try --solver auto",
                   scene.solver.name)},
      {exists && scene.solver.name == "auto",
       fmt::format("the solver: none got there, though a solution exists; try --solver {} with a "
                   "--time-limit of minutes",
                   exact)},
      {scene.solver.tol < 1e-6 && c.verdict != Existence::kNone,
       fmt::format("the tolerance {} is tight: `bipot advise` says what "
                   "your question needs",
                   tolerance_label(scene.solver.tol))},
      {!smaller_steps_tried && path <= 0.1, "the step: try --on-failure smaller-step"},
      {c.verdict != Existence::kNone,
       "several solutions: a solver that wanders between them may settle with --no-warm-start"},
      {c.verdict != Existence::kNone, "the solver: try another one (bipot list solvers)"},
      {true,
       "the start: bodies may overlap or be driven together from the first frame; look at it"}};
  std::erase_if(list, [](const Cause& cause) { return !cause.seen; });
  if (list.size() > 3) list.resize(3);
  return list;
}

}  // namespace

template <int D>
std::string failure_text(const Scene<D>& scene, const State<D>& state,
                         std::span<const std::type_identity_t<ContactOutcome<D>>> contacts,
                         const ContactProblem& problem, const ContactError& error, int step,
                         bool smaller_steps_tried, std::string_view said) {
  std::string text;
  const int worst = error.eta > error.epsilon ? error.worst_eta : error.worst_epsilon;
  if (worst >= 0 && to_size(worst) < contacts.size()) {
    const Contact<D>& c = contacts[to_size(worst)].contact;
    text += fmt::format("  step {}: worst contact {}: {} and {}, gap {:.3g} m, error {:.1e}\n",
                        step, worst, body_name(scene, state, c.i), body_name(scene, state, c.j),
                        c.gap, error.guarded());
  } else {
    text += fmt::format("  step {}: no contact stands out\n", step);
  }
  if (said.find("as exact as doubles allow") != said.npos) {
    const double reached = std::pow(10, std::ceil(std::log10(error.guarded())));
    return text +
           fmt::format(
               "  1. the tolerance {} is below what doubles can express here; try --tol {}\n",
               tolerance_label(scene.solver.tol), tolerance_label(reached));
  }
  const ExistenceCertificate certificate =
      certify_existence(problem, kCertificateSeconds, &InterruptGuard::requested);
  const std::string verdict = to_text(certificate);
  if (said.find(verdict) == said.npos) text += fmt::format("  {}\n", verdict);
  int k = 0;
  for (const Cause& cause : causes(scene, state, certificate, smaller_steps_tried)) {
    text += fmt::format("  {}. {}\n", ++k, cause.text);
  }
  return text;
}

template <int D>
std::string failure_text(const Scene<D>& scene, const State<D>& state, const SceneRun<D>& run,
                         bool smaller_steps_tried) {
  if (run.failed_problem.num_contacts() == 0) return {};
  std::vector<ContactOutcome<D>> contacts;
  const State<D> start = with_changed_population(scene, state);
  for (const Contact<D>& c : make_midpoint(scene, start).contacts)
    contacts.push_back({.contact = c});
  // Without a new impulse, only the solver's start is known.
  const ContactProblem& p = run.failed_problem;
  const Vector s = run.failed_start.size() == p.num_rows() ? run.failed_start
                                                           : Vector(Vector::Zero(p.num_rows()));
  return failure_text<D>(scene, start, contacts, p, contact_error(p, s), state.step + 1,
                         smaller_steps_tried, run.failure ? run.failure->what() : "");
}

template <int D>
std::string passage_advice(const Scene<D>& scene, const State<D>& state,
                           const SpringDashpotSetup* springs, bool smaller_steps_tried) {
  const double path = way(scene, state);
  if (springs != nullptr) {
    const double part = springs->substep / scene.step * path;
    return fmt::format(
        "  1. {}s move {:.3g} of the smallest radius in a substep; try --substep {:.2g}\n"
        "  --on-tunnel warn goes on\n",
        kBodyName<D>, part, (part > 0.5 ? 0.5 / part : 0.5) * springs->substep);
  }
  std::string text = fmt::format(
      "  1. {}s move {:.3g} of the smallest radius in a step; try --step-size {:.2g}\n"
      "  2. or travel = 0.5 in [time], which cuts steps where bodies are fast\n",
      kBodyName<D>, path, path > 0.5 ? 0.5 * scene.step / path : 0.5 * scene.step);
  if (!smaller_steps_tried)
    text += "  3. or --on-tunnel smaller-step, which cuts such steps alone\n";
  return text + "  --on-tunnel warn goes on\n";
}

/// What this scene can do against overlaps.
template <int D>
std::string less_overlap(const Scene<D>& scene) {
  if (scene.model == Model::kSpringDashpot) return "a larger --stiffness";
  if (scene.accuracy > 0) return fmt::format("an accuracy below {:g}", scene.accuracy);
  std::string text = scene.travel > 0 ? fmt::format("a travel below {:g} in [time]", scene.travel)
                                      : std::string("a smaller --step-size or travel in [time]");
  Scene<D> predicted = scene;
  predicted.predict_gaps = true;
  if (!scene.predict_gaps && !scene.project_overlaps && validate(predicted).empty()) {
    text += ", or overlaps = \"predict\" in [contact]";
  }
  return text;
}

template <int D>
std::string motion_warning(const Scene<D>& scene, const SceneTotals<D>& totals) {
  std::string text;
  if (totals.passages > 0) {
    text += fmt::format("bipot: warning: {} pair{} went through each other, first in step {}: {}\n",
                        totals.passages, totals.passages == 1 ? "" : "s", totals.passage_step,
                        totals.passage);
  }
  if (totals.deep_overlaps > 0) {
    text += fmt::format(
        "bipot: warning: overlaps beyond {:g} % of the smaller radius in {} step{}, most in step "
        "{}: {:.3g} %{}{}. Try {}\n",
        100 * kDeepOverlap, totals.deep_overlaps, totals.deep_overlaps == 1 ? "" : "s",
        totals.overlap_step, 100 * totals.overlap, totals.overlap_pair.empty() ? "" : ", ",
        totals.overlap_pair, less_overlap(scene));
  }
  return text;
}

template <int D>
EnergyGrowth<D>::EnergyGrowth(const Scene<D>& scene, const State<D>& start)
    : loss_(start.friction_loss + start.shock_loss), scale_(kinetic_energy(start)) {
  for (const Body<D>& body : start.bodies) scale_ += body.mass * scene.gravity.norm() * body.radius;
}

template <int D>
void EnergyGrowth<D>::add(const Scene<D>& scene, const StepReport<D>& report) {
  // Of joints a shock loss has either sign, to the second order in the step.
  if (!scene.joints.empty()) return;
  const EnergyLedger& e = report.energy;
  const double loss = e.friction_loss + e.shock_loss;
  // A step solved to the tolerance may have an error of about this fraction of the energy.
  scale_ = std::max({scale_, std::abs(loss), e.kinetic, std::abs(e.wall_work)});
  const double scale =
      std::max({std::abs(loss), e.kinetic, std::abs(e.wall_work), report.error.energy});
  const double grace = std::max(std::max(1e-9, 10 * scene.solver.tol) * scale, 1e-12 * scale_);
  const double created = loss_ - loss - report.force_energy;
  if (created > grace) {
    ++steps_;
    if (created > largest_) {
      largest_ = created;
      energy_ = e.kinetic;
      step_ = report.step;
    }
  }
  loss_ = loss;
}

template <int D>
std::string EnergyGrowth<D>::warning(const Scene<D>& scene) const {
  if (steps_ == 0) return {};
  return fmt::format(
      "bipot: warning: contacts created energy in {} step{}, most in step {}: {:.3g} J (kinetic then "
      "{:.3g} J). {}\n",
      steps_, steps_ == 1 ? "" : "s", step_, largest_, energy_,
      scene.model == Model::kSpringDashpot
          ? "It is the error of the substeps: try a smaller --substep"
      : scene.project_overlaps
          ? "Lifting bodies out of overlaps is booked there (manual: explanation/method.md §4)"
      : scene.impact != ContactLaw::Impact::kFremond && coefficients_differ(scene)
          ? "Newton's and Poisson's laws may do so where e_n, e_t or those of materials differ, "
            "[contact] impact = \"fremond\" does not (manual: explanation/method.md §3)"
          : "No coefficients differ: it is the error of the solves, which follows the tolerance");
}

template std::string failure_text<2>(const Scene<2>&, const State<2>&,
                                     std::span<const ContactOutcome<2>>, const ContactProblem&,
                                     const ContactError&, int, bool, std::string_view);
template std::string failure_text(const Scene<2>&, const State<2>&, const SceneRun<2>&, bool);
template std::string passage_advice(const Scene<2>&, const State<2>&, const SpringDashpotSetup*,
                                    bool);
template std::string passage_advice(const Scene<3>&, const State<3>&, const SpringDashpotSetup*,
                                    bool);
template std::string motion_warning(const Scene<2>&, const SceneTotals<2>&);
template std::string motion_warning(const Scene<3>&, const SceneTotals<3>&);
template std::string failure_text<3>(const Scene<3>&, const State<3>&,
                                     std::span<const ContactOutcome<3>>, const ContactProblem&,
                                     const ContactError&, int, bool, std::string_view);
template std::string failure_text(const Scene<3>&, const State<3>&, const SceneRun<3>&, bool);
template class EnergyGrowth<2>;
template class EnergyGrowth<3>;

}  // namespace bipot
