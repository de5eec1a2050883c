#include "core/observables/observables.h"

#include "core/run_files/observable_output.h"
#include "core/run_files/run_output.h"
#include "core/scene/cluster_motion.h"
#include "core/scene/scene_parts.h"
#include "tests/support/scene_text.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

ContactOutcome<2> touching(int i, int j, const Vec2& n, double s_n,
                           ContactStatus status = ContactStatus::kStick) {
  return {.contact = {.i = i, .j = j, .n = n}, .s_n = s_n, .status = status};
}

/// Three disks on a floor in a row, the middle one on top of nothing: 0 touches the floor and 1, 1
/// touches the floor, 0 and 2; 2 touches 1 alone; 3 touches nothing.
Scene<2> row_scene(State<2>& state) {
  Scene<2> scene = one_law<2>({.mu = 0.3});
  scene.step = 0.5;
  for (int k = 0; k < 4; ++k) scene.bodies.push_back(round_body<2>(Vec2(0.2 * k, 0.1), 0.1, 2));
  scene.walls = {flat_floor<2>()};
  state = initial_state(scene);
  const Vec2 left(-1, 0), up(0, 1);
  state.contacts = {touching(0, 1, left, 3), touching(0, 4, up, 1, ContactStatus::kSlip),
                    touching(1, 2, left, 2), touching(1, 4, up, 2), touching(2, 3, left, 0)};
  return scene;
}

TEST(Observables, CoordinationWithAndWithoutRattlers) {
  // Loaded ends: disk 0 has 2, disk 1 has 3, disk 2 has 1, disk 3 none: mean 6/4. With friction two
  // contacts hold a disk: 2 and 3 rattle; without them 0 has 2 and 1 has 2: mean 2.
  State<2> state;
  const Scene<2> scene = row_scene(state);
  const Observables<2> seen = observe(scene, state, {});
  EXPECT_EQ(seen.bodies, 4);
  EXPECT_EQ(seen.rattlers, 2);
  EXPECT_EQ(seen.coordination, 1.5);
  EXPECT_EQ(seen.coordination_without, 2);
  EXPECT_EQ(seen.contacts, 4);
  EXPECT_EQ(seen.sliding_share(), 0.25);
  // Two normals along x, two along y.
  EXPECT_EQ(seen.fabric, Mat2(0.5 * Mat2::Identity()));
}

TEST(Observables, RattlersFallOneAfterTheOther) {
  // A free chain without friction or gravity: three contacts are needed, so the ends go, then all.
  Scene<2> scene = one_law<2>({});
  for (int k = 0; k < 5; ++k) scene.bodies.push_back(round_body<2>(Vec2(0.2 * k, 0), 0.1, 2));
  State<2> state = initial_state(scene);
  for (int k = 0; k < 4; ++k) state.contacts.push_back(touching(k, k + 1, Vec2(-1, 0), 1));
  for (const bool rattles : find_rattlers(scene, state)) EXPECT_TRUE(rattles);
  // With gravity two are enough in the middle, but not at the ends: they still fall one by one.
  scene.gravity = Vec2(0, -1);
  for (const bool rattles : find_rattlers(scene, state)) EXPECT_TRUE(rattles);
  state.contacts.push_back(touching(0, 5, Vec2(1, 0), 1));
  state.contacts.push_back(touching(4, 6, Vec2(-1, 0), 1));
  for (const bool rattles : find_rattlers(scene, state)) EXPECT_FALSE(rattles);
}

TEST(Observables, SolidFractionOfAWindow) {
  // A square lattice: pi/4 in any window of whole cells, wherever it begins.
  Scene<2> scene = one_law<2>({});
  for (int a = 0; a < 6; ++a) {
    for (int b = 0; b < 6; ++b) scene.bodies.push_back(round_body<2>(Vec2(a, b), 0.5, 2));
  }
  scene.step = 1;
  ObservableChoice<2> choice{.window = Box<2>{Vec2(0.7, 1.3), Vec2(3.7, 4.3)}};
  EXPECT_NEAR(observe(scene, initial_state(scene), choice).solid_fraction, std::numbers::pi / 4,
              1e-13);
  EXPECT_EQ(observe(scene, initial_state(scene), choice).bodies, 9);
}

