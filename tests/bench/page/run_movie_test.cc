#include "bench/page/run_movie.h"

#include "bench/page/run_frames.h"
#include "core/base/file_error.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(RunMovie, AnotherEndingOrNoPlaceIsRefusedBeforeAnythingIsDrawn) {
  const TemporaryFolder folder;
  const Scene<2> scene = scene_of(
      "[[disks]]\nradius = 1\ndensity = 1\nposition = [0, 0]\n[time]\nstep = 0.1\nsteps = 1\n");
  State<2> state = initial_state(scene);
  run_scene(scene, state, {.folder = {.folder = folder.path()}});
  EXPECT_THROW(write_run_movie(folder.path(), "movie.avi"), std::invalid_argument);
  EXPECT_THROW(write_run_movie(folder.path(), folder / "none/movie.gif"), FileError);
}

TEST(RunFrames, AShownStateIsTheOneOfItsFile) {
  const TemporaryFolder folder;
  const Scene<2> scene = scene_of(floor_text(5) + R"(
disks = [{radius = 0.1, density = 1000, position = [0.05, 0.1], velocity = [1, 0]}]
)");
  State<2> state = initial_state(scene);
  run_scene(scene, state, {.folder = {.folder = folder.path()}});
  const RunFrames<2> run = read_frames<2>(folder.path(), scene.step);
  const State<2> shown = shown_state(run, run.film.frames.back(), scene.step);
  EXPECT_EQ(shown.step, 5);
  ASSERT_EQ(shown.bodies.size(), 1u);
  // Half a quantum, 0.1 / 1024 / 2; numbers to 0.11 %.
  EXPECT_LT((shown.bodies[0].x - state.bodies[0].x).cwiseAbs().maxCoeff(), 5e-5);
  EXPECT_NE(state.bodies[0].angle, 0);  // the floor turns it
  EXPECT_LT(
      std::abs(std::remainder(shown.bodies[0].angle - state.bodies[0].angle, 2 * std::numbers::pi)),
      1e-4);
  EXPECT_NEAR(shown.bodies[0].v[0], state.bodies[0].v[0], 1.1e-3 * state.bodies[0].v[0]);
  ASSERT_EQ(shown.contacts.size(), 1u);
  ASSERT_GT(state.contacts[0].s_n, 0);
  EXPECT_EQ(shown.contacts[0].contact.j, 1);
  EXPECT_NEAR(shown.contacts[0].s_n, state.contacts[0].s_n, 1.1e-3 * state.contacts[0].s_n);
  EXPECT_EQ(shown.contacts[0].status, state.contacts[0].status);
}

}  // namespace
}  // namespace bipot
