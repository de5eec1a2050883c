// Fig. 10: equal disks at rest in regular arrays, compared with statics.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "bench/experiments/paper_item.h"
#include "bench/experiments/static_equilibrium.h"
#include "core/criterion/contact_error.h"
#include "core/linear/dense_factor.h"
#include "core/motion/force_balance.h"
#include "core/motion/time_stepping.h"
#include "core/pictures/force_picture.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "core/scene/scene_parts.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// Friction of the drawn pyramid: above the need of any size (tan 30° = 0.577).
constexpr double kStandingMu = 0.6;

/// A step from rest: the state after it, with the contacts' forces.
struct Rest {
  Scene<2> scene;
  State<2> state;
  int iterations = 0;
};

Rest one_step(const std::string& family, int side, double mu, const std::string& solver) {
  Rest rest{make_family_scene(family, side, {.mu = mu}), {}};
  SolverOptions options{.tol = 1e-10, .max_iterations = 200000};
  const SolverEntry& entry = require_solver(solver);
  TimeStepper<2> stepper(rest.scene, make_step_solver(entry, options));
  rest.state = initial_state(rest.scene);
  const StepReport<2> report = stepper.advance(rest.state);
  if (!report.converged) {
    throw std::runtime_error(
        fmt::format("{} {}, mu = {:g}, {}: {}", family, side, mu, solver, report.message));
  }
  rest.iterations = report.iterations;
  return rest;
}

/// Largest error of a vertical contact force of a square lattice over the weight above it.
double column_error(const Rest& rest, int side) {
  double worst = 0;
  for (const ContactOutcome<2>& c : rest.state.contacts) {
    if (std::abs(c.contact.n[1]) < 0.5) continue;
    const int upper = c.contact.j < side * side ? std::max(c.contact.i, c.contact.j) : c.contact.i;
    const double carried = (side - upper / side) * kGravity;  // every disk has 1 kg
    worst = std::max(worst, std::abs(c.s_n / rest.scene.step / carried - 1));
  }
  return worst;
}

/// Dimension of the impulses that move nothing: rows of s less the rank of H, whose entries are
/// cosines and radii, so that the pivots show it.
int self_stresses(const ContactProblem& problem) {
  return problem.num_rows() - numerical_rank(Eigen::MatrixXd(problem.H), 1e-10);
}

Scene<2> pyramid_scene(int rows, double mu, double mu_floor) {
  Scene<2> scene = make_family_scene("pyramid", rows, {.mu = mu});
  scene.materials = {"disk", "floor"};
  scene.laws = {{.mu = mu}, {.mu = mu_floor}, {.mu = mu_floor}, {.mu = mu}};
  scene.walls[0].material = 1;
  return scene;
}

ContactProblem pyramid_problem(int rows, double mu, double mu_floor) {
  const Scene<2> scene = pyramid_scene(rows, mu, mu_floor);
  return step_problem(scene, initial_state(scene));
}

/// The contacts of a pyramid at rest, with the impulses that hold it.
State<2> held_pyramid(const Scene<2>& scene, const StaticEquilibrium& equilibrium) {
  StepSolver held = [&](const ContactProblem&, const Vector&) {
    return StepSolution{.converged = true, .s = equilibrium.s};
  };
  State<2> state = initial_state(scene);
  TimeStepper<2> stepper(scene, held);
  stepper.advance(state);
  return state;
}

double kinetic_ratio(const ContactProblem& problem, const Vector& s) {
  const Vector v = body_velocities(problem, s);
  return std::sqrt(v.dot(problem.A * v) / problem.v_free.dot(problem.A * problem.v_free));
}

constexpr int kFirstOrder = 50000, kSecondOrder = 500;  // iterations

/// Behind the paragraph `after`.
void picture(const PaperItem::Context& context, const std::string& name, const Scene<2>& scene,
             const State<2>& state, std::size_t after, const std::string& caption,
             Findings& result) {
  draw_force_picture(context.out / (name + ".svg"), scene, state, "",
                     {.width = 560, .take_off = false});  // letters of a readable size
  result.show(name, caption, static_cast<int>(after));
}

std::vector<int> sides(const PaperItem::Context& context) {
  return context.quick ? std::vector<int>{10} : std::vector<int>{10, 50};
}