TEST(Observables, ShearRateInertialNumberAndFriction) {
  // v = 3 y e_x + a translation: simple shear of rate 3. Stress by hand: sigma_1 = 5, sigma_2 = 3,
  // pressure 4, mass 2: I = 3 sqrt(2/4), tau/P = 2/8.
  Scene<2> scene = one_law<2>({});
  scene.step = 1;
  for (int k = 0; k < 9; ++k) {
    const Vec2 x(k % 3, k / 3 + 0.1 * k);
    scene.bodies.push_back(round_body<2>(x, 0.1, 2, Vec2(7 + 3 * x[1], -2)));
  }
  Observables<2> seen = observe(scene, initial_state(scene), {});
  EXPECT_NEAR(seen.shear_rate(), 3, 1e-12);
  EXPECT_NEAR((seen.velocity_gradient - (Mat2() << 0, 3, 0, 0).finished()).norm(), 0, 1e-12);
  seen.stress.contact << 5, 0, 0, 3;
  seen.stress.kinetic.setZero();
  seen.stress.spin.setZero();
  EXPECT_NEAR(seen.inertial_number(), 3 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(seen.friction(), 0.25, 1e-15);
}

TEST(Observables, ProfileOfShear) {
  // Disks of radius 0.1 in two rows, in bins 0.2 high between the walls x = 0 and x = 1: each bin
  // holds five whole disks, solid fraction 5 pi 0.01/0.2; the third bin is empty.
  Scene<2> scene = one_law<2>({});
  scene.step = 1;
  for (int k = 0; k < 10; ++k) {
    const Vec2 x(0.1 + 0.2 * (k % 5), 0.1 + 0.2 * (k / 5));
    scene.bodies.push_back(round_body<2>(x, 0.1, 2, Vec2(k / 5, k % 2 == 0 ? 1 : -1), 4));
  }
  scene.walls = {half_space<2>(Vec2::Zero(), Vec2(1, 0)), half_space<2>(Vec2(1, 0), Vec2(-1, 0))};
  ObservableChoice<2> choice{.profile = ProfileChoice{.axis = 1, .bins = 3, .low = 0, .high = 0.6}};
  const Profile<2> p = observe_profile(initial_state(scene), 1, choice);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_NEAR(p.position[b], 0.1 + 0.2 * static_cast<double>(b), 1e-15);
    EXPECT_NEAR(p.solid_fraction[b], 5 * std::numbers::pi * 0.01 / 0.2, 1e-12);
    EXPECT_NEAR(p.velocity[b][0], static_cast<double>(b), 1e-12);
    EXPECT_NEAR(p.spin[b], 4, 1e-12);
    // vy: +1, -1, +1, -1, +1 (mean 1/5) and the other way round: half of 1 - 1/25.
    EXPECT_NEAR(p.temperature[b], 0.5 * (1 - 0.04), 1e-12);
  }
  EXPECT_EQ(p.solid_fraction[2], 0);
  EXPECT_TRUE(std::isnan(p.velocity[2][0]));
}

TEST(Observables, FluxThroughALineIsTheMassThatCrosses) {
  // A disk of 2 kg flies upwards through a line and beside its end: the flux's integral (midpoint
  // rule) is the mass that has crossed, half of it where the line ends at the disk's centre. Seen
  // from a to b, left is up.
  for (const double end : {1.0, 0.0}) {
    const FluxLine line{.name = "l", .a = Vec2(-1, 0), .b = Vec2(end, 0)};
    State<2> state{.bodies = {round_body<2>(Vec2::Zero(), 0.1, 2, Vec2(0, 2))}};
    double crossed = 0;
    constexpr int kSteps = 10000;
    for (int k = 0; k < kSteps; ++k) {
      state.bodies[0].x[1] = -0.2 + 0.4 * (k + 0.5) / kSteps;
      crossed += mass_flux(state, line) * 0.2 / kSteps;  // 0.4 m at 2 m/s
    }
    EXPECT_NEAR(crossed, end > 0 ? 2 : 1, 1e-5);
  }
}

TEST(Observables, ForcesOverTheirMean) {
  State<2> state;
  const Scene<2> scene = row_scene(state);
  // 3, 1, 2, 2 N s in 0.5 s: mean 4 N. Over the mean 1.5, 0.5, 1, 1; bins of 0.5 up to 1.5: the
  // last holds what lies at its end and beyond.
  const ForceDistribution forces =
      observe_forces(state, scene.step, {.force_bins = 3, .force_limit = 1.5});
  EXPECT_EQ(forces.mean, 4);
  EXPECT_EQ(forces.counts, (std::vector<int>{0, 1, 3}));
}

// -4 and 2 N s in 0.5 s: magnitudes 8 and 4 N, mean 6 N; over it 4/3 and 2/3 in bins of 0.5. A limit
// far below all forces puts them into the last bin.
TEST(Observables, TensionsCountByTheirMagnitudeAndTheLastBinHoldsAllBeyond) {
  State<2> state;
  const Scene<2> scene = row_scene(state);
  ASSERT_GE(state.contacts.size(), 2u);
  state.contacts.resize(2);
  state.contacts[0].s_n = -4;
  state.contacts[0].status = ContactStatus::kStick;
  state.contacts[1].s_n = 2;
  const ForceDistribution forces =
      observe_forces(state, scene.step, {.force_bins = 3, .force_limit = 1.5});
  EXPECT_EQ(forces.mean, 6);
  EXPECT_EQ(forces.counts, (std::vector<int>{0, 1, 1}));
  EXPECT_EQ(observe_forces(state, scene.step, {.force_bins = 3, .force_limit = 1e-12}).counts,
            (std::vector<int>{0, 0, 2}));
}

