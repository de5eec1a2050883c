// Warm start, which the paper leaves to future work: iterations from s = 0 and from the impulses of
// the previous step, over a compaction.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bench/experiments/paper_item.h"
#include "bench/experiments/warm_start_study.h"
#include "bench/problems/scene_catalogue.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

constexpr double kRunTol = 1e-3;
constexpr int kMaxIterations = 30000;

struct Phase {
  const char *key, *title;
};
constexpr std::array<Phase, 4> kPhases = {Phase{"fall", "fall"}, Phase{"impact", "impact"},
                                          Phase{"settling", "settling"}, Phase{"rest", "rest"}};
constexpr std::size_t kFall = 0, kImpact = 1, kSettling = 2, kRest = 3;  // places in kPhases

/// Ends of the phases: the fall with the largest kinetic energy, the impact when a thousandth of it
/// remains, settling when no later step has more than 1e-5 of it.
struct Phases {
  int fall = 0, impact = 0, settling = 0;  ///< last step of each

  std::size_t of(int step) const {
    return step <= fall ? kFall : step <= impact ? kImpact : step <= settling ? kSettling : kRest;
  }
};
Phases find_phases(const std::vector<WarmStartRow>& rows) {
  double peak = 0;
  Phases phases;
  for (const WarmStartRow& row : rows) {
    if (row.kinetic <= peak) continue;
    peak = row.kinetic;
    phases.fall = row.step;
  }
  for (const WarmStartRow& row : rows) {
    if (row.step <= phases.fall || row.kinetic > 1e-3 * peak) phases.impact = row.step;
    if (row.step <= phases.fall || row.kinetic > 1e-5 * peak) phases.settling = row.step;
  }
  return phases;
}

/// Sums over steps of one solver and phase. A solve that reached the limit counts with it; steps on
/// which neither start converged are left out.
struct Gain {
  int steps = 0, hurt = 0, cold_unmet = 0, warm_unmet = 0;
  double cold = 0, warm = 0;
  double contacts = 0, carried = 0;

  void add(const WarmStartRow& row) {
    ++steps;
    contacts += row.contacts;
    carried += row.carried;
    cold_unmet += row.cold_met ? 0 : 1;
    warm_unmet += row.warm_met ? 0 : 1;
    hurt += row.warm > row.cold || (row.cold_met && !row.warm_met) ? 1 : 0;
    if (!row.cold_met && !row.warm_met) return;
    cold += row.cold;
    warm += row.warm;
  }
  /// Iterations cold over iterations warm; NaN if nothing counts.
  double ratio() const { return warm > 0 ? cold / warm : std::nan(""); }
};

struct Run {
  const char *key, *title;
  double e_t;
  std::vector<WarmStartRow> rows;
  Phases phases;
  std::map<std::string, std::array<Gain, kPhases.size() + 1>> gains;  ///< the last: all phases
};

std::string ratio_text(const Gain& gain) {
  if (gain.steps == 0) return "–";
  if (std::isnan(gain.ratio())) return "not met";
  const char* bound = gain.cold_unmet > gain.warm_unmet ? "≥ " : "";
  return bound + (gain.ratio() >= 100 ? fmt::format("{:.0f}", gain.ratio())
                                      : fmt::format("{:.2f}", gain.ratio()));
}

ClaimTable gains_table(const Run& run, const std::vector<SolverVariant>& solvers) {
  ClaimTable table;
  table.name = fmt::format("warm_start_{}", run.key);
  table.caption = fmt::format(
      "{}: iterations cold over iterations warm (above 1: the warm start gains), and in brackets "
      "on how many of the compared steps it took more iterations. ≥: cold solves ran into the "
      "limit of {} iterations; not met: so did all others.",
      run.title, kMaxIterations);
  table.columns = {"solver"};
  for (const Phase& phase : kPhases) table.columns.emplace_back(phase.title);
  table.columns.emplace_back("whole run");
  for (const SolverVariant& variant : solvers) {
    table.rows.push_back({variant.label});
    for (const Gain& gain : run.gains.at(variant.label)) {
      table.rows.back().push_back(
          fmt::format("{} ({} of {})", ratio_text(gain), gain.hurt, gain.steps));
    }
  }
  return table;
}