void rectangular(const PaperItem::Context& context, Findings& result) {
  for (const int side : sides(context)) {
    context.report(fmt::format("rectangular {0} × {0}", side));
    const Rest rest = one_step("square", side, 0, "auto");
    const std::string id = fmt::format("rectangular{}", side);
    const double error = column_error(rest, side),
                 balance = force_balance(rest.scene, rest.state).force;
    result.check(id + "_columns", error, "",
                 fmt::format("rectangular {0} × {0}, μ = 0: largest relative error of a "
                             "vertical contact force",
                             side),
                 "0 against k m g under the k-th disk from the top", error <= 1e-8, 2);
    result.check(id + "_balance", balance, "m g",
                 fmt::format("rectangular {0} × {0}: largest residual force of a disk", side),
                 "at most 1e-8 m g", balance <= 1e-8, 2);
    picture(
        context, "fig10_" + id, rest.scene, rest.state, result.ours.size(),
        fmt::format("Rectangular, {0} × {0}, μ = 0: the force under the k-th disk is k m g.", side),
        result);
  }
  for (const char* solver : {"auto", "ipm"}) {
    const Rest rest = one_step("square", 10, 0, solver);
    double side_force = 0;
    for (const ContactOutcome<2>& c : rest.state.contacts) {
      if (std::abs(c.contact.n[1]) < 0.5) side_force = std::max(side_force, c.s_n);
    }
    result.state(fmt::format("side_{}", solver), side_force / rest.scene.step / kGravity, "m g",
                 fmt::format("rectangular 10 × 10, μ = 0, `{}`: largest horizontal force", solver),
                 3);
  }
  result.ours.emplace_back(
      "Rectangular, μ = 0. The vertical forces are k m g to {rectangular10_columns}. Only they "
      "are compared: a row between two walls can be pre-stressed by any force, so the horizontal "
      "forces are not unique. `auto` returns at most {side_auto}, `ipm`, which stays inside the "
      "cones, {side_ipm}; both solve the law.");
}

void triangular(const PaperItem::Context& context, Findings& result) {
  for (const double mu : {0.0, 0.3}) {
    for (const int side : sides(context)) {
      context.report(fmt::format("triangular {0} × {0}, μ = {1:g}", side, mu));
      const Rest rest = one_step("triangular", side, mu, "auto");
      const ForceBalance<2> b = force_balance(rest.scene, rest.state);
      const std::string id = fmt::format("triangular{}{}", side, mu > 0 ? "_friction" : "");
      const std::string what = fmt::format("triangular {0} × {0}, μ = {1:g}", side, mu);
      result.check(id + "_balance", std::max(b.force, b.moment), "m g",
                   what + ": largest residual force, or moment over the radius, of a disk",
                   "at most 1e-8 m g", std::max(b.force, b.moment) <= 1e-8, 2);
      const double load = std::abs(b.walls[1] / b.weight - 1);
      result.check(id + "_load", load, "",
                   what + ": floor and walls together over the weight, less 1", "0", load <= 1e-8,
                   2);
      if (mu == 0) {
        const double side_load = b.wall[1][0] / b.weight;
        result.check(id + "_wall", 100 * side_load, "%",
                     what + ": push of a side wall, of the weight", "the same on both sides",
                     std::abs(b.wall[1][0] + b.wall[2][0]) <= 1e-8 * b.weight);
      }
      picture(context, "fig10_" + id, rest.scene, rest.state, result.ours.size(),
              fmt::format("Triangular, {0} × {0}, μ = {1:g}: the walls carry load{2}.", side, mu,
                          mu > 0 ? ", also upwards by friction" : ""),
              result);
    }
  }
  // The same scene, two solvers: both in equilibrium, with other forces.
  const Rest a = one_step("triangular", 10, 0.3, "apgd"),
             b = one_step("triangular", 10, 0.3, "ipm");
  double difference = 0, largest = 0;
  for (std::size_t k = 0; k < a.state.contacts.size(); ++k) {
    difference = std::max(difference, std::abs(a.state.contacts[k].s_n - b.state.contacts[k].s_n));
    largest = std::max(largest, a.state.contacts[k].s_n);
  }
  result.state("self_stresses", self_stresses(step_problem(a.scene, initial_state(a.scene))), "",
               "triangular 10 × 10, μ = 0.3: independent sets of contact forces that balance "
               "without any load");
  result.state("force_difference", 100 * difference / largest, "%",
               "triangular 10 × 10, μ = 0.3: largest difference of a normal force between "
               "`apgd` and `ipm`, of the largest force",
               2);
  for (const auto& [solver, rest] : {std::pair{"apgd", &a}, std::pair{"ipm", &b}}) {
    const ForceBalance<2> f = force_balance(rest->scene, rest->state);
    result.state(
        fmt::format("base_{}", solver), 100 * f.wall[0][1] / f.weight, "%",
        fmt::format("triangular 10 × 10, μ = 0.3: share of the weight on the floor, `{}`", solver));
  }
  result.ours.emplace_back(
      "Triangular. Every disk is in equilibrium and floor and walls carry the weight. The single "
      "forces are not unique: the 10 × 10 array has {self_stresses} independent self-stresses, "
      "and two solvers that both meet 1e-10 differ by {force_difference} of the largest force; "
      "with friction not even the floor's share is determined ({base_apgd} with `apgd`, "
      "{base_ipm} with `ipm`). So what is compared is the resultant on each disk and on the box, "
      "which is unique.");
}

