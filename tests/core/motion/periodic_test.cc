#include "core/base/portable_random.h"
#include "core/motion/periodic_state.h"
#include "core/motion/sample_area.h"
#include "core/scene/periodic_detection.h"
#include "tests/support/scene_run.h"

namespace bipot {
namespace {

PeriodicCell cell_of(double width, double height, double offset) {
  PeriodicCell cell{.in_x = true, .in_y = height > 0};
  cell.width.length = width;
  cell.height.length = height;
  cell.offset.length = offset;
  return cell;
}

Scene<2> periodic_scene(const PeriodicCell& cell, const ContactLaw& law) {
  Scene<2> scene = one_law<2>(law);
  scene.cell = cell;
  scene.step = 1e-3;
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-11;
  scene.contact_distance = 1e-6;
  return scene;
}

TEST(Periodic, ImagesAreThoseOfEveryPairAndEveryImage) {
  // Against every pair and every image in reach, with disks far outside of the cell as well.
  PortableRandom draw(5);
  for (const double offset : {0.0, 0.4, -2.3}) {
    const PeriodicCell cell = cell_of(1, 0.9, offset);
    std::vector<Disk> disks;
    for (int k = 0; k < 60; ++k) {
      const Vec2 x(draw.symmetric(), draw.symmetric());
      const CellNumber far{static_cast<int>(20 * draw.symmetric()),
                           static_cast<int>(20 * draw.symmetric())};
      disks.push_back(
          round_body<2>(x + cell.shift(far.kx, far.ky), 0.05 + 0.03 * draw.uniform(), 2));
    }
    std::set<std::tuple<int, int, int, int>> expected, found;
    for (int i = 0; i < 60; ++i) {
      for (int j = i + 1; j < 60; ++j) {
        const CellNumber a = cell_number(cell, disks[to_size(i)].x);
        const CellNumber b = cell_number(cell, disks[to_size(j)].x);
        for (int ky = -2; ky <= 2; ++ky) {
          for (int kx = -6; kx <= 6; ++kx) {
            const int image_x = a.kx - b.kx + kx, image_y = a.ky - b.ky + ky;
            const Vec2 d = disks[to_size(i)].x - disks[to_size(j)].x - cell.shift(image_x, image_y);
            if (d.norm() <= disks[to_size(i)].radius + disks[to_size(j)].radius + 0.01) {
              expected.insert({i, j, image_x, image_y});
            }
          }
        }
      }
    }
    for (const Contact<2>& c : detect_periodic_contacts(disks, {}, cell, 0.01)) {
      found.insert({c.i, c.j, c.image_x, c.image_y});
      const Vec2 d =
          disks[to_size(c.i)].x - disks[to_size(c.j)].x - cell.shift(c.image_x, c.image_y);
      EXPECT_NEAR(d.norm() - disks[to_size(c.i)].radius - disks[to_size(c.j)].radius, c.gap, 1e-13);
      EXPECT_NEAR((d.normalized() - c.n).norm(), 0, 1e-12);
    }
    EXPECT_GT(expected.size(), 60u);
    EXPECT_EQ(found, expected) << "offset " << offset;
  }
}

TEST(Periodic, ImagesAroundTheCellLieBesideItWhateverTheOffset) {
  // Every point within half a width and half a height of the cell lies in it or in one of the
  // images of it that image_shifts() names.
  PortableRandom draw(4);
  for (const double offset : {0.0, 0.7, -3.4, 12.1}) {
    const PeriodicCell cell = cell_of(1, 0.9, offset);
    const std::vector<Vec2> shifts = image_shifts(cell);
    EXPECT_EQ(shifts.size(), 9u);
    for (int trial = 0; trial < 100; ++trial) {
      const Vec2 x(draw.between(-0.5, 1.5), draw.between(-0.45, 1.35));
      const Vec2 home = x - wrapped(cell, x);
      EXPECT_TRUE(std::any_of(shifts.begin(), shifts.end(),
                              [&](const Vec2& shift) { return (shift - home).norm() < 1e-12; }))
          << "offset " << offset << ", x " << x.transpose();
    }
  }
}

TEST(Periodic, ATooSmallCellIsRefused) {
  const std::vector<Disk> disks = {round_body<2>(Vec2(0.1, 0.1), 0.1, 2)};
  EXPECT_THROW(detect_periodic_contacts(disks, {}, cell_of(0.4, 0, 0), 0), std::invalid_argument);
  EXPECT_NO_THROW(detect_periodic_contacts(disks, {}, cell_of(0.41, 0, 0), 0));
  // The image above lies 0.3 m up and 0.2 m aside: 0.36 m away.
  EXPECT_THROW(detect_periodic_contacts(disks, {}, cell_of(1, 0.3, 2.2), 0), std::invalid_argument);
}

TEST(Periodic, WallsAreSeenFromTheNearestImage) {
  const PeriodicCell cell = cell_of(2, 0, 0);
  Wall<2> step{.shape = Wall<2>::Shape::kSegment, .a = Vec2(1.9, 0)};
  step.b = Vec2(2.2, 0);  // across the edge
  const std::vector<Wall<2>> walls = {half_space<2>(Vec2(0, -1), Vec2(0, 1)), step};
  // 3 widths to the right of the segment's end at x = 0.2, touching it from above.
  const std::vector<Disk> disks = {round_body<2>(Vec2(6.15, 0.1), 0.1, 2),
                                   round_body<2>(Vec2(-9, -0.9), 0.1, 2)};
  const auto contacts = detect_periodic_contacts(disks, walls, cell, 1e-9);
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_EQ(contacts[0].j, 3);
  EXPECT_EQ(contacts[0].image_x, 2);  // the segment's own piece from 1.9 to 2.2, moved by 2 x 2 m
  EXPECT_NEAR(contacts[0].gap, 0, 1e-12);
  EXPECT_EQ(contacts[1].j, 2);
  EXPECT_EQ(contacts[1].n, Vec2(0, 1));
}

TEST(Periodic, AShockAcrossTheEdge) {
  // Two disks fly apart, through the edges of the cell, and meet on the other side: e = 1, so they
  // exchange velocities. They meet when 2 - 0.4 - 2 (0.1) - ... : gap 2 - 0.4 - 0.2 = 1.4 m closes
  // at 1 m/s; then each has gone 0.7 m.
  Scene<2> scene = periodic_scene(cell_of(2, 0, 0), {.e_n = 1});
  scene.contact_distance = 0;
  scene.bodies = {round_body<2>(Vec2(0.8, 0), 0.1, 2, Vec2(-0.5, 0)),
                  round_body<2>(Vec2(1.2, 0), 0.1, 2, Vec2(0.5, 0))};
  const State<2> end = solved_run(scene, 1500);
  EXPECT_NEAR(end.bodies[0].v[0], 0.5, 1e-12);
  EXPECT_NEAR(end.bodies[1].v[0], -0.5, 1e-12);
  EXPECT_NEAR(end.bodies[0].x[0], 0.8 - 0.7 + 0.05, 1e-3);
  EXPECT_NEAR(end.bodies[1].x[0], 1.2 + 0.7 - 0.05, 1e-3);
}

TEST(Periodic, ARingOfDisksSharesItsMomentum) {
  // 10 disks touch around the cell. No contact can open without another closing, so all normal
  // velocities vanish and everybody gets a tenth of the first one's velocity.
  Scene<2> scene = periodic_scene(cell_of(2, 0, 0), {});
  for (int k = 0; k < 10; ++k)
    scene.bodies.push_back(round_body<2>(Vec2(0.1 + 0.2 * k, 0.3), 0.1, 2));
  scene.bodies[3].v = Vec2(1, 0);
  scene.contact_distance = 1e-3;  // behind the first one a gap opens by half a step of its velocity
  const State<2> end = solved_run(scene, 1, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_EQ(r.contacts, 10);
    EXPECT_LT(r.momentum_imbalance.norm(), 1e-14);
  });
  for (const Disk& d : end.bodies) EXPECT_NEAR(d.v[0], 0.1, 1e-9);
  State<2> far = end;
  far.bodies[9].x[0] += 6;
  const State<2> inside = wrapped_state(far);
  for (const Disk& d : inside.bodies) EXPECT_TRUE(d.x[0] >= 0 && d.x[0] < 2);
}

/// 3 x 3 disks of radius 0.1 m: rows that touch, columns that touch and lean by `angle`; a cell of
/// 0.6 m x 0.6 sin(angle), offset by 0.6 cos(angle). Both pressures act.
Scene<2> leaning_lattice(double angle, double p_x, double p_y, const ContactLaw& law) {
  PeriodicCell cell = cell_of(0.6, 0.6 * std::sin(angle), 0.6 * std::cos(angle));
  for (const int k : {0, 1}) {
    cell.side(k).motion = CellSide::Motion::kDriven;
    cell.side(k).stress = k == 0 ? p_x : p_y;
    cell.side(k).mass = 3;
  }
  Scene<2> scene = periodic_scene(cell, law);
  for (int k = 0; k < 9; ++k) {
    const double row = k / 3;
    const Vec2 x(0.1 + 0.2 * (k % 3 + row * std::cos(angle)), 0.1 + 0.2 * row * std::sin(angle));
    scene.bodies.push_back(round_body<2>(x, 0.1, 2));
  }
  scene.num_steps = 5;
  return scene;
}

Mat2 stress_at_end(const Scene<2>& scene) {
  const State<2> end = solved_run(scene, [](const State<2>&, const StepReport<2>& r) {
    EXPECT_LT(std::abs(r.energy.imbalance), 1e-13);
  });
  EXPECT_LT(kinetic_energy(end), 1e-12);
  const double area = sample_measure(end, scene.step);
  return sample_stress(end, scene.step, area, contact_moments(end)).total();
}

TEST(Periodic, TheStressOfALeaningCellIsTheAppliedOne) {
  // Columns without friction carry force along themselves: with e = (cos, sin) their stress is
  // c e ⊗ e, c sin² = p_y. So at a fixed offset σ_xy = p_y cot 70°. The rows carry the rest of p_x.
  const double angle = std::numbers::pi * 70 / 180;
  Scene<2> scene = leaning_lattice(angle, 300, 200, {});
  const Mat2 fixed = stress_at_end(scene);
  EXPECT_NEAR(fixed(0, 0), 300, 1e-6);
  EXPECT_NEAR(fixed(1, 1), 200, 1e-6);
  EXPECT_NEAR(fixed(0, 1), 200 / std::tan(angle), 1e-6);
  // Friction carries a given shear stress, which pulls to the right: σ_xy = -30 Pa, as compression
  // counts positive. Both friction forces are 0.54 or less of their normal forces.
  scene = leaning_lattice(angle, 200, 200, {.mu = 0.9});
  scene.cell.offset.motion = CellSide::Motion::kDriven;
  scene.cell.offset.stress = 30;
  scene.cell.offset.mass = 3;
  const Mat2 given = stress_at_end(scene);
  EXPECT_NEAR(given(0, 0), 200, 1e-6);
  EXPECT_NEAR(given(1, 1), 200, 1e-6);
  EXPECT_NEAR(given(0, 1), -30, 1e-6);
  EXPECT_NEAR(given(1, 0), -30, 1e-6);
}

TEST(Periodic, ADrivenWidthKeepsTheLean) {
  // An empty cell: dL_xy/dt = 0 at offset_speed 0, so offset/width stays; the work is the kinetic
  // energy of both sides.
  Scene<2> scene = leaning_lattice(1, 300, 200, {});
  scene.bodies.resize(1);
  scene.bodies[0].radius = 0.01;
  const State<2> end = solved_run(scene, 20);
  const double lean = std::cos(1.0);
  EXPECT_LT(end.cell.width.length, 0.59);
  EXPECT_NEAR(end.cell.offset.length / end.cell.width.length, lean, 1e-14);
  EXPECT_NEAR(end.wall_work, kinetic_energy(end), 1e-12);
  EXPECT_EQ(end.cell.offset.speed, 0);
}

TEST(Periodic, WorkOnALeaningCellBalances) {
  // Impulses act at the middle of the step, where the images move by the mean of both velocities:
  // the ledger closes to rounding while the cell widens, is pressed together and sheared.
  Scene<2> scene = leaning_lattice(1.2, 300, 200, {.mu = 0.3});
  scene.cell.offset.motion = CellSide::Motion::kMoving;
  scene.cell.offset.speed = 0.4;
  scene.cell.width.speed = 0.3;
  scene.solver.tol = 1e-6;  // the ledger closes whatever the impulses are
  scene.contact_distance = 1e-3;
  EXPECT_GT(std::abs(closed_run(scene, 10, 1e-12, 1e-12).cell.width.length - 0.6), 1e-4);
}

TEST(Periodic, AnEmptyCellFollowsItsStress) {
  // Nothing resists: width speed = -p_x height t / mass; the work is its kinetic energy.
  PeriodicCell cell = cell_of(2, 0.5, 0);
  cell.width = {.motion = CellSide::Motion::kDriven, .length = 2, .stress = 30, .mass = 3};
  Scene<2> scene = periodic_scene(cell, {.mu = 0.3});
  scene.bodies = {round_body<2>(Vec2(0.3, 0.2), 0.1, 2)};
  const State<2> end = solved_run(scene, 10);
  EXPECT_NEAR(end.cell.width.speed, -30 * 0.5 * 0.01 / 3, 1e-14);
  EXPECT_NEAR(end.cell.width.length, 2 - 0.5 * 5 * 1e-4, 1e-12);
  EXPECT_NEAR(end.wall_work, 0.5 * 3 * 0.05 * 0.05, 1e-14);
}

TEST(Periodic, ThreeDisksUnderShearRollAsTheLawSays) {
  // Three disks above each other, jammed between their images by pressure_y, sheared with s = 0.01
  // m/s; friction holds all contacts. f is the impulse along x on the upper disk of a contact, at A
  // (0, 1), B (1, 2) and C (2, image of 0 above). With v + a w of the upper disk and v - a w of the
  // lower one, u = W f + (0, 0, s) must vanish; a = rim, 1/m + a²/I = 3/m a disk, and a disk
  // between two contacts couples them by (2 - 1)/m: W = (5 I + 1 1')/m, so
  // f = -m s/5 (e_C - 1/8 (1, 1, 1)) = m s/40 (1, 1, -7).
  const double shear = 0.01, mass = 2, rim = 0.1, pressure = 20;
  PeriodicCell cell = cell_of(0.5, 0.6, 0);
  cell.height = {.motion = CellSide::Motion::kDriven, .length = 0.6, .stress = pressure, .mass = 3};
  cell.offset = {.motion = CellSide::Motion::kMoving, .speed = shear};
  Scene<2> scene = periodic_scene(cell, {.mu = 0.9});
  for (int k = 0; k < 3; ++k)
    scene.bodies.push_back(round_body<2>(Vec2(0.2, 0.1 + 0.2 * k), rim, 2));
  const State<2> end = closed_run(scene, 1, 1e-15, 1e-15);
  // The contact across the cell has turned by 1/2 h s / 2a = 2.5e-5 rad: four digits are exact.
  EXPECT_NEAR(end.bodies[0].v[0] / shear, -0.2, 1e-4);
  EXPECT_NEAR(end.bodies[1].v[0] / shear, 0, 1e-4);
  EXPECT_NEAR(end.bodies[2].v[0] / shear, 0.2, 1e-4);
  EXPECT_NEAR(end.bodies[0].spin * rim / shear, -0.3, 1e-4);
  EXPECT_NEAR(end.bodies[1].spin * rim / shear, 0.1, 1e-4);
  EXPECT_NEAR(end.bodies[2].spin * rim / shear, -0.3, 1e-4);
  // Shear works with f_C against s: 7/40 m s², half of which the shock takes.
  EXPECT_NEAR(end.wall_work / (mass * shear * shear), 7.0 / 40, 1e-4);
  // Each contact carries pressure x width; the sums of f_x and f_y over branches of 2a.
  const double area = sample_measure(end, scene.step);
  const MeanStress<2> stress = sample_stress(end, scene.step, area, contact_moments(end));
  EXPECT_NEAR(stress.contact(1, 1) / pressure, 1, 1e-4);
  EXPECT_NEAR(stress.contact(0, 1), -5.0 / 40 * mass * shear / scene.step * 2 * rim / 0.3, 2e-3);
}

TEST(Periodic, MovingASceneByPeriodsChangesNothing) {
  // Random disks in a deforming cell; then the same with each disk moved by some lattice vector and
  // the velocity that its image has. Contacts, impulses and relative velocities stay.
  PeriodicCell cell = cell_of(1, 1, 0.2);
  cell.width = {.motion = CellSide::Motion::kMoving, .length = 1, .speed = 0.3};
  cell.offset = {.motion = CellSide::Motion::kMoving, .length = 0.2, .speed = 0.5};
  Scene<2> scene = periodic_scene(cell, {.mu = 0.5});
  PortableRandom draw(8);
  for (int k = 0; k < 16; ++k) {
    const Vec2 x(0.125 + 0.25 * (k % 4), 0.125 + 0.25 * (k / 4));
    scene.bodies.push_back(round_body<2>(x + 0.01 * Vec2(draw.symmetric(), draw.symmetric()), 0.12,
                                         2, Vec2(draw.symmetric(), draw.symmetric()),
                                         draw.symmetric()));
  }
  scene.contact_distance = 0.01;
  const State<2> one = solved_run(scene, 3);
  for (Disk& d : scene.bodies) {
    const int kx = static_cast<int>(5 * draw.symmetric()),
              ky = static_cast<int>(5 * draw.symmetric());
    d.x += cell.shift(kx, ky);
    d.v += cell.shift_velocity(kx, ky);
  }
  const State<2> other = solved_run(scene, 3);
  ASSERT_EQ(one.contacts.size(), other.contacts.size());
  EXPECT_GT(one.contacts.size(), 8u);
  const State<2> inside_one = wrapped_state(one), inside = wrapped_state(other);
  for (std::size_t c = 0; c < one.contacts.size(); ++c) {
    EXPECT_EQ(inside.contacts[c].contact.image_x, inside_one.contacts[c].contact.image_x);
    EXPECT_EQ(inside.contacts[c].contact.image_y, inside_one.contacts[c].contact.image_y);
    EXPECT_NEAR(other.contacts[c].contact.gap, one.contacts[c].contact.gap, 1e-13);
    EXPECT_NEAR(other.contacts[c].u_t, one.contacts[c].u_t, 1e-6);
    EXPECT_NEAR(other.contacts[c].u_n, one.contacts[c].u_n, 1e-6);
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    EXPECT_NEAR((inside.bodies[i].x - inside_one.bodies[i].x).norm(), 0, 1e-7);
    const Vec2 a = one.bodies[i].v - homogeneous_velocity(one.cell, one.bodies[i].x);
    const Vec2 b = other.bodies[i].v - homogeneous_velocity(other.cell, other.bodies[i].x);
    EXPECT_NEAR((a - b).norm(), 0, 1e-5);
  }
}

}  // namespace
}  // namespace bipot
