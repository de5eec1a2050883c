// The mean stress tensor, which the paper names as future work.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/experiments/compression_run.h"
#include "bench/experiments/paper_item.h"
#include "core/motion/sample_area.h"
#include "core/pictures/stress_picture.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

/// Largest difference of the entries of two tensors, relative to the trace of the second.
double difference(const Mat2& a, const Mat2& b) {
  return (a - b).cwiseAbs().maxCoeff() / std::abs(b.trace());
}

class StressItem {
 public:
  explicit StressItem(const PaperContext& context) : context_(context) {}

  Findings run() {
    result_.paper =
        "The conclusion names a consistent mean stress tensor of the granular system as future "
        "work; there are no values.";
    result_.ours.emplace_back(
        "Definition. σ = 1/V [ Σ f ⊗ l + Σ m v′ ⊗ v′ + Σ ½ (dL/dt) e ], pressure positive: contact "
        "forces f = s/h times the branch l between the centres (to the wall's surface for a wall; "
        "Love, Weber), velocity fluctuations, and the spins' inertia with e = (0 −1; 1 0), which "
        "makes it symmetric when disks turn faster and faster (Fortin, Millet and de Saxcé 2003). "
        "A window takes each contact by the share of its branch inside, a disk takes half of each "
        "of its contacts (in proportion to the radii) over its own area. `bipot run` writes the "
        "stress of each disk and of the sample into the frames and the ledger; with "
        "`stress_picture = true` it draws it.");
    compression();
    if (context_.stopped()) return std::move(result_);
    gravity();
    return std::move(result_);
  }

 private:
  Compression compressed(bool smooth) const {
    const int count = context_.quick ? 154 : 617;
    context_.report(fmt::format("{} disks between {} walls", count, smooth ? "smooth" : "rough"));
    Scene<2> scene = compression_scene({.count = count, .smooth_walls = smooth});
    scene.solver.max_iterations = 3000;
    return run_compression(scene, context_.interrupted);
  }

  /// Isotropic compression between rough and between smooth walls.
  void compression() {
    const Compression rough = compressed(false);
    if (context_.stopped()) return;
    const Compression smooth = compressed(true);
    if (context_.stopped()) return;
    symmetry(rough, smooth);
    wall_pressures(rough, smooth);
    parts(rough);
    kinetic_part(rough);
    result_.ours.emplace_back(
        "Isotropic compression, {disks} disks. The tensor is symmetric to {asymmetry} at every "
        "step; its contact part alone is off by up to {contact_asymmetry} while disks are spun up. "
        "Once jammed between smooth walls its pressure equals the contact pressure on the walls to "
        "{pressure_error} in the mean and {pressure_error_step} in the worst step. Rough walls "
        "press by friction as well; with that counted the tensor equals what they do to "
        "{traction_error}, without it the pressure is {friction_share} of theirs. The kinetic part "
        "reaches {kinetic_most} of the applied pressure during the fall and is {kinetic_last} of "
        "the whole at the end.");
    pictures(rough);
    parts_chart(rough);
  }

  void symmetry(const Compression& rough, const Compression& smooth) {
    result_.state("disks", smooth.state.bodies.size(), "", "disks of the isotropic compression");
    result_.check("asymmetry",
                  std::max({smooth.flow.asymmetry, smooth.jammed.asymmetry, rough.flow.asymmetry,
                            rough.jammed.asymmetry}),
                  "", "largest |σ_xy − σ_yx|/(σ_xx + σ_yy) of a step, falling and jammed",
                  "round-off: below 1e-12",
                  std::max({smooth.flow.asymmetry, smooth.jammed.asymmetry, rough.flow.asymmetry,
                            rough.jammed.asymmetry}) < 1e-12,
                  2);
    result_.state("contact_asymmetry",
                  std::max({smooth.flow.contact_asymmetry, rough.flow.contact_asymmetry}), "",
                  "the same of the contact part alone, falling", 2);
  }