Chart iterations_chart(const Run& run, const std::vector<std::string>& solvers) {
  Chart chart{.title = fmt::format("Iterations per step, cold and warm, {}", run.title),
              .x = {"step", ChartAxis::Kind::kLinear, 0.0, 1000.0},
              .y = {"iterations", ChartAxis::Kind::kLog, 1.0, 1e5}};
  int style = 0;
  for (const std::string& solver : solvers) {
    ChartSeries cold{solver + ", cold", style++, {}}, warm{solver + ", warm", style++, {}};
    for (const WarmStartRow& row : run.rows) {
      if (row.solver != solver) continue;
      const auto point = [&](int iterations, bool met) {
        return ChartPoint{
            static_cast<double>(row.step), static_cast<double>(iterations), !met,
            fmt::format("step {}: {} iterations{}", row.step, iterations, met ? "" : ", not met")};
      };
      cold.points.push_back(point(row.cold, row.cold_met));
      warm.points.push_back(point(row.warm, row.warm_met));
    }
    chart.series.push_back(std::move(cold));
    chart.series.push_back(std::move(warm));
  }
  return chart;
}

class WarmStartItem {
 public:
  explicit WarmStartItem(const PaperContext& context) : context_(context) {
    options_.solvers = {{"uzawa", "uzawa", {{"rho", "stable"}}},
                        {"pgs", "pgs", {}},
                        {"apgd", "apgd", {}},
                        {"ipm", "ipm", {}},
                        {"auto", "auto", {}}};
    options_.tol = options_.run_tol = kRunTol;
    options_.max_iterations = kMaxIterations;
    options_.every = context.quick ? 50 : 25;
    options_.interrupted = context.interrupted;
  }

  Findings run() {
    for (Run& run : runs_) {
      study(run);
      if (context_.stopped()) return {};
    }
    result_.paper =
        "The paper starts every step from zero forces and leaves the start from those of the step "
        "before to future work.";
    number("disks", static_cast<double>(disks_), "disks of the compaction");
    number("tol", kRunTol, "tolerance of the compared solves, guarded ε");
    number("every", options_.every, "steps from one compared step to the next");
    gain_numbers();
    moving_numbers();
    rest_number();
    text();
    for (const Run& run : runs_) {
      figure(run, "sweeps", "uzawa and pgs", {"uzawa", "pgs"});
      figure(run, "fast", "apgd and ipm", {"apgd", "ipm"});
      result_.tables.push_back(gains_table(run, options_.solvers));
    }
    for (Claim& n : result_.claims) n.digits = 3;
    return std::move(result_);
  }

 private:
  /// A compaction with the run's restitution: its rows, its phases, and the gains in them.
  void study(Run& run) {
    Scene<2> scene = read_scene(find_scene("compaction"));
    // The filling grows from the bottom: its first disks are a shallower box of the same kind.
    if (context_.quick) scene.bodies.resize(80);
    disks_ = scene.bodies.size();
    for (ContactLaw& law : scene.laws) law.e_t = run.e_t;
    const int total = scene.num_steps;
    options_.on_step = [&](int step) {
      if (context_.say && step % 100 == 0) {
        context_.say(fmt::format("{}: step {} of {}", run.title, step, total));
      }
    };
    run.rows = study_warm_start(std::move(scene), options_);
    if (context_.stopped()) return;
    run.phases = find_phases(run.rows);
    for (const WarmStartRow& row : run.rows) {
      auto& gains = run.gains[row.solver];
      gains[run.phases.of(row.step)].add(row);
      gains.back().add(row);
    }
  }

  void number(const std::string& name, double value, const std::string& meaning,
              const std::string& expected = {}, std::optional<bool> holds = std::nullopt) {
    result_.check(name, value, "", meaning, expected, holds);
  }

  /// Gains that the text quotes; the tables have them all.
  void gain_numbers() {
    const auto state = [this](const Run& run, const char* solver, std::size_t phase) {
      const bool whole = phase == kPhases.size();
      number(fmt::format("gain_{}_{}_{}", run.key, solver, whole ? "run" : kPhases[phase].key),
             run.gains.at(solver)[phase].ratio(),
             fmt::format("iterations cold over iterations warm: {}, {}, {}", run.title, solver,
                         whole ? "whole run" : kPhases[phase].title));
    };
    for (const Run& run : runs_) {
      for (const char* solver : {"pgs", "apgd"}) {
        state(run, solver, kRest);
        state(run, solver, kPhases.size());
      }
      state(run, "ipm", kPhases.size());
    }
  }