// Two disks on the floor, touching, a third on top; a the radius, W the weight of one disk.
//
// Top disk: by symmetry two forces with vertical part W/2 each hold it. Lower disk: the lines of
// its weight and of the floor's reaction pass through the floor contact F. Besides, it feels the
// top disk's force Q and its neighbour's force N >= 0, horizontal, outwards, at the height of the
// centre. (The neighbour's friction: equilibria form a convex set, so that the mean of one and
// its mirror image is one too, and there it vanishes.) The contact with the top disk lies at
// (a/2, √3 a/2) from the centre, (a/2, a (1 + √3/2)) from F. With Q = (H outwards, W/2 downwards)
// moments about F give H (1 + √3/2) + N = W/4: hence H <= W/4 / (1 + √3/2) = (W/2) tan 15°. The
// normal there leans 30° from the vertical. Q leans atan(2H/W) <= 15°. It therefore needs a
// friction of at least tan(30° - 15°) = 2 - √3, with equality for N = 0. The floor carries H + N
// sideways, least for N = 0, and 3W/2 down: (2 - √3)/3.
void three_disks(const PaperItem::Context& context, Findings& result) {
  context.report("pyramid of 3 disks");
  const double tan15 = 2 - std::sqrt(3.0);
  const auto check = [&](const char* name, const char* what, double exact, const char* formula,
                         auto&& problem) {
    const double found = critical_friction(problem, 0.01, 10);
    result.check(name, found, "", fmt::format("3 disks: least friction {}", what),
                 fmt::format("{} = {:.6f}, met within 0.1 %", formula, exact),
                 std::abs(found / exact - 1) <= 1e-3, 7);
  };
  check("mu_disks", "between disks, on a rough floor (μ = 10)", tan15, "tan 15° = 2 − √3",
        [](double mu) { return pyramid_problem(2, mu, 10); });
  check("mu_floor", "on the floor, disks rough (μ = 10)", tan15 / 3, "(2 − √3)/3",
        [](double mu) { return pyramid_problem(2, 10, mu); });
  check("mu_3", "everywhere", tan15, "2 − √3, the larger of the two",
        [](double mu) { return pyramid_problem(2, mu, mu); });
  result.ours.emplace_back(
      "Cannon-ball, three disks, by hand. The top disk hands each lower one half its weight. Of "
      "the forces on a lower disk, its weight and the floor's reaction pass through the floor "
      "contact; so must the third, the push from the top disk, when the lower disks touch "
      "without pressing (pressing only makes more friction necessary at both places). That line "
      "leans 15° from the vertical, the contact's normal 30°: the disks need μ ≥ tan 15° = 2 − "
      "√3 among each other. The floor carries three halves of a weight and is pushed sideways by "
      "half a weight times tan 15°: it needs (2 − √3)/3. Found by bisection: {mu_disks} and "
      "{mu_floor}.");
  result.ours.emplace_back(
      "Whether a pyramid can stand is decided by existence: are there forces within the friction "
      "cones that hold every disk? In the plane that is a linear question (limit analysis). "
      "Either such forces are found, or a motion that opens every contact at least as fast as "
      "friction dilates it and gains power from gravity, which proves that there are none.");
}