  /// The tensor against the action of the walls on the sample, once it is jammed.
  void wall_pressures(const Compression& rough, const Compression& smooth) {
    const CompressionPhase &jam = smooth.jammed, &rough_jam = rough.jammed;
    const double pressure_error = std::abs(0.5 * jam.stress.trace() / jam.wall_pressure - 1);
    result_.check("pressure_error", pressure_error, "",
                  "pressure against the walls' contact pressure, smooth walls, mean of the "
                  "last 100 steps: relative difference",
                  "at most 1 %", pressure_error <= 0.01, 2);
    double worst = 0;
    for (std::size_t k = smooth.pressure.size() - static_cast<std::size_t>(jam.steps);
         k < smooth.pressure.size(); ++k) {
      worst = std::max(worst, std::abs(smooth.pressure[k] / smooth.wall_pressure[k] - 1));
    }
    result_.check("pressure_error_step", worst, "", "the same in the worst of these steps",
                  "at most 1 %", worst <= 0.01, 2);
    const double traction = difference(rough_jam.stress, rough_jam.walls);
    result_.check("traction_error", traction, "",
                  "stress against the walls' normal and frictional forces Σ f ⊗ p / V, rough "
                  "walls, mean of the last 100 steps, largest entry over the trace",
                  "at most 1 %", traction <= 0.01, 2);
    result_.check("friction_share", 0.5 * rough_jam.stress.trace() / rough_jam.wall_pressure, "",
                  "pressure over the walls' normal pressure alone, rough walls",
                  "within 5 % = μ/2, what friction along the walls can add",
                  std::abs(0.5 * rough_jam.stress.trace() / rough_jam.wall_pressure - 1) <= 0.05,
                  5);
  }

  void kinetic_part(const Compression& rough) {
    double kinetic = 0;
    for (std::size_t k = 0; k < rough.pressure.size(); ++k) {
      kinetic = std::max(kinetic, rough.kinetic_pressure[k] / rough.applied_pressure[k]);
    }
    result_.state("kinetic_most", kinetic, "",
                  "largest kinetic pressure over the applied pressure, during the fall", 2);
    result_.state("kinetic_last", rough.kinetic_pressure.back() / rough.pressure.back(), "",
                  "share of the kinetic part in the pressure after the last step", 2);
  }

  void pictures(const Compression& rough) {
    ForcePictureOptions options;
    options.width = 600;  // the page shows it about as large
    const State<2> mean = rough.jammed.contacts.in(rough.state);
    const std::vector<double> last = disk_pressures(rough.state, rough.scene.step);
    options.fill.high = colour_bar_end(last);
    draw_stress_picture(context_.out / "stress_disks.svg", rough.scene, rough.state, last, "",
                        options);
    draw_stress_picture(context_.out / "stress_disks_mean.svg", rough.scene, mean,
                        disk_pressures(mean, rough.scene.step), "", options);
    result_.show("stress_disks",
                 "Pressure in each disk, over its own area, after the last "
                 "step of the isotropic compression.",
                 1);
    result_.show("stress_disks_mean",
                 fmt::format("The same of the forces' mean over the last {} steps. Same scale.",
                             rough.jammed.steps),
                 1);
  }

  void parts_chart(const Compression& rough) {
    Chart chart{.title = "Parts of the pressure against time",
                .x = {"time (s)", ChartAxis::Kind::kLinear, 0.0, {}},
                .y = {"pressure / applied pressure", ChartAxis::Kind::kLinear, 0.0, {}}};
    ChartSeries whole{"mean stress", 0, {}}, moving{"its kinetic part", 1, {}},
        walls{"contacts on the walls", 2, {}};
    for (std::size_t k = 0; k < rough.time.size(); ++k) {
      const double unit = rough.applied_pressure[k];
      whole.points.push_back({rough.time[k], rough.pressure[k] / unit, false, "", false});
      moving.points.push_back({rough.time[k], rough.kinetic_pressure[k] / unit, false, "", false});
      walls.points.push_back({rough.time[k], rough.wall_pressure[k] / unit, false, "", false});
    }
    chart.series = {whole, moving, walls};
    for (ChartSeries& series : chart.series) series.kind = ChartSeries::Kind::kLine;
    result_.draw("stress_parts",
                 "Isotropic compression: pressure of the sample and of the "
                 "walls' contacts, relative to the applied one.",
                 chart, 1);
  }

