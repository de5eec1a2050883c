#include "core/motion/stress_tensor.h"

#include "core/motion/sample_area.h"
#include "core/scene/contact_detection.h"
#include "core/scene/generators.h"
#include "core/scene/scene_family.h"
#include "tests/support/scene_run.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

constexpr double kStep = 1e-3;

Disk disk(double x, double y, double radius, double mass = 1) {
  return {.x = Vec2(x, y), .radius = radius, .mass = mass, .inertia = 0.5 * mass * radius * radius};
}

/// A contact with the force f on disk i.
ContactOutcome<2> contact(int i, int j, const Vec2& n, const Vec2& force, double gap = 0) {
  return {.contact = {.i = i, .j = j, .n = n, .gap = gap},
          .s_n = kStep * force.dot(n),
          .s_t = kStep * force.dot(Vec2(-n[1], n[0])),
          .status = ContactStatus::kStick};
}

void expect_equal(const Mat2& a, const Mat2& b, double tolerance) {
  EXPECT_LE((a - b).cwiseAbs().maxCoeff(), tolerance) << "\n" << a << "\n\nand\n" << b;
}

/// Takes steps of a scene, tightly solved, and shows the states before and after each.
void run_steps(const Scene<2>& scene, int steps, double tol,
               const std::function<void(const State<2>&, const State<2>&)>& show) {
  TimeStepper<2> stepper = stepper_of(scene, "apgd", {.tol = tol, .max_iterations = 20000});
  State<2> state = initial_state(scene);
  for (int k = 0; k < steps; ++k) {
    const State<2> before = state;
    stepper.advance(state);
    show(before, state);
  }
}

/// Disks of three sizes in a small box whose four walls are pushed inwards: fast, overlapping,
/// sliding and turning.
Scene<2> pushed_box() {
  Scene<2> scene{
      .gravity = Vec2(0.3, -1),
      .bodies = random_filling(30, {{0.04, 1}, {0.05, 1}, {0.06, 1}}, 0.7, 0.02, 3, Vec2::Zero()),
      .materials = {"stone"},
      .laws = {{0.4, 0.1, 0.5}},
      .step = 2e-3};
  for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
    Disk& d = scene.bodies[k];
    give_mass(d, 100 * d.radius * d.radius);
    d.v = Vec2(0.1 * static_cast<double>(k % 3), 0.05);
  }
  scene.walls = box_walls(Vec2(0, 0), Vec2(0.7, 0.7));
  for (Wall<2>& wall : scene.walls) drive(wall, wall.normal, 2, 20);
  return scene;
}

TEST(StressTensor, OfTwoDisksSqueezedBetweenWallsIsForceOverHeight) {
  // Radii 1 and 2 between x = -1 and x = 5, F = 7 N: Σ F l = F 6, over the box 6 × 4: σ_xx = F / 4.
  State<2> state{.bodies = {disk(0, 0, 1), disk(3, 0, 2)}};
  state.walls = {half_space<2>(Vec2(-1, 0), Vec2(1, 0)), half_space<2>(Vec2(5, 0), Vec2(-1, 0)),
                 half_space<2>(Vec2(0, -2), Vec2(0, 1)), half_space<2>(Vec2(0, 2), Vec2(0, -1))};
  state.contacts = {contact(0, 1, Vec2(-1, 0), Vec2(-7, 0)), contact(0, 2, Vec2(1, 0), Vec2(7, 0)),
                    contact(1, 3, Vec2(-1, 0), Vec2(-7, 0))};
  const double area = sample_measure(state, kStep);
  EXPECT_DOUBLE_EQ(area, 24);
  const std::vector<double> moments = contact_moments(state);
  const MeanStress<2> stress = sample_stress(state, kStep, area, moments);
  expect_equal(stress.total(), Vec2(7.0 / 4, 0).asDiagonal(), 1e-14);
  EXPECT_DOUBLE_EQ(stress.pressure(), 7.0 / 8);
  EXPECT_DOUBLE_EQ(anisotropy(stress.total()), 1);
  // In a disk of radius a: Σ f r = F 2a over π a².
  const std::vector<MeanStress<2>> disks = disk_stresses(state, kStep, moments);
  EXPECT_DOUBLE_EQ(disks[0].contact(0, 0), 7 * 2 / std::numbers::pi);
  EXPECT_DOUBLE_EQ(disks[1].contact(0, 0), 7 * 4 / (4 * std::numbers::pi));
  // Between x = 0 and x = 3 there is a chain throughout, one of the four metres high: F / 4 again;
  // and F over the height of a flatter window.
  expect_equal(window_stress(state, kStep, {Vec2(0, -2), Vec2(3, 2)}, moments).contact,
               Vec2(7.0 / 4, 0).asDiagonal(), 1e-14);
  expect_equal(window_stress(state, kStep, {Vec2(0.5, -0.25), Vec2(2, 0.25)}, moments).contact,
               Vec2(14, 0).asDiagonal(), 1e-13);
  EXPECT_EQ(window_stress(state, kStep, {Vec2(0, 0.1), Vec2(3, 1)}, moments).contact.norm(), 0);
}