TEST(Observables, OfAPeriodicRowAreThoseOfEveryCell) {
  // A row of touching disks around a cell: everybody has two neighbours; and a window at the edge
  // sees the contact across it.
  Scene<2> scene = one_law<2>({.mu = 0.3});
  scene.step = 1;
  scene.cell.in_x = true;
  scene.cell.width.length = 1;
  for (int k = 0; k < 5; ++k)
    scene.bodies.push_back(round_body<2>(Vec2(0.1 + 0.2 * k + (k == 2 ? 3 : 0), 0.1), 0.1, 2));
  State<2> state = initial_state(scene);
  for (int k = 0; k < 4; ++k) {
    state.contacts.push_back(touching(k, k + 1, Vec2(-1, 0), 1));
    state.contacts.back().contact.image_x = k == 1 ? -3 : k == 2 ? 3 : 0;
  }
  state.contacts.insert(state.contacts.begin() + 1, touching(0, 4, Vec2(1, 0), 1));
  state.contacts[1].contact.image_x = -1;
  ObservableChoice<2> whole, edge;
  whole.window = {Vec2(0, 0), Vec2(1, 0.2)};
  edge.window = {Vec2(0, 0), Vec2(0.05, 0.2)};
  const Observables<2> all = observe(scene, state, whole), part = observe(scene, state, edge);
  EXPECT_EQ(all.coordination, 2);
  EXPECT_NEAR(all.solid_fraction, 5 * std::numbers::pi * 0.01 / 0.2, 1e-12);
  // 1 N s in 1 s along x at each of 5 contacts, branches of 0.2 m: 5 (1)(0.2)/(1 x 0.2) Pa, the
  // same in every slice.
  EXPECT_NEAR(all.stress.contact(0, 0), 5, 1e-12);
  EXPECT_NEAR(part.stress.contact(0, 0), 5, 1e-12);
}

TEST(Observables, OfAWindowLongerThanTheCellAreThoseOfTheCell) {
  // 2 x 3 cells of 0.5 m x 0.4 m, offset by 0.1 m, with one disk of 1 kg. Its images move with the
  // cell, 0.4 m/s faster for each cell further up.
  State<2> state;
  state.cell.in_x = state.cell.in_y = true;
  state.cell.width.length = 0.5;
  state.cell.height = {.motion = CellSide::Motion::kMoving, .length = 0.4, .speed = 0.4};
  state.cell.offset.length = 0.1;
  state.bodies = {round_body<2>(Vec2(0.1, 0.1), 0.05, 1)};
  Scene<2> scene = one_law<2>({});
  scene.step = 1e-3;
  ObservableChoice<2> choice{.window = Box<2>{Vec2(0, 0), Vec2(1, 1.2)}};
  const Observables<2> seen = observe(scene, state, choice);
  EXPECT_NEAR(seen.solid_fraction, std::numbers::pi * 0.0025 / 0.2, 1e-12);
  // Speeds along y 0, 0.4 and 0.8 m/s, twice: Σ m (v - 0.4)² = 4 · 0.16 J over 1.2 m².
  EXPECT_NEAR(seen.stress.kinetic(1, 1), 0.64 / 1.2, 1e-12);
  // Cut below the middle of the third row: two rows and a half.
  choice.window = {Vec2(0, 0), Vec2(1, 0.9)};
  EXPECT_NEAR(observe(scene, state, choice).solid_fraction, 5 * std::numbers::pi * 0.0025 / 0.9,
              1e-12);
  // A line through the middle of both disks of the third row: chords of 0.1 m, at 3 + 0.8 m/s.
  state.bodies[0].v = Vec2(0, 3);
  FluxLine line;
  line.a = Vec2(0, 0.9);
  line.b = Vec2(1, 0.9);
  EXPECT_NEAR(mass_flux(state, line), 2 * 0.1 * 3.8 / (std::numbers::pi * 0.0025), 1e-10);
  choice.profile = ProfileChoice{.axis = 1, .bins = 3, .low = 0, .high = 1.2};
  const Profile<2> rows = observe_profile(state, scene.step, choice);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(rows.velocity[to_size(k)][1], 3 + 0.4 * k, 1e-12);
}

TEST(Observables, FilesAndTheirMeans) {
  const TemporaryFolder folder;
  const std::string text =
      "disks = [{position = [0, 0.1], radius = 0.1, mass = 2, velocity = [1, 0]}]\n"
      "walls = [{point = [0, 0], normal = [0, 1]}]\ntime = {step = 0.5, steps = 8}\n"
      "[observables]\nevery = 2\nstarts = 2\nprofile = 'y'\nprofile_range = [0, 0.2]\n"
      "profile_bins = 2\nforce_bins = 2\nforce_limit = 2\n"
      "lines = [{name = 'gate', from = [0, -1], to = [0, 1]}]\n";
  const Scene<2> scene = scene_of(text);
  State<2> state = initial_state(scene);
  {
    RunWriter<2> writer(folder / "out", scene, text);
    for (state.step = 1; state.step <= 8; ++state.step) {
      state.time = 0.5 * state.step;
      state.contacts = {touching(0, 1, Vec2(0, 1), state.step)};
      state.bodies[0].v[0] = state.step;
      writer.step(state, {});
    }
    state.step = 8;
    writer.frame(state);
    writer.close();
  }
  // Measured at steps 2, 4, 6, 8; the means begin at 2 s = step 4.
  const NumberTable rows = read_number_table(folder / "out/observables.csv");
  ASSERT_EQ(rows.rows.size(), 4u);
  EXPECT_EQ(rows.rows[3][rows.column("contacts")], 1);
  // The line points up, its left is -x: the whole disk's width 0.2 crosses with velocity 8.
  EXPECT_NEAR(rows.rows[3][rows.column("flux_gate")], -2 / (std::numbers::pi * 0.01) * 0.2 * 8,
              1e-6);
  EXPECT_TRUE(says(file_text(folder / "out/observables_mean.csv"), "\ncontacts,1,0,3\n"));
  const NumberTable profile = read_number_table(folder / "out/profile_mean.csv");
  ASSERT_EQ(profile.rows.size(), 2u);
  EXPECT_NEAR(profile.rows[0][profile.column("vx")], 6, 1e-12);  // of 4, 6, 8
  const NumberTable forces = read_number_table(folder / "out/forces_mean.csv");
  EXPECT_EQ(forces.rows[1][forces.column("count")], 3);
  EXPECT_EQ(forces.rows[1][forces.column("density")], 1);
  const Hdf5File frame(folder / "out/frames/00000008.h5", Hdf5File::Mode::kRead);
  EXPECT_EQ(frame.read_double("/observables/coordination"), 1);
  EXPECT_EQ(frame.read_doubles("/observables/profile/vx").size(), 2u);
  EXPECT_EQ(frame.read_ints("/observables/forces/counts"), (std::vector<int>{0, 1}));
}