  /// Disks and windows against the sample.
  void parts(const Compression& c) {
    const double h = c.scene.step;
    const std::vector<double> moments = spin_changes(c.previous, c.state);
    const double area = sample_measure(c.state, h);
    const MeanStress<2> whole = sample_stress(c.state, h, area, moments);
    Mat2 disks = Mat2::Zero(), windows = Mat2::Zero();
    for (const MeanStress<2>& s : disk_stresses(c.state, h, moments)) {
      disks += s.area / area * s.total();
    }
    const double width = 1.2 * std::sqrt(area) / 7;
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j < 8; ++j) {
        const Vec2 lower = Vec2(i - 0.5, j - 0.5) * width;
        const MeanStress<2> s =
            window_stress(c.state, h, {lower, lower + Vec2(width, width)}, moments);
        windows += s.area / area * s.contact;
      }
    }
    result_.check("disks_error", difference(disks, whole.total()), "",
                  "disks' stresses, weighted by their areas, against the sample's",
                  "round-off: below 1e-12", difference(disks, whole.total()) < 1e-12, 2);
    result_.check("windows_error", difference(windows, whole.contact), "",
                  "contact parts of 64 windows that tile the sample against the sample's",
                  "round-off: below 1e-12", difference(windows, whole.contact) < 1e-12, 2);
  }

  /// A square lattice at rest: σ_yy is the weight above.
  void gravity() {
    const int side = context_.quick ? 10 : 20;
    Scene<2> scene = make_family_scene("square", side, {.mu = 0.0});
    scene.num_steps = 1;
    scene.solver.name = "apgd";
    scene.solver.tol = 1e-12;
    scene.solver.max_iterations = 100000;
    State<2> state = initial_state(scene);
    run_packing(scene, state, context_.interrupted, {});
    const std::vector<double> moments = contact_moments(state);
    Chart chart{.title = "Vertical stress against depth in a square lattice",
                .x = {"depth (m)", ChartAxis::Kind::kLinear, 0.0, {}},
                .y = {"σ_yy (Pa)", ChartAxis::Kind::kLinear, 0.0, {}}};
    ChartSeries rows{"windows, one row each", 0, {}}, theory{"ρ g depth", 1, {}};
    rows.kind = ChartSeries::Kind::kPoints;
    theory.kind = ChartSeries::Kind::kLine;
    const double specific_weight = -scene.gravity[1];  // 1 kg in 1 m²
    double worst = 0;
    for (int k = 0; k < side; ++k) {
      const Box<2> window{Vec2(0, side - k - 1), Vec2(side, side - k)};
      const double depth = k + 0.5;
      const double stress = window_stress(state, scene.step, window, moments).total()(1, 1);
      worst = std::max(worst, std::abs(stress / (specific_weight * depth) - 1));
      rows.points.push_back({depth, stress});
    }
    theory.points = {{0, 0}, {static_cast<double>(side), specific_weight * side}};
    chart.series = {theory, rows};
    result_.check("gravity_error", worst, "",
                  fmt::format("σ_yy in the rows of a square lattice of {0} × {0} disks against "
                              "ρ g depth, largest relative difference",
                              side),
                  "the solver's: below 1e-6", worst < 1e-6, 2);
    result_.draw("stress_depth",
                 "Square lattice under gravity, frictionless: windows of "
                 "one row, at their middle.",
                 chart, 2);
    result_.ours.emplace_back(
        "Disks and windows add up to the sample: {disks_error} and {windows_error}. Under gravity "
        "the rows of a square lattice carry the weight above them, to {gravity_error}.");
  }

  const PaperContext& context_;
  Findings result_;
};

}  // namespace

Findings run_stress(const PaperContext& context) { return StressItem(context).run(); }

}  // namespace bipot