TEST(StressTensor, OfASquareLatticeUnderPressureIsForceOverDiameter) {
  // All contacts carry F = 3 N, disks of radius 0.5 m: σ = F / 2a in both directions.
  const int side = 4;
  State<2> state{.bodies = rectangular_lattice(side, side, 0.5, Vec2::Zero())};
  for (Disk& d : state.bodies) d.mass = d.inertia = 1;
  state.walls = box_walls(Vec2(0, 0), Vec2(side, side));
  for (const Contact<2>& c : detect_contacts(state.bodies, state.walls, 1e-9)) {
    state.contacts.push_back(contact(c.i, c.j, c.n, 3 * c.n));
  }
  EXPECT_EQ(state.contacts.size(), 2u * side * (side + 1));
  const auto moments = contact_moments(state);
  const double area = sample_measure(state, kStep);
  EXPECT_DOUBLE_EQ(area, side * side);
  expect_equal(sample_stress(state, kStep, area, moments).total(), 3 * Mat2::Identity(), 1e-13);
  for (const MeanStress<2>& s : disk_stresses(state, kStep, moments)) {
    expect_equal(s.contact, 3 * 4 / std::numbers::pi * Mat2::Identity(), 1e-13);
  }
  expect_equal(fabric_tensor(state), 0.5 * Mat2::Identity(), 1e-15);
  EXPECT_NEAR(anisotropy(fabric_tensor(state)), 0, 1e-15);
}

TEST(StressTensor, OfALatticeUnderGravityIsTheWeightAbove) {
  // Row k from the top carries (k - 1) m g above and k m g below: in a window over the row
  // σ_yy = (k - ½) m g / 2a = ρ g depth with ρ = m / (2a)².
  const int side = 6;
  Scene<2> scene = make_family_scene("square", side, {.mu = 0.0});
  run_steps(scene, 1, 1e-12, [&](const State<2>&, const State<2>& state) {
    const auto moments = contact_moments(state);
    for (int k = 1; k <= side; ++k) {
      const double top = side - k + 1;
      const MeanStress<2> stress =
          window_stress(state, scene.step, {Vec2(0, top - 1), Vec2(side, top)}, moments);
      EXPECT_NEAR(stress.contact(1, 1), (k - 0.5) * 9.81, 1e-5) << "row " << k;
    }
    const MeanStress<2> whole = sample_stress(state, scene.step, side * side, moments);
    EXPECT_NEAR(whole.contact(1, 1), 0.5 * side * 9.81, 1e-5);
  });
}