void curve(const PaperItem::Context& context, Findings& result) {
  Chart chart{
      .title = "Least friction coefficient with which a pyramid can stand, against its rows",
      .x = {"rows", Chart::Axis::Kind::kLinear, 0.0, context.quick ? 12.0 : 24.0},
      .y = {"least friction coefficient", Chart::Axis::Kind::kLinear, 0.2, 0.6},
      .y_lines = {{std::tan(std::numbers::pi / 6), "tan 30°"}},
      .key = Chart::Key::kNone};
  Chart::Series series{"disks and floor alike", 0, {}};
  for (const int rows : {2, 3, 4, 5, 6, 8, 10, 14, 20}) {
    if (context.quick && rows > 10) break;
    context.report(fmt::format("least friction of {} rows", rows));
    const double mu =
        critical_friction([&](double m) { return pyramid_problem(rows, m, m); }, 0.1, 1, 1e-6);
    series.points.push_back({static_cast<double>(rows), mu, false, fmt::format("{:.6f}", mu)});
    if (rows < 10) continue;
    result.state(fmt::format("mu_{}rows", rows), mu, "",
                 fmt::format("{} rows: least friction, disks and floor alike", rows), 6);
    if (rows != 10 && rows != 20) continue;
    // Just above and just below, on the contact law itself.
    const ContactProblem above = pyramid_problem(rows, 1.001 * mu, 1.001 * mu);
    const StaticEquilibrium stands = static_equilibrium(above);
    const double error = contact_error(above, stands.s).guarded();
    result.check(fmt::format("stands_{}", rows), error, "",
                 fmt::format("{} rows, 1.001 μ_c: ε of the forces that hold it", rows),
                 "at most 1e-8: rest solves the contact law", stands.exists && error <= 1e-8, 2);
    const StaticEquilibrium falls =
        static_equilibrium(pyramid_problem(rows, 0.999 * mu, 0.999 * mu));
    result.check(fmt::format("falls_{}", rows), falls.motion, "g h",
                 fmt::format("{} rows, 0.999 μ_c: the slowest motion that forces in the "
                             "cones can leave (energy mean)",
                             rows),
                 "more than 0, proven by a motion admissible to 1e-9 of it",
                 !falls.exists && falls.dual_violation <= 1e-9 * falls.motion, 3);
  }
  chart.series = {series};
  result.draw("fig10_critical_friction",
              "Least friction with which a pyramid can stand. From tan 30° on (dotted) a disk "
              "could hand its load straight down through both contacts below it.",
              chart, static_cast<int>(result.ours.size()) - 1);
}

void pictures(const PaperItem::Context& context, Findings& result) {
  for (const int rows : sides(context)) {
    context.report(fmt::format("pyramid of {} rows", rows));
    const Scene<2> scene = make_family_scene("pyramid", rows, {.mu = kStandingMu});
    const StaticEquilibrium equilibrium =
        static_equilibrium(step_problem(scene, initial_state(scene)));
    if (!equilibrium.exists) throw std::runtime_error("no equilibrium of the drawn pyramid");
    const State<2> state = held_pyramid(scene, equilibrium);
    const ForceBalance<2> b = force_balance(scene, state);
    result.check(fmt::format("pyramid{}_balance", rows), std::max(b.force, b.moment), "m g",
                 fmt::format("pyramid of {} rows, μ = {:g}: largest residual force, or moment "
                             "over the radius, of a disk",
                             rows, kStandingMu),
                 "at most 1e-8 m g", std::max(b.force, b.moment) <= 1e-8, 2);
    picture(context, fmt::format("fig10_pyramid{}", rows), scene, state, result.ours.size() - 1,
            fmt::format("Cannon-ball, {} rows, μ = {:g}: forces that hold it.", rows, kStandingMu),
            result);
  }
}