/// Eight unit spheres of 5 kg in a box that they fill as a cubic lattice; each of the 12 contacts
/// between them and the 24 with the walls carries 1 N. All move with v = (2 z, 0, 0) 1/s.
State<3> filled_box() {
  State<3> state;
  for (int k = 0; k < 8; ++k) {
    const Vec3 x(1 + 2 * (k % 2), 1 + 2 * (k / 2 % 2), 1 + 2 * (k / 4));
    state.bodies.push_back(round_body<3>(x, 1, 5, Vec3(2 * x[2], 0, 0)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    state.walls.push_back(half_space<3>(Vec3::Zero(), Vec3::Unit(axis)));
    state.walls.push_back(half_space<3>(Vec3::Constant(4), -Vec3::Unit(axis)));
  }
  for (int i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const bool upper = (i >> axis & 1) != 0;
      const Vec3 n = Vec3::Unit(axis);
      if (!upper) {
        state.contacts.push_back({.contact = {.i = i, .j = i + (1 << axis), .n = -n}, .s_n = 1});
      }
      const int wall = 8 + 2 * axis + (upper ? 1 : 0);
      state.contacts.push_back({.contact = {.i = i, .j = wall, .n = upper ? Vec3(-n) : n},
                                .s_n = 1,
                                .status = ContactStatus::kSlip});
    }
  }
  return state;
}

TEST(Observables, OfSpheresInACubicLatticeAreKnown) {
  // Six contacts each, a third of the normals along each axis, π/6 of space. Four columns of 1 N
  // press on 16 m²: 0.25 Pa; the shear adds ρ v'² : v' = ±2 m/s of 5 kg, 8 · 5 · 4 / 64 = 2.5 Pa in
  // xx. Its rate is 2 1/s, and with d = 2 m, ρ = 5/(4π/3) the inertial number 2 · 2 √(ρ/P).
  Scene<3> scene = one_law<3>({.mu = 0.5});
  scene.step = 1;
  State<3> state = filled_box();
  for (Sphere& s : state.bodies) s.x += 0.5 * s.v;  // so that mid-step is where they touch
  Observables<3> seen = observe<3>(scene, state, {});
  EXPECT_EQ(seen.bodies, 8);
  EXPECT_EQ(seen.rattlers, 0);
  EXPECT_EQ(seen.contacts, 36);
  EXPECT_NEAR(seen.sliding_share(), 24.0 / 36, 1e-15);
  EXPECT_NEAR(seen.coordination, 6, 1e-15);
  EXPECT_LT((seen.fabric - Mat<3>::Identity() / 3).norm(), 1e-15);
  EXPECT_NEAR(seen.solid_fraction, std::numbers::pi / 6, 1e-12);
  Mat<3> stress = 0.25 * Mat<3>::Identity();
  stress(0, 0) += 2.5;
  EXPECT_LT((seen.stress.total() - stress).norm(), 1e-12);
  state = filled_box();  // for the fit, places at the end of the step as the field has them
  seen = observe<3>(scene, state, {});
  EXPECT_NEAR(seen.velocity_gradient(0, 2), 2, 1e-12);
  EXPECT_NEAR(seen.shear_rate(), 2, 1e-12);
  const double density = 5 / (4 * std::numbers::pi / 3);
  EXPECT_NEAR(seen.density, density, 1e-12);
  EXPECT_NEAR(seen.inertial_number() * std::sqrt(seen.stress.pressure()), 4 * std::sqrt(density),
              1e-11);
  // A loose sphere is a rattler, and lowers the coordination of all but not that of the others.
  state.bodies.push_back(round_body<3>(Vec3(2, 2, 2), 0.1, 2));
  for (ContactOutcome<3>& o : state.contacts) {
    if (o.contact.j >= 8) ++o.contact.j;
  }
  seen = observe<3>(scene, state, {});
  EXPECT_EQ(seen.rattlers, 1);
  EXPECT_NEAR(seen.coordination, 48.0 / 9, 1e-14);
  EXPECT_NEAR(seen.coordination_without, 6, 1e-15);
  EXPECT_EQ(observe_forces<3>(state, 1, {}).mean, 1);
}

TEST(Observables, OfAWindowInALatticeOfSpheresAreThoseOfTheLattice) {
  // A cubic lattice of 4 x 4 x 4 unit spheres, 1 N at each of its contacts. A window of 2 x 2 x 2
  // cells, wherever it begins, has π/6 of solid; one that begins in a sphere's middle less a half
  // has 8 spheres of 6 contacts each. Every unit of area across an axis carries 1 N / 4 m².
  Scene<3> scene = one_law<3>({.mu = 0.5});
  scene.step = 1;
  State<3> state;
  const auto number = [](int a, int b, int c) { return a + 4 * b + 16 * c; };
  for (int c = 0; c < 4; ++c) {
    for (int b = 0; b < 4; ++b) {
      for (int a = 0; a < 4; ++a)
        state.bodies.push_back(round_body<3>(Vec3(2 * a, 2 * b, 2 * c), 1, 2));
    }
  }
  for (int i = 0; i < 64; ++i) {
    const int at[3] = {i % 4, i / 4 % 4, i / 16};
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] == 3) continue;
      const int j = i + number(axis == 0 ? 1 : 0, axis == 1 ? 1 : 0, axis == 2 ? 1 : 0);
      state.contacts.push_back({.contact = {.i = i, .j = j, .n = -Vec3::Unit(axis)}, .s_n = 1});
    }
  }
  ObservableChoice<3> choice{.window = Box<3>{Vec3(1.3, 0.6, 1.9), Vec3(5.3, 4.6, 5.9)}};
  Observables<3> seen = observe<3>(scene, state, choice);
  EXPECT_NEAR(seen.solid_fraction, std::numbers::pi / 6, 1e-13);
  EXPECT_LT((seen.stress.total() - 0.25 * Mat<3>::Identity()).norm(), 1e-13);
  choice.window = {Vec3(1, 1, 1), Vec3(5, 5, 5)};
  seen = observe<3>(scene, state, choice);
  EXPECT_EQ(seen.bodies, 8);
  EXPECT_EQ(seen.coordination, 6);
  // Contacts at 1, 3 and 5 along one axis, of which 5 is outside, and at 2 and 4 along the others:
  // 2 x 2 x 2 x 3.
  EXPECT_EQ(seen.contacts, 24);
  EXPECT_LT((seen.fabric - Mat<3>::Identity() / 3).norm(), 1e-15);
  EXPECT_EQ(observe_forces<3>(state, 1, choice).counts[5],
            24);  // of 30 bins up to 6 times the mean
  EXPECT_NEAR(seen.mean_diameter, 2, 1e-15);
  choice.window = {Vec3(1, 1, 1), Vec3(1, 5, 5)};
  EXPECT_THROW(observe<3>(scene, state, choice), std::invalid_argument);
}

