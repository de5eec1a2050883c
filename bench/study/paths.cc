// Errors of the paths of bodies: over step and tolerance, and of rigid contacts against springs.
//
// Means over whole runs hide small errors behind the chaos of grains. Here a flow is followed for a
// short time only, from one state for all, before chaos enters. What step, tolerance or stiffness
// change is then seen in every single run.

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <set>

#include "bench/report/labels.h"
#include "bench/study/study.h"
#include "core/motion/push_apart.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {
namespace {

const std::string kPaths = "paths", kRigid = "apgd", kSprings = "dem";
const char* const kError = "error";               // from the reference
const char* const kSolverError = "solver_error";  // from the tightest tolerance at the same step
const char* const kOwnError = "own_error";        // of springs, from the stiffest
const char* const kInertialNumber = "inertial_number";
constexpr double kRecommended = 0.1;  // ε at which the cost of steps is told
constexpr double kStiffest = 1e-4;    // overlap aimed at
constexpr int kHorizon = 16;          // steps of the scene
constexpr double kExactFactor = 1.0 / 64, kTightest = 1e-8;  // of the reference
constexpr double kApproachTol = 1e-3, kPathLimit = 60;       // the latter in CPU seconds

/// A flow from one state on, and where it leads.
struct Flow {
  Scene<2> scene;
  State<2> exact;
  std::map<double, State<2>> tight;  ///< by step factor, to the tightest tolerance
  State<2> stiff;                    ///< with the stiffest springs
  Study::Values inertial_number;     ///< mean over the approach; empty: a flow that ends
};

/// Where a run leads from the beginning of the scene; without a body: it did not end.
std::pair<State<2>, RunRecord> follow(const Scene<2>& scene, const RunSetting& setting,
                                      const Study::Stopped& stopped,
                                      Study::Observer* observer = nullptr) {
  State<2> state = initial_state(scene);
  RunObserver<2> watch;
  if (observer != nullptr) {
    watch.on_step = [&](const SceneStep<2>& step) {
      observer->see(step.state);
      return true;
    };
  }
  RunRecord record = run_setting<2>(scene, state, setting,
                                    {.cpu_seconds = kPathLimit, .cancelled = stopped}, watch);
  if (!record.whole) state.bodies.clear();
  return {std::move(state), std::move(record)};
}

RunSetting to_tightest(double factor) {
  return {.solver = "auto", .tol = kTightest, .step_factor = factor};
}

Flow make_flow(const Study::Sample& sample, const Study::Stopped& stopped) {
  Flow flow{.scene = sample.make()};
  Scene<2>& scene = flow.scene;
  const bool falls = sample.scene == "pour" || sample.scene == "collapse";
  scene.num_steps = static_cast<int>((falls ? 0.35 : 0.7) * scene.num_steps);
  const Scene<2> approach = scene;
  Study::Observer observer(sample, approach, 1);
  const auto before =
      follow(approach, {.solver = "auto", .tol = kApproachTol}, stopped, &observer).first;
  for (const auto& [quantity, value] : observer.values(before)) {
    if (quantity == kInertialNumber) flow.inertial_number[quantity] = value;
  }
  scene.bodies = before.bodies;
  scene.cell = before.cell;
  scene.num_steps = kHorizon;
  if (!scene.cell.periodic() && !scene.bodies.empty()) {  // springs start without overlaps
    const StepSolver solver = make_step_solver(require_solver("auto"), {.tol = 1e-10});
    push_apart(scene, solver);
  }
  flow.exact = follow(scene, to_tightest(kExactFactor), stopped).first;
  return flow;
}

/// Root mean square of the distances, over that of the ways in the reference.
double path_error(const Flow& flow, const State<2>& a, const State<2>& b) {
  double squares = 0, ways = 0;
  for (std::size_t k = 0; k < flow.scene.bodies.size(); ++k) {
    squares += (a.bodies[k].x - b.bodies[k].x).squaredNorm();
    ways += (flow.exact.bodies[k].x - flow.scene.bodies[k].x).squaredNorm();
  }
  return std::sqrt(squares / ways);
}

Study::Values follow_path(Flow& flow, const RunSetting& setting, const Study::Stopped& stopped) {
  const Study::Values failed{{"failed", 1}, {"cpu", 0}};
  if (flow.exact.bodies.empty()) return failed;
  const auto [state, record] = follow(flow.scene, setting, stopped);
  if (state.bodies.empty()) return failed;
  Study::Values values{{kError, path_error(flow, state, flow.exact)},
                       {"overlap", record.penetration},
                       {"unsolved", record.steps - record.steps_converged},
                       {"cpu", record.cpu}};
  if (setting.dem()) {
    const RunSetting stiffest{.model = Model::kSpringDashpot, .overlap = kStiffest};
    if (flow.stiff.bodies.empty()) flow.stiff = follow(flow.scene, stiffest, stopped).first;
    if (flow.stiff.bodies.empty()) return values;
    values[kOwnError] = path_error(flow, state, flow.stiff);
    values["law_error"] = path_error(flow, flow.stiff, flow.exact);
    values.insert(flow.inertial_number.begin(), flow.inertial_number.end());
    return values;
  }
  State<2>& tight = flow.tight[setting.step_factor];
  if (tight.bodies.empty()) {
    tight = follow(flow.scene, to_tightest(setting.step_factor), stopped).first;
  }
  if (!tight.bodies.empty()) {
    values[kSolverError] = path_error(flow, state, tight);
    values["step_error"] = path_error(flow, tight, flow.exact);
  }
  return values;
}

std::vector<Study::Job> paths_jobs(bool quick) {
  std::vector<Study::Job> jobs;
  const std::vector<double> factors =
      quick ? std::vector<double>{2, 0.5} : std::vector<double>{4, 2, 1, 0.5, 0.25, 0.125};
  const std::vector<double> tols =
      quick ? std::vector<double>{1, 1e-2} : std::vector<double>{10, 1, 1e-1, 1e-2, 1e-3, 1e-4};
  const std::vector<double> overlaps =
      quick ? std::vector<double>{1e-2} : std::vector<double>{3e-2, 1e-2, 3e-3, 1e-3, 3e-4};
  const std::vector<std::pair<const char*, double>> scenes = {
      {"pour", 1}, {"collapse", 1}, {"shear", 1}, {"drum", 1}, {"drum", 3}, {"drum", 9}};
  for (int seed = 1; seed <= (quick ? 2 : 20); ++seed) {
    for (const auto& [scene, drive] : scenes) {
      const Study::Sample sample{
          .scene = scene, .size = quick ? 25 : 64, .seed = seed, .drive = drive};
      const std::string label = drive == 1 ? scene : fmt::format("{}_{:g}", scene, drive);
      const auto flow = std::make_shared<Flow>();
      const auto add = [&](const RunSetting& setting) {
        jobs.push_back({{kPaths, label, sample.size, seed, setting.dem() ? kSprings : kRigid,
                         setting.dem() ? setting.overlap : setting.tol, setting.step_factor},
                        [=](const Study::Stopped& stopped) {
                          if (flow->scene.bodies.empty()) *flow = make_flow(sample, stopped);
                          return follow_path(*flow, setting, stopped);
                        }});
      };
      for (const double factor : factors) {
        for (const double tol : tols) {
          add({.solver = kRigid,
               .tol = tol,
               .step_factor = factor,
               .parameters = {{"islands", "off"}}});
        }
      }
      for (const double overlap : overlaps) {
        if (sample.scene == std::string("shear")) break;  // no springs in a cell
        add({.model = Model::kSpringDashpot, .overlap = overlap});
      }
    }
  }
  return jobs;
}

/// A quantity of one setting by seed.
std::map<int, double> seen(const Study::Measured& measured, const std::string& scene, int size,
                           const std::string& method, double tol, double factor,
                           const std::string& quantity) {
  return by_seed(measured, {kPaths, scene, size, 0, method, tol, factor}, quantity);
}

/// The tolerance at which the solver's error, by tolerance, is the step's: by interpolation in the
/// logarithms; one of the ends if it is beyond them.
double balanced_tolerance(const std::map<double, double>& solver_error, double step_error) {
  double below = solver_error.begin()->first, error = 0;
  for (const auto& [tol, at] : solver_error) {
    if (at > step_error) {
      if (!(error > 0)) return tol;
      const double part = std::log(step_error / error) / std::log(at / error);
      return below * std::pow(tol / below, part);
    }
    below = tol;
    error = at;
  }
  return below;
}

void add_ridge(const Study::Measured& measured, const std::string& scene, int size,
               const std::vector<double>& factors, const std::vector<double>& tols, Document& part,
               Table& ridge, Table& orders) {
  Chart chart{.title = scene,
              .x = {.label = "tolerance ε", .kind = Chart::Axis::Kind::kLog},
              .y = {.label = "error of the paths", .kind = Chart::Axis::Kind::kLog}};
  Chart::Series balance{"ε that balances", 9, {}, Chart::Series::Kind::kLinePoints};
  std::vector<double> h, step_errors, eps, solver_errors, balances;
  int style = 0;
  for (const double factor : factors) {
    std::map<int, std::map<double, double>> by_tol;
    Chart::Series line{fmt::format("{:g} h", factor), style++, {}};
    for (const double tol : tols) {
      const auto mean = geometric_mean(seen(measured, scene, size, kRigid, tol, factor, kError));
      if (mean.seeds > 0) {
        line.points.push_back(
            {.x = tol, .y = mean.mean, .note = {}, .y_low = mean.low, .y_high = mean.high});
      }
      for (const auto& [seed, e] : seen(measured, scene, size, kRigid, tol, factor, kSolverError)) {
        by_tol[seed][tol] = e;
        if (tol > 1) continue;
        eps.push_back(tol);
        solver_errors.push_back(e);
      }
    }
    const auto step = seen(measured, scene, size, kRigid, tols.front(), factor, "step_error");
    std::map<int, double> balanced;
    for (const auto& [seed, e] : step) {
      h.push_back(factor);
      step_errors.push_back(e);
      balanced[seed] = balanced_tolerance(by_tol[seed], e);
      balances.push_back(balanced[seed]);
    }
    const auto solver_at = [&](double tol) {
      return geometric_mean(seen(measured, scene, size, kRigid, tol, factor, kSolverError)).mean;
    };
    const auto of_step = geometric_mean(step), at = geometric_mean(balanced);
    if (of_step.seeds == 0) continue;
    ridge.add({scene, factor, of_step.mean, of_step.low, of_step.high, solver_at(1),
               solver_at(1e-1), solver_at(1e-2), solver_at(1e-4), at.mean, at.low, at.high,
               at.seeds});
    balance.points.push_back({at.mean, std::sqrt(2.0) * of_step.mean});
    chart.series.push_back(std::move(line));
  }
  if (chart.series.empty()) return;
  chart.series.push_back(std::move(balance));
  const PowerLaw p = fit_power_law(h, step_errors), q = fit_power_law(eps, solver_errors),
                 r = fit_power_law(h, balances);
  orders.add({scene, p.exponent, p.confidence, q.exponent, q.confidence, r.exponent, r.confidence});
  part.add(Figure{
      .chart = std::move(chart),
      .file = fmt::format("paths_{}.svg", scene),
      .caption = fmt::format("{}: error of the paths of bodies over {} steps of h, over tolerance.",
                             scene, kHorizon)});
}

/// Pairs of a setting and a measured value, over settings and seeds.
struct Samples {
  std::vector<double> x, y;