TEST(StressTensor, OfAGasIsMassTimesVelocityFluctuationsOverArea) {
  State<2> state{.bodies = {disk(0, 0, 0.1, 2), disk(1, 0, 0.1, 2), disk(0, 1, 0.1, 2)}};
  state.bodies[0].v = Vec2(5 + 1, 7);
  state.bodies[1].v = Vec2(5 - 1, 7 + 2);
  state.bodies[2].v = Vec2(5, 7 - 2);
  state.bodies[0].spin = 100;  // the ω² of rotation cancels against the disk's own stress
  const MeanStress<2> stress = sample_stress(state, kStep, 3, contact_moments(state));
  // Mean (5, 7): Σ m v' v' = 2 [(1, 0)² + (-1, 2)² + (0, -2)²], over 3 m².
  expect_equal(stress.total(), 2.0 / 3 * (Mat2() << 2, -2, -2, 8).finished(), 1e-13);
  EXPECT_EQ(stress.contact.norm(), 0);
  // The mean velocity of a window is its own: one disk has no fluctuations.
  const auto moments = contact_moments(state);
  EXPECT_EQ(window_stress(state, kStep, {Vec2(-0.5, -0.5), Vec2(0.5, 0.5)}, moments).kinetic.norm(),
            0);
  expect_equal(window_stress(state, kStep, {Vec2(-0.5, -0.5), Vec2(2, 0.5)}, moments).kinetic,
               2 / 2.5 * 2 * Vec2(1, -1) * Vec2(1, -1).transpose(), 1e-12);
}

TEST(StressTensor, TurnsWithTheSample) {
  const Scene<2> scene = pushed_box();
  const Eigen::Rotation2D<double> turn(0.7);
  const Mat2 R = turn.toRotationMatrix();
  run_steps(scene, 60, 1e-3, [&](const State<2>&, const State<2>& state) {
    if (state.step % 20 != 0) return;
    State<2> turned = state;
    for (Disk& d : turned.bodies) {
      d.x = turn * d.x;
      d.v = turn * d.v;
    }
    for (Wall<2>& w : turned.walls) {
      w.a = turn * w.a;
      w.v = turn * w.v;
      w.normal = turn * w.normal;
    }
    for (ContactOutcome<2>& o : turned.contacts) o.contact.n = turn * o.contact.n;
    const double area = sample_measure(state, scene.step);
    EXPECT_NEAR(sample_measure(turned, scene.step), area, 1e-12 * area);
    const auto moments = contact_moments(state);
    const MeanStress<2> a = sample_stress(state, scene.step, area, moments);
    const MeanStress<2> b = sample_stress(turned, scene.step, area, moments);
    EXPECT_GT(a.pressure(), 1);
    const double tolerance = 1e-12 * a.pressure();
    expect_equal(b.contact, R * a.contact * R.transpose(), tolerance);
    expect_equal(b.kinetic, R * a.kinetic * R.transpose(), tolerance);
    expect_equal(b.spin, R * a.spin * R.transpose(), tolerance);
    expect_equal(fabric_tensor(turned), R * fabric_tensor(state) * R.transpose(), 1e-13);
    EXPECT_NEAR(anisotropy(b.total()), anisotropy(a.total()), 1e-12);
  });
}

TEST(StressTensor, OfTheDisksAndOfWindowsAddUpToTheSamples) {
  const Scene<2> scene = pushed_box();
  run_steps(scene, 60, 1e-3, [&](const State<2>& before, const State<2>& state) {
    if (state.step % 20 != 0) return;
    const auto moments = spin_changes(before, state);
    const double area = sample_measure(state, scene.step);
    const MeanStress<2> whole = sample_stress(state, scene.step, area, moments);
    MeanStress<2> sum;
    const auto disks = disk_stresses(state, scene.step, moments);
    for (const MeanStress<2>& s : disks) {
      sum.contact += s.area / area * s.contact;
      sum.kinetic += s.area / area * s.kinetic;
      sum.spin += s.area / area * s.spin;
    }
    const double tolerance = 1e-12 * whole.pressure();
    expect_equal(sum.contact, whole.contact, tolerance);
    expect_equal(sum.kinetic, whole.kinetic, tolerance);
    expect_equal(sum.spin, whole.spin, tolerance);
    // 7 × 5 windows over more than the sample.
    MeanStress<2> tiled;
    for (int i = 0; i < 7; ++i) {
      for (int j = 0; j < 5; ++j) {
        const Box<2> window{Vec2(-0.1 + 0.13 * i, -0.1 + 0.19 * j),
                            Vec2(-0.1 + 0.13 * (i + 1), -0.1 + 0.19 * (j + 1))};
        const MeanStress<2> s = window_stress(state, scene.step, window, moments);
        tiled.contact += s.area / area * s.contact;
        tiled.spin += s.area / area * s.spin;
      }
    }
    expect_equal(tiled.contact, whole.contact, tolerance);
    expect_equal(tiled.spin, whole.spin, tolerance);
  });
}