TEST(Observables, ProfileOfSpheresIsCutExactly) {
  // Unit spheres at z = 1 and z = 3 in a shaft of 2 x 2, in bins from 0 to 0.5, ... 4. The slice of
  // a sphere between two planes: caps of height h have π h² (3 - h)/3, so that 0.5 gives 5 π/24 and
  // 1 gives 16 π/24.
  Scene<3> scene = one_law<3>({});
  State<3> state;
  state.bodies = {round_body<3>(Vec3(0, 0, 1), 1, 2, Vec3(1, 2, 3), Vec3(4, 5, 6)),
                  round_body<3>(Vec3(0, 0, 3), 1, 2, Vec3(-1, 2, 3))};
  for (int axis = 0; axis < 2; ++axis) {
    state.walls.push_back(half_space<3>(-Vec3::Unit(axis), Vec3::Unit(axis)));
    state.walls.push_back(half_space<3>(Vec3::Unit(axis), -Vec3::Unit(axis)));
  }
  ObservableChoice<3> choice{.profile = ProfileChoice{.axis = 2, .bins = 8, .low = 0, .high = 4}};
  Profile<3> p = observe_profile<3>(state, 1e-9, choice);
  const double pi = std::numbers::pi;
  for (std::size_t b = 0; b < 8; ++b) {
    const bool end = b % 4 == 0 || b % 4 == 3;
    EXPECT_NEAR(p.solid_fraction[b], (end ? 5 : 11) * pi / 24 / (0.5 * 4), 1e-13);
    EXPECT_LT((p.velocity[b] - Vec3(b < 4 ? 1 : -1, 2, 3)).norm(), 1e-12);
    EXPECT_LT((p.spin[b] - (b < 4 ? Vec3(4, 5, 6) : Vec3(0, 0, 0))).norm(), 1e-12);
    EXPECT_NEAR(p.temperature[b], 0, 1e-12);
  }
  // Both in one bin: half each, v_x = ±1 about 0, a third of 1.
  choice.profile = ProfileChoice{.axis = 2, .bins = 1, .low = 0, .high = 4};
  p = observe_profile<3>(state, 1e-9, choice);
  EXPECT_NEAR(p.temperature[0], 1.0 / 3, 1e-12);
  EXPECT_NEAR(p.solid_fraction[0], pi / 6, 1e-13);
  // In a pipe of radius 1 instead: 8/3 π of 4 π.
  Wall<3> pipe{.shape = Wall<3>::Shape::kHollowCircle, .normal = Vec3::UnitZ(), .radius = 1};
  state.walls = {pipe};
  EXPECT_NEAR(observe_profile<3>(state, 1e-9, choice).solid_fraction[0], 2.0 / 3, 1e-12);
  // A small sphere somewhere in it: 4/3 π 0.1³ of 4 π, wherever its own box is.
  state.bodies = {round_body<3>(Vec3(0.3, 0, 2), 0.1, 2)};
  EXPECT_NEAR(observe_profile<3>(state, 1e-9, choice).solid_fraction[0], 1e-3 / 3, 1e-15);
}