  /// While disks fall and strike: number of starts carried over, and cases in which the warm start
  /// hurts.
  void moving_numbers() {
    const Gain& falling = runs_[0].gains.at("pgs")[kFall];
    number("carried",
           falling.contacts > 0 ? 100 * falling.carried / falling.contacts : std::nan(""),
           "contacts that start from an impulse of the step before, fall, e_t = 1");
    result_.claims.back().unit = "%";
    int hurt = 0, steps = 0;
    for (const Run& run : runs_) {
      for (const char* solver : {"uzawa", "pgs", "apgd"}) {
        for (const std::size_t phase : {kFall, kImpact}) {
          hurt += run.gains.at(solver)[phase].hurt;
          steps += run.gains.at(solver)[phase].steps;
        }
      }
    }
    number("moving_hurt", hurt,
           "fall and impact, both runs, uzawa, pgs and apgd: solves in which warm took more "
           "iterations");
    number("moving_steps", steps, "of so many");
  }

  void rest_number() {
    const auto gain = [this](std::size_t run, const char* solver) {
      return runs_[run].gains.at(solver)[kRest].ratio();
    };
    const double least =
        std::min({gain(0, "pgs"), gain(0, "apgd"), gain(1, "pgs"), gain(1, "apgd")});
    // A shallow box of few disks keeps moving with e_t = 1: rest is not evaluated there.
    number("rest_gain_least", least, "smallest gain at rest, pgs and apgd, both runs",
           context_.quick ? "" : "above 1: at rest the warm start pays",
           context_.quick ? std::nullopt : std::optional<bool>(least > 1));
  }

  void text() {
    result_.ours = {
        "A compaction of {disks} disks runs with apgd, warm. Each {every}th step is solved twice by "
        "each solver to a guarded ε of {tol}, once from zero and once from the impulses of the step "
        "before, matched by pair of bodies: the same problems for all, so that nothing but the "
        "start differs. It is done with the paper's e_t = 1, with which the packing never quite "
        "comes to rest, and with e_t = 0.",
        "At rest the warm start pays most with e_t = 0, where the last impulses solve the next step "
        "almost as they are: it divides the iterations of pgs by {gain_et0_pgs_rest} and those of "
        "apgd by {gain_et0_apgd_rest}. With e_t = 1, where tangential velocities turn round in every "
        "step, the factors are {gain_et1_pgs_rest} and {gain_et1_apgd_rest} (at least: some cold "
        "solves ran into the limit of iterations).",
        "While disks fall and strike it gains little or nothing: contacts come and go (at the fall "
        "{carried} of them carry an impulse over), and those that stay change their "
        "impulses by a shock. In {moving_hurt} of {moving_steps} solves with uzawa, pgs and apgd it "
        "takes more iterations than the cold start. Over the whole run the gain is "
        "{gain_et1_pgs_run} (pgs) and {gain_et1_apgd_run} (apgd) with e_t = 1, {gain_et0_pgs_run} "
        "and {gain_et0_apgd_run} with e_t = 0.",
        "The interior point gains nothing from impulses on the edge of the cone, where its path "
        "cannot start: {gain_et1_ipm_run} over the run with e_t = 1, {gain_et0_ipm_run} with "
        "e_t = 0, where some steps at rest are met by the start itself. Impulses are not unique in a "
        "packing: those of apgd serve apgd and the sweeps; what another kind of solver leaves may "
        "not."};
  }

  void figure(const Run& run, const char* key, const char* what,
              const std::vector<std::string>& solvers) {
    result_.draw(
        fmt::format("warm_start_{}_{}", run.key, key),
        fmt::format(
            "Iterations of the compared steps, cold and warm, {}: {}. The fall ends at step {}, the "
            "impact at {}, settling at {}. Hollow: the limit of {} iterations.",
            run.title, what, run.phases.fall, run.phases.impact, run.phases.settling,
            kMaxIterations),
        iterations_chart(run, solvers), 2);
  }

  const PaperContext& context_;
  WarmStartOptions options_;
  std::vector<Run> runs_ = {{"et1", "e_t = 1 (the paper's)", 1, {}, {}, {}},
                            {"et0", "e_t = 0", 0, {}, {}, {}}};
  std::size_t disks_ = 0;
  Findings result_;
};

}  // namespace

Findings run_warm_start(const PaperContext& context) { return WarmStartItem(context).run(); }

}  // namespace bipot