/// Result of each solver's answer to the first step for a pyramid that could stand.
void selection(const PaperItem::Context& context, Findings& result) {
  const std::vector<double> mus = {0.545, 0.6, 0.8, 1, 2, 4};
  for (const int rows : {10, 20}) {
    if (context.quick && rows > 10) break;
    Findings::Table table{
        .name = fmt::format("selection_{}", rows),
        .caption = fmt::format(
            "Pyramid of {} rows from rest, one step to ε ≤ 1e-8 from zero impulses: stands, or falls "
            "with this mean velocity over g h. A dash: no answer within {} iterations ({} of `ipm` "
            "and `newton`).",
            rows, kFirstOrder, kSecondOrder),
        .columns = {"solver"}};
    for (const double mu : mus) table.columns.push_back(fmt::format("μ = {:g}", mu));
    // Over the answers: the largest mu at which one falls; extremes of motion for those mu with
    // an equilibrium.
    double last_fall = 0, least = 1e300, most = 0;
    for (const char* solver :
         {"uzawa", "classical", "pgs", "apgd", "anderson", "admm", "newton", "ipm", "auto"}) {
      const SolverEntry* entry = find_solver(solver);
      if (entry == nullptr) continue;  // built without PETSc
      table.rows.push_back({fmt::format("`{}`", solver)});
      for (const double mu : mus) {
        context.report(fmt::format("{} rows, {}, μ = {:g}", rows, solver, mu));
        const Scene<2> scene = make_family_scene("pyramid", rows, {.mu = mu});
        const ContactProblem problem = step_problem(scene, initial_state(scene));
        SolverOptions options;
        const bool second = entry->name == "ipm" || entry->name == "newton";
        options.max_iterations = second ? kSecondOrder : kFirstOrder;
        options.cancelled = context.interrupted;
        const SolveResult solved = solve(*entry, problem, options);
        const double motion = kinetic_ratio(problem, solved.s);
        const bool answered = is_success(solved.status);
        if (answered && motion > 1e-6) last_fall = std::max(last_fall, mu);
        if (answered && mu == kStandingMu) {
          least = std::min(least, motion);
          most = std::max(most, motion);
        }
        table.rows.back().push_back(!answered        ? "–"
                                    : motion <= 1e-6 ? "stands"
                                                     : fmt::format("falls, {:.3f}", motion));
      }
    }
    result.tables.push_back(std::move(table));
    result.state(fmt::format("last_fall_{}", rows), last_fall, "",
                 fmt::format("{} rows: largest μ of the table with an answer that falls", rows));
    result.state(fmt::format("least_motion_{}", rows), least <= most ? least : std::nan(""), "g h",
                 fmt::format("{} rows, μ = {:g}: least motion of an answer with ε ≤ 1e-8", rows,
                             kStandingMu),
                 3);
    result.state(fmt::format("most_motion_{}", rows), most, "g h",
                 fmt::format("{} rows, μ = {:g}: greatest motion of an answer with ε ≤ 1e-8", rows,
                             kStandingMu),
                 3);
  }
  result.ours.emplace_back(
      "Existence is one thing, what a time step does another. Below the curve no forces hold the "
      "pyramid, and it falls whatever the solver. Above it rest solves the contact law, but "
      "motions may solve it too: the law does not decide between them, and which one comes out "
      "depends on the way there. The tables below show one step from zero impulses, in which "
      "every answer satisfies the law to 1e-8. With 10 rows and μ = 0.6 the mean velocity of the "
      "answers lies between {least_motion_10} and {most_motion_10}; the largest μ of the table "
      "with an answer that falls is {last_fall_10}.");
}