TEST(Observables, StressOfABinIsTheWeightAboveIt) {
  // Three unit spheres on top of each other in a shaft of 2 x 2, that of weight w at the top: the
  // contacts at z = 0, 2 and 4 carry 3, 2 and 1 w. Branches from 1 to the floor, 3 to 1, 5 to 3:
  // over bins of 1 m, σ_zz = 3, 2, 2, 1, 1, 0 w/4.
  State<3> state;
  for (int k = 0; k < 3; ++k) state.bodies.push_back(round_body<3>(Vec3(0, 0, 1 + 2 * k), 1, 2));
  for (int axis = 0; axis < 2; ++axis) {
    state.walls.push_back(half_space<3>(-Vec3::Unit(axis), Vec3::Unit(axis)));
    state.walls.push_back(half_space<3>(Vec3::Unit(axis), -Vec3::Unit(axis)));
  }
  state.walls.push_back(half_space<3>(Vec3::Zero(), Vec3::UnitZ()));
  const double weight = 7, step = 0.5;
  state.contacts = {{.contact = {.i = 0, .j = 1, .n = -Vec3::UnitZ()}, .s_n = 2 * weight * step},
                    {.contact = {.i = 0, .j = 7, .n = Vec3::UnitZ()}, .s_n = 3 * weight * step},
                    {.contact = {.i = 1, .j = 2, .n = -Vec3::UnitZ()}, .s_n = weight * step}};
  ObservableChoice<3> choice{.profile = ProfileChoice{.axis = 2, .bins = 6, .low = 0, .high = 6}};
  const Profile<3> p = observe_profile<3>(state, step, choice);
  const double expected[] = {3, 2, 2, 1, 1, 0};
  for (std::size_t b = 0; b < 6; ++b) {
    Mat<3> stress = Mat<3>::Zero();
    stress(2, 2) = expected[b] * weight / 4;
    EXPECT_LT((p.stress[b] - stress).norm(), 1e-12) << b;
  }
}

TEST(Observables, FluxThroughAFaceIsTheMassThatCrosses) {
  // A sphere of 2 kg flies along (1, 1, 0)/√2 through faces across that way; the flux's integral
  // (midpoint rule) is the mass that has crossed: all of it through the plane, and through a disk
  // and a rectangle that are wide enough; none beside them; half of it through a rectangle whose
  // edge its centre meets, and against the normal negative.
  const Vec3 way = Vec3(1, 1, 0).normalized(), up = Vec3::UnitZ();
  const auto crossed = [&](const FluxFace& face) {
    State<3> state{.bodies = {round_body<3>(Vec3::Zero(), 0.1, 2, 3 * way)}};
    double mass = 0;
    constexpr int kSteps = 10000;
    for (int k = 0; k < kSteps; ++k) {
      state.bodies[0].x = (-0.2 + 0.4 * (k + 0.5) / kSteps) * way;
      mass += mass_flux(state, face) * 0.4 / 3 / kSteps;  // 0.4 m at 3 m/s
    }
    return mass;
  };
  using Shape = FluxFace::Shape;
  FluxFace face{.name = "f", .normal = way, .along = up};
  EXPECT_NEAR(crossed(face), 2, 1e-6);
  face.shape = Shape::kDisk;
  face.radius = 0.1;
  EXPECT_NEAR(crossed(face), 2, 1e-6);
  face.normal = -way;
  EXPECT_NEAR(crossed(face), -2, 1e-6);
  face.point = 0.21 * up;
  EXPECT_EQ(crossed(face), 0);
  face = {.shape = Shape::kRectangle,
          .point = 0.5 * up,
          .normal = way,
          .along = up,
          .size = Vec2(1, 0.3)};
  EXPECT_NEAR(crossed(face), 1, 1e-6);  // the side of 1 m begins at the sphere's centre
  face.along = up.cross(way);           // now the side of 0.3 m is upright: 0.35 to 0.65
  EXPECT_EQ(crossed(face), 0);
}

TEST(Observables, FluxThroughAPlaneInAPeriodicCellCountsEachSphereOnce) {
  // A sphere in the corner of the cell, falling: its section with the plane z = 0 is a circle of
  // radius √(1 - 0.36) = 0.8 in four parts. Along x, it leaves at x = 4 and comes in at x = 0, the
  // same place.
  State<3> state;
  state.cell.in_x = state.cell.in_y = true;
  state.cell.width.length = state.cell.height.length = 4;
  state.bodies = {round_body<3>(Vec3(4, 8, 0.6), 1, 2, Vec3(3, 0, -5))};
  const double density = 2 / (4 * std::numbers::pi / 3), pi = std::numbers::pi;
  EXPECT_NEAR(mass_flux(state, FluxFace{}), -5 * density * 0.64 * pi, 1e-12);
  const FluxFace across{.point = Vec3(4, 0, 0), .normal = Vec3::UnitX(), .along = Vec3::UnitY()};
  EXPECT_NEAR(mass_flux(state, across), 3 * density * pi, 1e-12);
}

