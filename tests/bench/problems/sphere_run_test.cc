#include "bench/problems/scene_catalogue.h"
#include "core/files/hdf5_file.h"
#include "core/run_files/observable_output.h"
#include "core/run_files/run_reader.h"
#include "core/scene/scene_parts.h"
#include "core/scene_files/scene_file.h"
#include "solvers/simulation/run_folder.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/state_bits.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// Spheres that fall into a turning drum and onto each other, with a plate that comes down.
Scene<3> spheres_in_a_drum(int steps) {
  Scene<3> scene = one_law<3>({.mu = 0.4, .e_n = 0.1, .e_t = 0.1});
  scene.title = "drum";
  scene.gravity = Vec3(0, 0, -9.81);
  for (int k = 0; k < 12; ++k) {
    scene.bodies.push_back(
        round_body<3>(Vec3(0.3 * (k % 3 - 1), 0.3 * (k / 3 % 2), 0.35 * (k / 6) - 0.4),
                      k % 2 == 0 ? 0.14 : 0.12, 1, Vec3(0, 0, -1), Vec3(3, 1, k)));
  }
  const Wall<3> drum{.name = "drum",
                     .shape = Wall<3>::Shape::kHollowCircle,
                     .normal = Vec3::UnitY(),
                     .radius = 0.8,
                     .spin = 1};
  Wall<3> plate = half_space<3>(Vec3(0, 0, 0.3), -Vec3::UnitZ(), "plate");
  drive(plate, -Vec3::UnitZ(), 3, 20);
  scene.walls = {drum, half_space<3>(Vec3(0, -0.2, 0), Vec3::UnitY()),
                 half_space<3>(Vec3(0, 0.5, 0), -Vec3::UnitY()), plate};
  scene.step = 2e-3;
  scene.num_steps = steps;
  scene.contact_distance = 1e-7;
  scene.solver.name = "pgs";
  scene.solver.tol = 1e-6;
  scene.output.every = 50;
  scene.output.track = {3};
  scene.output.stress_picture = true;
  return scene;
}

// The ledger closes though the drum does work, and what comes back from the files goes on bit for
// bit.
TEST(SphereRun, GoesOnFromItsFilesBitForBit) {
  const TemporaryFolder folder;
  const Scene<3> scene = spheres_in_a_drum(200);
  State<3> whole = initial_state(scene);
  double imbalance = 0, momentum_imbalance = 0;
  SceneRunOptions<3> options;
  options.on_step = [&](const SceneStep<3>& step) {
    imbalance = std::max(imbalance, std::abs(step.report.energy.imbalance));
    momentum_imbalance = std::max(momentum_imbalance, step.report.momentum_imbalance.norm());
    return true;
  };
  const auto done = run_scene(scene, whole, options);
  EXPECT_EQ(done.totals.converged, 200);
  EXPECT_GT(done.totals.max_contacts, 12);
  EXPECT_LT(imbalance, 1e-11);
  EXPECT_LT(momentum_imbalance, 1e-11);
  EXPECT_GT(std::abs(whole.wall_work), 0.1);

  RunFolderOptions files{.folder = folder.path() / "run"};
  State<3> part = initial_state(scene);
  options.on_step = {};
  options.steps = 90;
  options.folder = files;
  run_scene(scene, part, options);
  options.folder = {};
  State<3> read = read_state<3>(files.folder);
  EXPECT_EQ(bits_of_state(read), bits_of_state(part));
  EXPECT_EQ(restart_mismatch(scene, read), "");
  options.steps = 110;
  run_scene(scene, read, options);
  EXPECT_EQ(bits_of_state(read), bits_of_state(whole));
  EXPECT_THROW(read_state(files.folder), FileError);  // as disks
}

TEST(SphereRun, WritesWhatParaViewAndPeopleLookAt) {
  const TemporaryFolder folder;
  const Scene<3> scene = spheres_in_a_drum(150);
  State<3> state = initial_state(scene);
  RunFolderOptions files{.folder = folder.path() / "run"};
  run_scene(scene, state, {.folder = files});
  for (const char* name : {"forces.svg", "forces.png", "slice.svg", "slice.png", "stress.svg",
                           "run.xdmf", "ledger.csv", "trajectory.csv"}) {
    EXPECT_TRUE(fs::exists(files.folder / name)) << name;
  }
  const Hdf5File frame(frame_path(files.folder, 150), Hdf5File::Mode::kRead);
  const std::size_t contacts = state.contacts.size();
  ASSERT_GT(contacts, 3u);
  EXPECT_EQ(frame.size("/bodies/x"), 3 * 12u);
  EXPECT_EQ(frame.size("/bodies/orientation"), 4 * 12u);
  EXPECT_EQ(frame.size("/contacts/force_t"), 3 * contacts);
  EXPECT_EQ(frame.size("/contacts/segment"), 6 * contacts);
  // Three planes, and the drum as a prism of 48 sides: four corners each.
  EXPECT_EQ(frame.size("/walls/piece"), (3 + 48) * 12u);
  // One end of a branch is the centre of its sphere.
  const auto ends = frame.read_doubles("/contacts/segment");
  const Sphere& first = state.bodies[to_size(state.contacts[0].contact.i)];
  EXPECT_EQ(ends[0], first.x[0]);
  EXPECT_EQ(ends[2], first.x[2]);
}

// A ball rolls down a ramp with nearly no inertia I: it has g sin(a) t / (1 + I/(m r²)) after a time
// t. A sample that no wall encloses is as large as the ball, and a row of the ledger is cheap: 1000
// rows cost less than a second even on a busy machine.
TEST(SphereRun, OneBallOnARampHasItsVolumeInEachRow) {
  const TemporaryFolder folder;
  Scene<3> scene = one_law<3>({.mu = 0.5});
  scene.title = "ramp";
  scene.gravity = 9.81 * Vec3(std::sin(0.1111), 0, -std::cos(0.1111));
  scene.bodies = {round_body<3>(Vec3(0, 0, 0.1), 0.1, 1)};
  scene.bodies[0].mass = 1;
  scene.bodies[0].inertia = 7e-7;
  scene.walls = {half_space<3>(Vec3::Zero(), Vec3::UnitZ())};
  scene.step = 1e-3;
  scene.num_steps = 1000;
  scene.output.picture = false;
  State<3> state = initial_state(scene);
  RunFolderOptions files{.folder = folder.path() / "run"};
  const auto run = run_scene(scene, state, {.folder = files});
  EXPECT_EQ(run.totals.converged, 1000);
  EXPECT_NEAR(state.bodies[0].v[0], 9.81 * std::sin(0.1111) / (1 + 7e-5), 1e-9);
  const NumberTable ledger = read_number_table(files.folder / "ledger.csv");
  ASSERT_EQ(ledger.rows.size(), 1000u);
  const double ball = 4e-3 * std::numbers::pi / 3;
  for (const auto& row : ledger.rows) ASSERT_NEAR(row[ledger.column("volume")], ball, 1e-8 * ball);
  EXPECT_LT(run.output_seconds, 1);
}

// The shipped pile: mu a little above what geometry asks for (Spheres.FourSpheresStand...).
TEST(SphereRun, TheShippedFourSpheresStand) {
  const auto scene = std::get<Scene<3>>(read_any_scene(find_scene("four_spheres")));
  State<3> state = initial_state(scene);
  EXPECT_EQ(run_scene(scene, state).totals.converged, scene.num_steps);
  EXPECT_LT((state.bodies[3].x - scene.bodies[3].x).norm(), 1e-7);
}

}  // namespace
}  // namespace bipot