  void add(double at, const std::map<int, double>& values) {
    for (const auto& [seed, value] : values) {
      x.push_back(at);
      y.push_back(value);
    }
  }
};

/// Error and CPU time of one seed by step, or by the overlap aimed at, from the coarsest on.
using CostCurve = std::map<double, std::pair<double, double>, std::greater<>>;

/// CPU time of the error `wanted`, by interpolation in the logarithms; that of the coarsest setting
/// if it is better already; NaN if none is as good.
double cost_at(const CostCurve& curve, double wanted) {
  double error_before = kNaN, cost_before = kNaN;
  for (const auto& [setting, at] : curve) {
    const auto [error, cost] = at;
    if (error <= wanted) {
      if (std::isnan(error_before)) return cost;
      const double part = std::log(wanted / error_before) / std::log(error / error_before);
      return cost_before * std::pow(cost / cost_before, part);
    }
    error_before = error;
    cost_before = cost;
  }
  return kNaN;
}

void add_springs(const Study::Measured& measured, const std::string& scene, int size,
                 Document& part, Table& laws, Table& costs, Table& settings) {
  std::set<Study::Case> known;
  Chart::Series rigid{"rigid", 0, {}, Chart::Series::Kind::kPoints};
  Chart::Series soft{"springs, from their own", 1, {}, Chart::Series::Kind::kPoints};
  Chart::Series unlike{"springs, from the rigid limit", 2, {}, Chart::Series::Kind::kPoints};
  Study::Geometric law;
  Samples soft_error, soft_cost, rigid_cost;  // over overlaps aimed at; over steps
  std::map<int, CostCurve> soft_curves, rigid_curves;
  double inertial = kNaN;
  for (const auto& [key, values] : measured) {
    Study::Case of = key;
    of.seed = 0;
    if (of.part != kPaths || of.scene != scene || of.size != size || !known.insert(of).second) {
      continue;
    }
    const bool springs = of.method == kSprings;
    const auto errors = by_seed(measured, of, springs ? kOwnError : kError);
    const auto cpu = by_seed(measured, of, "cpu");
    const auto error = geometric_mean(errors), cost = geometric_mean(cpu);
    const auto from_rigid = geometric_mean(by_seed(measured, of, kError));
    if (error.seeds < 2) continue;
    (springs ? soft : rigid)
        .points.push_back(
            {.x = cost.mean,
             .y = error.mean,
             .note = springs ? fmt::format("overlap {}", tolerance_label(of.tol))
                             : fmt::format("ε = {}, {:g} h", tolerance_label(of.tol), of.x),
             .y_low = error.low,
             .y_high = error.high});
    if (springs) {
      unlike.points.push_back({.x = cost.mean, .y = from_rigid.mean, .hollow = true});
      law = geometric_mean(by_seed(measured, of, "law_error"));
      inertial = over_seeds(by_seed(measured, of, kInertialNumber)).mean;
      soft_error.add(of.tol, errors);
      soft_cost.add(of.tol, cpu);
    } else if (of.tol == kRecommended) {
      rigid_cost.add(of.x, cpu);
    }
    if (springs || of.tol == kRecommended) {
      for (const auto& [seed, e] : errors) {
        (springs ? soft_curves : rigid_curves)[seed][springs ? of.tol : of.x] = {e, cpu.at(seed)};
      }
    }
    settings.add({scene, of.method, of.tol, of.x, from_rigid.mean, from_rigid.low, from_rigid.high,
                  springs ? error.mean : kNaN, over_seeds(by_seed(measured, of, "overlap")).mean,
                  cost.mean, error.seeds});
  }
  if (soft.points.empty()) return;
  const PowerLaw error_law = fit_power_law(soft_error.x, soft_error.y);
  const PowerLaw cost_law = fit_power_law(soft_cost.x, soft_cost.y);
  const PowerLaw rigid_law = fit_power_law(rigid_cost.x, rigid_cost.y);
  laws.add({scene, inertial, law.mean, law.low, law.high, law.seeds, error_law.exponent,
            error_law.confidence, cost_law.exponent, cost_law.confidence, rigid_law.exponent,
            rigid_law.confidence});
  for (const double wanted : {0.3, 0.1, 0.03, 0.01}) {
    std::map<int, double> of_rigid, of_springs, ratios;
    double bounds = 0;
    for (const auto& [seed, curve] : soft_curves) {
      const double springs = cost_at(curve, wanted), steps = cost_at(rigid_curves[seed], wanted);
      if (!std::isfinite(springs) || !std::isfinite(steps)) continue;
      of_springs[seed] = springs;
      of_rigid[seed] = steps;
      ratios[seed] = springs / steps;
      bounds += curve.begin()->second.first <= wanted ? 1 : 0;
    }
    const auto ratio = geometric_mean(ratios);
    if (ratio.seeds < 2) continue;
    costs.add({scene, wanted, geometric_mean(of_rigid).mean, geometric_mean(of_springs).mean,
               ratio.mean, ratio.low, ratio.high, ratio.seeds, bounds});
  }
  Chart chart{.title = scene,
              .x = {.label = "CPU time", .kind = Chart::Axis::Kind::kLogSeconds},
              .y = {.label = "error of the paths", .kind = Chart::Axis::Kind::kLog},
              .series = {std::move(rigid), std::move(soft), std::move(unlike)}};
  part.add(Figure{.chart = std::move(chart),
                  .file = fmt::format("springs_{}.svg", scene),
                  .caption = fmt::format("{}: error of the paths against the cost of following "
                                         "them, rigid and soft. Hollow: from the rigid limit.",
                                         scene)});
}

Document paths_report(const Study::Measured& measured) {
  Document part;
  Table ridge{.columns = {{"scene", "scene"},
                          {"step_factor", "step over the scene's", &ratio_label},
                          {"step_error", "error by the step", &share_label},
                          {"low", "from", &share_label},
                          {"high", "to", &share_label},
                          {"at_1", "by the solver at ε = 1", &share_label},
                          {"at_01", "at 0.1", &share_label},
                          {"at_001", "at 0.01", &share_label},
                          {"at_00001", "at 1e-4", &share_label},
                          {"balance", "ε that balances", &compact_label},
                          {"balance_low", "from", &compact_label},
                          {"balance_high", "to", &compact_label},
                          {"seeds", "seeds", &count_label}},
              .key = "balance"};
  Table orders{.columns = {{"scene", "scene"},
                           {"p", "error by the step ~ h^p, p", &ratio_label},
                           {"p_bar", "±", &ratio_label},
                           {"q", "error by the solver ~ ε^q, q", &ratio_label},
                           {"q_bar", "±", &ratio_label},
                           {"r", "ε that balances ~ h^r, r", &ratio_label},
                           {"r_bar", "±", &ratio_label}},
               .key = "orders"};
  Table laws{.columns = {{"scene", "scene"},
                         {"inertial_number", "I", &compact_label},
                         {"law", "stiff springs from rigid contacts", &share_label},
                         {"low", "from", &share_label},
                         {"high", "to", &share_label},
                         {"seeds", "seeds", &count_label},
                         {"p", "springs' error ~ overlap^p, p", &ratio_label},
                         {"p_bar", "±", &ratio_label},
                         {"c", "springs' cost ~ overlap^c, c", &ratio_label},
                         {"c_bar", "±", &ratio_label},
                         {"k", "rigid cost ~ h^k, k", &ratio_label},
                         {"k_bar", "±", &ratio_label}},
             .key = "laws_of_contact"};
  Table costs{.columns = {{"scene", "scene"},
                          {"wanted", "error wanted", &share_label},
                          {"rigid_cpu", "rigid, ε = 0.1", &seconds_label},
                          {"springs_cpu", "springs", &seconds_label},
                          {"ratio", "springs over rigid", &ratio_label},
                          {"low", "from", &ratio_label},
                          {"high", "to", &ratio_label},
                          {"seeds", "seeds that reach it", &count_label},
                          {"bounds", "by the softest already", &count_label}},
              .key = "cheapest"};
  Table settings{.columns = {{"scene", "scene"},
                             {"method", "contacts"},
                             {"tol", "ε, or overlap aimed at", &tolerance_label},
                             {"step_factor", "step", &ratio_label},
                             {"error", "error of the paths", &share_label},
                             {"low", "from", &share_label},
                             {"high", "to", &share_label},
                             {"own", "from stiff springs", &share_label},
                             {"overlap", "largest overlap", &share_label},
                             {"cpu", "CPU", &seconds_label},
                             {"seeds", "seeds", &count_label}},
                 .key = "paths",
                 .sortable = true};
  for (const std::string& scene : distinct(measured, kPaths, &Study::Case::scene)) {
    const auto rigid = [&](const Study::Case& c) { return c.scene == scene && c.method == kRigid; };
    const auto sizes = distinct<int>(measured, kPaths, &Study::Case::size, rigid);
    if (sizes.empty()) continue;
    add_ridge(measured, scene, sizes.back(),
              distinct<double>(measured, kPaths, &Study::Case::x, rigid),
              distinct<double>(measured, kPaths, &Study::Case::tol, rigid), part, ridge, orders);
    add_springs(measured, scene, sizes.back(), part, laws, costs, settings);
  }
  part.add(std::move(orders));
  part.add(std::move(ridge));
  part.add(std::move(laws));
  part.add(std::move(costs));
  part.fold("Every setting", std::move(settings));
  return part;
}

}  // namespace

Study::Part paths_part() {
  return {kPaths, "Paths: step against tolerance, rigid contacts against springs", &paths_jobs,
          &paths_report};
}

}  // namespace bipot