/// Height of the top disk over time.
void falling(const PaperItem::Context& context, Findings& result) {
  struct Case {
    const char* name;
    double mu;
    const char* solver;
    bool held;
  };
  Chart chart{.title = "Height lost by the top disk of a pyramid of 10 rows against time",
              .x = {"time (s)", Chart::Axis::Kind::kLinear, 0.0, 1.0},
              .y = {"height lost by the top disk (radii)", Chart::Axis::Kind::kLinear, 0.0, {}}};
  std::pair<Scene<2>, State<2>> fallen;
  int style = 0;
  for (const Case& c :
       {Case{"μ = 0.5, pgs", 0.5, "pgs", false}, Case{"μ = 0.6, pgs", kStandingMu, "pgs", false},
        Case{"μ = 0.6, ipm", kStandingMu, "ipm", false},
        Case{"μ = 0.6, pgs, given forces", kStandingMu, "pgs", true}}) {
    Scene<2> scene = make_family_scene("pyramid", 10, {.mu = c.mu});
    State<2> state = initial_state(scene);
    if (c.held) {
      state = held_pyramid(scene, static_equilibrium(step_problem(scene, initial_state(scene))));
    }
    const SolverEntry& entry = require_solver(c.solver);
    SolverOptions options{.tol = 1e-6, .max_iterations = 200000, .cancelled = context.interrupted};
    Chart::Series series{c.name, style++, {{0, 0}}};
    const double top = state.bodies.back().x[1];
    const int steps = context.quick ? 20 : 100;
    SceneRunOptions<2> fall{.steps = steps,
                            .solver = make_step_solver(entry, options),
                            .cancelled = context.interrupted};
    fall.before_step = [&](const State<2>&) {
      context.report(fmt::format("{}, step {}", c.name, series.points.size()));
    };
    fall.on_step = [&](const SceneStep<2>& step) {
      const auto taken = static_cast<int>(series.points.size());  // the first point is the start
      series.points.push_back({step.report.time, (top - step.state.bodies.back().x[1]) / 0.5, false,
                               "", taken % (steps / 5) == 0});
      return true;
    };
    const SceneRun<2> run = run_scene(scene, state, fall);
    if (run.failure) throw *run.failure;
    const int unsolved = run.totals.steps - run.totals.converged;
    const std::string id =
        fmt::format("drop_{}{}_{}", c.mu == 0.5 ? "05" : "06", c.held ? "_held" : "", c.solver);
    const bool must_fall = c.mu == 0.5;
    result.check(
        id, (top - state.bodies.back().x[1]) / 0.5, "radii",
        fmt::format("10 rows, {}: drop of the top disk in {} steps of 0.01 s{}", c.name, steps,
                    unsolved > 0 ? fmt::format(" ({} steps above 1e-6)", unsolved) : std::string()),
        must_fall ? "falls (below μ_c)"
        : c.held  ? "stands: rest is a solution"
                  : "",
        must_fall ? std::optional<bool>(series.points.back().y > 0.01)
        : c.held  ? std::optional<bool>(std::abs(series.points.back().y) < 1e-4)
                  : std::nullopt,
        3);
    chart.series.push_back(std::move(series));
    if (must_fall) fallen = {scene, state};
  }
  result.draw("fig10_fall",
              "Top disk of a pyramid of 10 rows. At μ = 0.5 no forces hold it. At μ = 0.6 "
              "there are some; `given forces`: they are the start of the first step.",
              chart, static_cast<int>(result.ours.size()));
  picture(context, "fig10_fallen", fallen.first, fallen.second, result.ours.size(),
          fmt::format("The pyramid of 10 rows at μ = 0.5 after {:.1f} s.", fallen.second.time),
          result);
  result.ours.emplace_back(
      "Over many steps: at μ = 0.5 the top disk of 10 rows drops by {drop_05_pgs}. At μ = 0.6, "
      "above the least coefficient {mu_10rows}, it drops by {drop_06_pgs} with `pgs` from a cold "
      "start, by {drop_06_ipm} with `ipm`, and by {drop_06_held_pgs} with `pgs` when the first "
      "step is given the forces that hold.");
}

}  // namespace

Findings run_fig10(const PaperItem::Context& context) {
  Findings result;
  result.paper =
      "Three arrays of equal disks under gravity, segments between centres as wide as the normal "
      "force: in the rectangular array the force grows with depth, in the triangular one the "
      "walls carry load (the values agree with an analytical computation of the paper's "
      "reference 14), the cannon-ball array stands by friction alone. Sizes and friction "
      "coefficients are not given.";
  rectangular(context, result);
  triangular(context, result);
  three_disks(context, result);
  curve(context, result);
  pictures(context, result);
  selection(context, result);
  falling(context, result);
  return result;
}

}  // namespace bipot