TEST(StressTensor, IsSymmetricInMotionOnceTheSpinsAreCounted) {
  const Scene<2> scene = pushed_box();
  double largest = 0;
  run_steps(scene, 60, 1e-3, [&](const State<2>& before, const State<2>& state) {
    const MeanStress<2> stress = sample_stress(state, scene.step, 1, spin_changes(before, state));
    if (stress.contact.norm() == 0) return;
    EXPECT_LE(asymmetry(stress.total()), 1e-13) << "step " << state.step;
    largest = std::max(largest, asymmetry(stress.contact));
    for (const MeanStress<2>& s : disk_stresses(state, scene.step, spin_changes(before, state))) {
      const Mat2 t = s.total();
      EXPECT_LE(std::abs(t(0, 1) - t(1, 0)), 1e-9);
    }
    // Equal by the equations of motion.
    const auto moments = contact_moments(state), changes = spin_changes(before, state);
    for (std::size_t k = 0; k < moments.size(); ++k) EXPECT_NEAR(moments[k], changes[k], 1e-12);
  });
  EXPECT_GT(largest, 1e-2);  // the contact part alone is not
}

TEST(StressTensor, OfContactsIsSymmetricAtRest) {
  // A tilted triangular lattice, held by friction; the moments balance as well as the step is
  // solved.
  const Scene<2> scene = make_family_scene("triangular", 6, {.mu = 0.6, .tilt_degrees = 10});
  for (const double tol : {1e-4, 1e-12}) {
    run_steps(scene, 1, tol, [&](const State<2>&, const State<2>& state) {
      const MeanStress<2> stress = sample_stress(
          state, scene.step, sample_measure(state, scene.step), contact_moments(state));
      EXPECT_GT(std::abs(stress.contact(0, 1)), 1e-2 * stress.pressure());
      EXPECT_LT(asymmetry(stress.contact), tol > 1e-8 ? 1e-2 : 1e-9);
    });
  }
}