/// A dumbbell of two touching disks of radius 1 and 6 kg on a floor, and a disk of 2 kg that lies
/// on both.
Scene<2> dumbbell_scene(State<2>& state) {
  Scene<2> scene = one_law<2>({.mu = 0.3});
  scene.step = 0.5;
  scene.bodies = {round_body<2>(Vec2(1, 1), 1, 2), round_body<2>(Vec2(3, 1), 1, 2)};
  join_disks(scene, 2, {.mass = 6});
  scene.bodies.push_back(round_body<2>(Vec2(2, 1 + std::sqrt(3.0)), 1, 2));
  scene.clusters.arms.emplace_back(Vec2::Zero());
  scene.walls = {flat_floor<2>()};
  state = initial_state(scene);
  const Vec2 up(0, 1), left(-0.5, -std::sqrt(0.75));
  state.contacts = {touching(0, 2, left, 1), touching(0, 3, up, 2),
                    touching(1, 2, Vec2(0.5, left[1]), 1), touching(1, 3, up, 2)};
  return scene;
}

TEST(Observables, AClusterIsOneBody) {
  // Two bodies, four contacts; the dumbbell has all four, the disk two: mean 3. Mean mass (6 +
  // 2)/2. Both are held: the disk by two contacts, though each of the dumbbell's disks alone has
  // two as well.
  State<2> state;
  const Scene<2> scene = dumbbell_scene(state);
  ASSERT_EQ(validate(scene), "");
  Observables<2> seen = observe(scene, state, {});
  EXPECT_EQ(seen.bodies, 2);
  EXPECT_EQ(seen.rattlers, 0);
  EXPECT_EQ(seen.contacts, 4);
  EXPECT_EQ(seen.coordination, 3);
  EXPECT_EQ(seen.mean_mass, 4);
  // Over the right half there are the right disk, π, and half of the upper one; a window that
  // begins just left of the middle has both centres, one just right of it none.
  ObservableChoice<2> choice{.window = Box<2>{Vec2(2, 0), Vec2(4, 4)}};
  EXPECT_NEAR(observe(scene, state, choice).solid_fraction, 1.5 * std::numbers::pi / 8, 1e-13);
  choice.window->lower[0] = 1.99;
  EXPECT_EQ(observe(scene, state, choice).bodies, 2);
  choice.window->lower[0] = 2.01;
  EXPECT_EQ(observe(scene, state, choice).bodies, 0);
  // With one contact left the dumbbell rattles, and then the disk does.
  state.contacts.resize(1);
  seen = observe(scene, state, {});
  EXPECT_EQ(seen.rattlers, 2);
  EXPECT_TRUE(find_rattlers(scene, state)[1]);
}

TEST(Observables, WhatTwoDisksOfAClusterCoverCountsOnce) {
  // Two unit disks, one through the centre of the other: 2 π - (2 π/3 - √3/2), over bins that hold
  // all of it, and half of it on either side of x = 0.5.
  Scene<2> scene = one_law<2>({});
  scene.step = 1;
  scene.bodies = {round_body<2>(Vec2(0, 0), 1, 2), round_body<2>(Vec2(1, 0), 1, 2)};
  join_disks(scene, 2, {.mass = 1});
  scene.clusters.bodies[0].v = Vec2(3, 4);
  scene.clusters.bodies[0].spin = 5;
  place_members(scene.clusters, scene.bodies);
  const State<2> state = initial_state(scene);
  const double area = 4 * std::numbers::pi / 3 + std::sqrt(0.75);
  ObservableChoice<2> choice{.window = Box<2>{Vec2(-1, -1), Vec2(2, 1)}};
  EXPECT_NEAR(observe(scene, state, choice).solid_fraction, area / 6, 1e-14);
  EXPECT_NEAR(observe(scene, state, {}).mean_mass, 1, 0);
  choice.profile = ProfileChoice{.axis = 0, .bins = 3, .low = -2.5, .high = 6.5};
  const Profile<2> p = observe_profile(state, 1, choice);
  for (const std::size_t b : {0u, 1u}) {
    EXPECT_NEAR(p.solid_fraction[b], area / 2 / 6, 1e-14);
    EXPECT_LT((p.velocity[b] - Vec2(3, 4)).norm(), 1e-13);  // of the centre of mass
    EXPECT_NEAR(p.spin[b], 5, 1e-13);
  }
  EXPECT_TRUE(std::isnan(p.velocity[2][0]));
}

TEST(Observables, FluxOfATurningClusterIsItsMass) {
  // Three disks that overlap, of 3 kg, fall and turn through a line; the flux's integral (midpoint
  // rule) is the mass, which it would not be without the spin, nor if what two disks cover counted
  // twice.
  Scene<2> scene = one_law<2>({});
  scene.step = 1;
  scene.bodies = {round_body<2>(Vec2(0, 0), 0.3, 2), round_body<2>(Vec2(0.4, 0), 0.2, 2),
                  round_body<2>(Vec2(0.2, 0.3), 0.2, 2)};
  join_disks(scene, 3, {.mass = 3});
  scene.clusters.bodies[0].v = Vec2(0.3, -2);
  scene.clusters.bodies[0].spin = 4;
  place_members(scene.clusters, scene.bodies);
  State<2> state = initial_state(scene);
  const FluxLine line{.name = "l", .a = Vec2(5, -1), .b = Vec2(-5, -1)};  // its left is down
  double crossed = 0;
  constexpr int kSteps = 20000;
  for (int k = 0; k < kSteps; ++k) {
    drift(state.clusters.bodies[0], 0.5 / kSteps);
    place_members(state.clusters, state.bodies);
    crossed += mass_flux(state, line) / kSteps;
    drift(state.clusters.bodies[0], 0.5 / kSteps);
  }
  EXPECT_NEAR(crossed, 3, 1e-5);
}

TEST(Observables, AClusterAcrossTheEdgeOfACellIsSeenWhole) {
  // A dumbbell along x whose centre of mass lies on the edge of the cell, two periods away.
  Scene<2> scene = one_law<2>({});
  scene.step = 1;
  scene.cell.in_x = true;
  scene.cell.width.length = 5;
  scene.bodies = {round_body<2>(Vec2(9, 1), 1, 2), round_body<2>(Vec2(11, 1), 1, 2)};
  join_disks(scene, 2, {.mass = 1});
  ASSERT_EQ(validate(scene), "");
  const State<2> state = initial_state(scene);
  ObservableChoice<2> choice{.window = Box<2>{Vec2(0, 0), Vec2(5, 2)}};
  EXPECT_NEAR(observe(scene, state, choice).solid_fraction, 2 * std::numbers::pi / 10, 1e-13);
  choice.window = {Vec2(4, 0), Vec2(5, 2)};  // half of the disk at x = 4
  EXPECT_NEAR(observe(scene, state, choice).solid_fraction, 0.5 * std::numbers::pi / 2, 1e-13);
}

TEST(Observables, StressRatioOfSimpleShearIsShearOverPressure) {
  Mat<3> stress = 4 * Mat<3>::Identity();
  stress(0, 2) = stress(2, 0) = 1.2;
  EXPECT_NEAR(stress_ratio<3>(stress), 0.3, 1e-15);
  Mat2 plane = 4 * Mat2::Identity();
  plane(0, 1) = plane(1, 0) = 1.2;
  EXPECT_NEAR(stress_ratio<2>(plane), 0.3, 1e-15);
}

TEST(Observables, WithoutFrictionASphereNeedsThreeContactsUnderGravityAndFourWithout) {
  Scene<3> scene = one_law<3>({});
  State<3> state{.bodies = {round_body<3>(Vec3::Zero(), 1, 2)}};
  state.walls.resize(4, half_space<3>(Vec3::Zero(), Vec3::UnitZ()));
  for (int contacts = 1; contacts <= 4; ++contacts) {
    state.contacts.push_back({.contact = {.i = 0, .j = contacts}, .s_n = 1});
    scene.gravity = Vec3(0, 0, -1);
    EXPECT_EQ(find_rattlers<3>(scene, state)[0], contacts < 3);
    scene.gravity.setZero();
    EXPECT_EQ(find_rattlers<3>(scene, state)[0], contacts < 4);
    scene.laws[0].mu = 0.1;
    EXPECT_EQ(find_rattlers<3>(scene, state)[0], contacts < 2);
    scene.laws[0].mu = 0;
  }
}

TEST(Observables, ARunOfSpheresWritesThem) {
  const char* text = R"(
cell = {width = 1, depth = 1}
spheres = [{arrangement = "cubic", columns = 2, rows = 2, layers = 2, radius = 0.2, mass = 1}]
walls = [{point = [0, 0, 0], normal = [0, 0, 1]}]
time = {step = 1e-3, steps = 2}
[observables]
every = 1
force_bins = 5
window = [0, 0, 0, 1, 1, 0.8]
profile = "z"
profile_range = [0, 0.8]
profile_bins = 2
faces = [{name = "middle", point = [0, 0, 0.4], normal = [0, 0, 2]},
  {point = [0.5, 0.5, 0.2], normal = [0, 0, -1], radius = 0.5}]
)";
  const auto scene = scene_of<3>(text);
  const TemporaryFolder folder;
  RunWriter<3> writer(folder / "out", scene, text);
  State<3> state = initial_state(scene);
  for (state.step = 1; state.step <= 2; ++state.step) {
    state.time = 1e-3 * state.step;
    writer.step(state, {.step = state.step, .time = state.time});
    writer.frame(state);
  }
  writer.close();
  const NumberTable rows = read_number_table(folder / "out" / "observables.csv");
  ASSERT_EQ(rows.rows.size(), 2u);
  EXPECT_EQ(rows.rows[0][rows.column("spheres")], 8);
  // 8 spheres of 0.2 m in 1 m x 1 m, 0.8 m high.
  EXPECT_NEAR(rows.rows[0][rows.column("solid_fraction")],
              8 * 4 * std::numbers::pi / 3 * 0.008 / 0.8, 1e-9);
  EXPECT_DOUBLE_EQ(rows.rows[0][rows.column("mean_diameter")], 0.4);
  const Hdf5File frame(folder / "out" / "frames" / "00000002.h5", Hdf5File::Mode::kRead);
  EXPECT_NEAR(frame.read_double("/observables/density"), 1 / (4 * std::numbers::pi / 3 * 0.008),
              1e-9);
  EXPECT_EQ(frame.read_doubles("/observables/profile/vz").size(), 2u);
  EXPECT_EQ(frame.read_doubles("/observables/profile/stress_yz").size(), 2u);
  EXPECT_EQ(frame.read_double("/observables/flux/middle"), 0);
  const NumberTable profile = read_number_table(folder / "out" / "profile_mean.csv");
  ASSERT_EQ(profile.rows.size(), 2u);  // four spheres in each half
  EXPECT_NEAR(profile.rows[1][profile.column("solid_fraction")],
              4 * 4 * std::numbers::pi / 3 * 0.008 / 0.4, 1e-9);
}

}  // namespace
}  // namespace bipot