TEST(StressTensor, BalancesTheForcesOfTheWallsAtEveryStep) {
  // From (38), (43): with G = Σ m v ⊗ x,
  //   (G⁺ - G⁻)/h = Σ_contacts f ⊗ l + Σ_walls f ⊗ p + Σ m g ⊗ x_m + ½ Σ m (v⁻ ⊗ v⁻ + v⁺ ⊗ v⁺),
  // p the wall's point; the symmetric part to round-off, the antisymmetric one but for the couple
  // of overlaps, Σ f_t gap.
  const Scene<2> scene = pushed_box();
  double largest_couple = 0;
  run_steps(scene, 60, 1e-2, [&](const State<2>& before, const State<2>& state) {
    const double h = scene.step;
    const MeanStress<2> stress = sample_stress(state, h, 1, contact_moments(state));
    Mat2 change = Mat2::Zero(), kinetic = Mat2::Zero(), outside = Mat2::Zero();
    for (std::size_t k = 0; k < state.bodies.size(); ++k) {
      const Disk &a = before.bodies[k], &b = state.bodies[k];
      change += b.mass / h * (b.v * b.x.transpose() - a.v * a.x.transpose());
      kinetic += 0.5 * b.mass * (a.v * a.v.transpose() + b.v * b.v.transpose());
      outside += b.mass * scene.gravity * (b.x - 0.5 * h * b.v).transpose();
    }
    double couple = 0;
    for (const ContactOutcome<2>& o : state.contacts) {
      const Vec2& n = o.contact.n;
      const Vec2 force = (o.s_n * n + o.s_t * Vec2(-n[1], n[0])) / h;
      couple += o.s_t * o.contact.gap / h;
      if (o.contact.j < static_cast<int>(state.bodies.size())) continue;
      const Disk& d = state.bodies[static_cast<std::size_t>(o.contact.i)];
      const Vec2 point = d.x - 0.5 * h * d.v - (d.radius + o.contact.gap) * n;
      outside += force * point.transpose();
    }
    const Mat2 rest = change - kinetic - outside - stress.contact;
    const double scale = 1e-12 * (1 + stress.contact.norm() + change.norm());
    expect_equal(0.5 * (rest + rest.transpose()), Mat2::Zero(), scale);
    EXPECT_NEAR(rest(1, 0) - rest(0, 1), couple, scale);
    largest_couple = std::max(largest_couple, std::abs(couple));
  });
  EXPECT_GT(largest_couple, 1e-6);  // there were overlaps
}

TEST(SampleArea, IsThatOfTheWallsWhereTheyEncloseTheDisksElseOfTheHull) {
  State<2> state;
  EXPECT_EQ(sample_measure(state, kStep), 0);
  state.bodies = {disk(0, 0, 2)};
  const double circle = 4 * std::numbers::pi;
  EXPECT_NEAR(sample_measure(state, kStep), circle, 2e-4 * circle);
  // Hull of two disks of radius 2, six apart: the circle and the rectangle 6 × 4 between.
  state.bodies.push_back(disk(6, 0, 2));
  EXPECT_NEAR(sample_measure(state, kStep), circle + 24, 2e-4 * circle);
  // A smaller disk in between changes nothing; a box open at the top neither.
  state.bodies.push_back(disk(3, 1, 0.5));
  state.walls = {half_space<2>(Vec2(0, -2), Vec2(0, 1)), half_space<2>(Vec2(-2, 0), Vec2(1, 0)),
                 half_space<2>(Vec2(8, 0), Vec2(-1, 0))};
  EXPECT_NEAR(sample_measure(state, kStep), circle + 24, 2e-4 * circle);
  // A sloping lid, y + x/10 <= 5: heights 7.2 at x = -2 and 6.2 at x = 8 over the floor.
  state.walls.push_back(half_space<2>(Vec2(0, 5), Vec2(-0.1, -1).normalized()));
  EXPECT_NEAR(sample_measure(state, kStep), 67, 1e-10);
  // At mid-step: the lid has moved 2 m/s · h / 2 beyond it.
  state.walls[3].v = Vec2(0, 2);
  EXPECT_NEAR(sample_measure(state, 1.0), 67 - 10, 1e-10);
  // Walls that leave a disk out enclose nothing.
  state.walls[3].v.setZero();
  state.bodies.push_back(disk(3, 20, 1));
  EXPECT_GT(sample_measure(state, kStep), 80);
}

TEST(Tensors, AnisotropyAndAsymmetryAreRelativeToTheTrace) {
  const Mat2 tensor = (Mat2() << 3, 1, 0.5, 1).finished();
  EXPECT_DOUBLE_EQ(anisotropy(tensor), 2.5 / 4);  // √(2² + 1.5²)
  EXPECT_DOUBLE_EQ(asymmetry(tensor), 0.5 / 4);
  EXPECT_TRUE(std::isnan(anisotropy(Mat2::Zero())));
  EXPECT_TRUE(std::isnan(asymmetry(Mat2::Zero())));
  EXPECT_EQ(fabric_tensor(State<2>{}).norm(), 0);
}

}  // namespace
}  // namespace bipot
