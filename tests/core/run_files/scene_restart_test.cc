#include "core/base/file_error.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

struct NamedScene {
  const char *name, *text;
};

/// Scenes of 40 steps in which everything that a state carries is in use at step 17.
const NamedScene kRestartScenes[] = {
    {"plate, drum, dam and tilt", R"(
contact = {mu = 0.3}
tilt = {degrees_per_second = 200, starts = 0.005}
walls = [{center = [0, 0], radius = 0.7, hollow = true, spin = 2, starts = 0.012},
  {center = [0, -0.6], radius = 0.05, removed = 0.03},
  {point = [0, 0.12], normal = [0, -1], force = 20, mass = 2, velocity = [0.2, 0], stops = 0.025}]
disks = [{arrangement = "rectangular", columns = 3, rows = 3, radius = 0.1, mass = 1, corner = [-0.3, -0.5]}]
time = {step = 1e-3, steps = 40}
)"},
    {"rough plate, pressed and pulled, in a periodic scene", R"(
contact = {mu = 0.3}
cell = {width = 1}
walls = [{point = [0, 0], normal = [0, 1]},
  {name = "plate", point = [0, 0.55], normal = [0, -1], force = 20, mass = 2, velocity = [2, 0]}]
disks = [{arrangement = "rectangular", columns = 5, rows = 2, radius = 0.1, mass = 1},
  {arrangement = "rectangular", columns = 4, rows = 1, radius = 0.08, corner = [0.05, 0.37], wall = "plate"}]
time = {step = 1e-3, steps = 40}
)"},
    {"pins, a rope that tightens, and a bar on a drum", R"(
contact = {mu = 0.3}
walls = [{center = [0.7, -0.8], radius = 0.5, spin = 3}, {point = [0, -3], normal = [0, 1]}]
clusters = [{parts = [[0, 0, 0.1], [0.3, 0, 0.1], [0.6, 0, 0.1]], position = [0.2, -0.19], mass = 3}]
disks = [{position = [0, 0], radius = 0.1, mass = 1}, {position = [0, 0.4], radius = 0.1, mass = 1},
  {arrangement = "rectangular", columns = 3, rows = 2, radius = 0.1, mass = 1, corner = [2, -3]}]
pins = [{bodies = [0], point = [-0.2, 0]}, {bodies = [0, 8], point = [0.1, -0.1]}]
ropes = [{bodies = [0, 1], length = 0.41}]
time = {step = 2e-3, steps = 40}
)"},
    {"clusters that fall through a hole, on a box that tilts, and others that come in",
     R"(
contact = {mu = 0.3}
tilt = {degrees_per_second = 200}
disks = [{position = [0, 1.2], radius = 0.1, mass = 1, velocity = [0, -3]}]
walls = [{from = [-1, -0.15], to = [-0.2, -0.2]}, {from = [0.2, -0.2], to = [1, -0.15]}]
outlets = [{point = [0, -0.2], normal = [0, 1]}]
inlets = [{lower = [-0.5, 1.3], upper = [0.5, 1.6], rate = 100, radii = [0.1], mass = 0.5}]
time = {step = 2e-3, steps = 40}
)"
     "clusters = [{arrangement = 'rectangular', parts = [[0, 0, 0.1], [0.12, 0.05, 0.08]], columns = 3, "
     "rows = 3, degrees = 20, density = 10, corner = [-0.6, -0.1], velocity = [0.3, -4], spin = 5}]\n"},
    {"clusters in a periodic cell under shear and pressure",
     R"(
gravity = [0, 0]
contact = {mu = 0.4}
cell = {width = 1, height = 0.8, offset_speed = 3, pressure_y = 1000, mass = 1}
time = {step = 1e-3, steps = 40}
observables = {every = 1, window = [0, 0, 0.5, 0.5]}
)"
     "clusters = [{arrangement = 'random', parts = [[0, 0, 0.08], [0.1, 0, 0.07], [0.05, 0.08, 0.07]], "
     "count = 9, width = 1, spacing = 0, corner = [0.3, 0], density = 100, spin = 3}]\n"},
    {"periodic cell under shear and pressure",
     R"(
gravity = [0, 0]
contact = {mu = 0.4}
cell = {width = 1, height = 1.1, offset = 0.1, width_speed = -0.5, pressure_y = 100, mass = 2, shear_stress = 20}
time = {step = 1e-3, steps = 40}
)"
     "disks = [{arrangement = 'random', count = 30, radii = [0.08, 0.1], width = 1, spacing = 0, "
     "density = 100, velocity = [3, 1]}]\n"},
};

/// The same in space.
const NamedScene kRestartInSpace[] = {
    {"clumps in a shaken funnel over a tray of triangles, and spheres that come in",
     R"(
dim = 3
contact = {mu = 0.4}
walls = [{from = [0, 0, 0], to = [0, 0, 1], radii = [0.15, 1], velocity = [0.5, 0, 0], frequency = 20},
  {corners = [[-1, -1, -0.4], [1, -1, -0.4], [1, 1, -0.4], [-1, 1, -0.4]]}]
outlets = [{point = [0, 0, -0.35], normal = [0, 0, 1]}]
inlets = [{lower = [-0.5, -0.5, 1.3], upper = [0.5, 0.5, 1.6], rate = 100, radii = [0.1], mass = 0.5}]
time = {step = 2e-3, steps = 40}
)"
     "clusters = [{arrangement = 'random', count = 30, width = 0.6, corner = [-0.3, -0.3, 0.2], "
     "parts = [[0, 0, 0, 0.08], [0.1, 0, 0.02, 0.07], [0.05, 0.06, 0, 0.05]], "
     "density = 100, velocity = [0, 0, -6], spin = [1, -5, 3]}]\n"
     "start = {overlaps = 'allow'}\n"},
};

template <int D>
State<D> run_on(const Scene<D>& scene, State<D> state, int until, RunWriter<D>* writer) {
  // Books and bits do not depend on the tolerance.
  TimeStepper<D> stepper = stepper_of(scene, "pgs", {.tol = 1e-5});
  while (state.step < until) {
    const StepReport<D> report = stepper.advance(state);
    EXPECT_TRUE(report.converged) << report.message;
    EXPECT_LT(std::abs(report.energy.imbalance), 1e-11) << report.step;
    EXPECT_LT(report.momentum_imbalance.norm(), 1e-11) << report.step;
    if (writer != nullptr) writer->frame(state);
  }
  return state;
}

template <int D>
void expect_same_bits(const NamedScene& named) {
  SCOPED_TRACE(named.name);
  const TemporaryFolder folder;
  const auto scene = scene_of<D>(named.text);
  RunWriter<D> writer(folder / "out", scene, named.text);
  const State<D> end = run_on<D>(scene, initial_state(scene), 40, &writer);
  writer.close();
  for (const int step : {4, 17, 29}) {
    const State<D> read = read_state<D>(folder / "out", step);
    EXPECT_EQ(restart_mismatch(scene, read), "");
    EXPECT_EQ(bits_of_state(run_on<D>(scene, read, 40, nullptr)), bits_of_state(end));
    EXPECT_GT(end.contacts.size(), 3u);
  }
}

TEST(SceneRestart, GoesOnBitForBit) {
  for (const NamedScene& named : kRestartScenes) expect_same_bits<2>(named);
  for (const NamedScene& named : kRestartInSpace) expect_same_bits<3>(named);
}

/// Rows of other bins, along another axis or of another place are not continued: means would mix.
TEST(SceneRestart, OtherObservablesAreTold) {
  const std::string text = R"(
disks = [{position = [0, 0.1], radius = 0.1, mass = 1}]
walls = [{point = [0, 0], normal = [0, 1]}]
time = {step = 1e-3, steps = 4}
)";
  const auto scene = [&](const std::string& observables) {
    return scene_of<2>(text + "observables = {" + observables + "}\n");
  };
  const std::string along_y = "every = 1, profile = 'y', profile_range = [0, 1]";
  const TemporaryFolder folder;
  const auto resume = [&](const std::string& observables) {
    const Scene<2> other = scene(observables);
    RunWriter<2> writer(folder / "out", other, text, 0);
  };
  {
    const Scene<2> first = scene(along_y);
    RunWriter<2> writer(folder / "out", first, text);
    writer.frame(initial_state(first));
    writer.close();
  }
  EXPECT_NO_THROW(resume(along_y));
  EXPECT_NO_THROW(resume("every = 2, profile = 'y', profile_range = [0, 1]"));
  for (const char* other :
       {"every = 1, profile = 'x', profile_range = [0, 1]",
        "every = 1, profile = 'y', profile_range = [0, 2]",
        "every = 1, profile = 'y', profile_range = [0, 1], profile_bins = 6",
        "every = 1, profile = 'y', profile_range = [0, 1], window = [0, 0, 1, 1]",
        "every = 1, profile = 'y', profile_range = [0, 1], force_bins = 7"}) {
    EXPECT_TRUE(says(refusal_of<FileError>([&] { resume(other); }), "name another --out")) << other;
  }
  const std::string with_line = along_y + ", lines = [{name = 'low', from = [-1, 0], to = [1, 0]}]";
  EXPECT_NO_THROW(resume(with_line));
  // Nor after a part without any, whose refusal leaves the file as it was.
  {
    const Scene<2> none = scene_of<2>(text);
    RunWriter<2> writer(folder / "out", none, text, 0);
    writer.close();
  }
  const std::string before = file_text(folder / "out/run.h5");
  const std::string along_x = "every = 1, profile = 'x', profile_range = [0, 1]";
  EXPECT_TRUE(says(refusal_of<FileError>([&] { resume(along_x); }), "name another --out"));
  EXPECT_EQ(file_text(folder / "out/run.h5"), before);
  EXPECT_NO_THROW(resume(with_line));
}

/// A state keeps the places and velocities of its walls: those of an edited scene would be ignored.
TEST(SceneRestart, AWallThatWasEditedIsTold) {
  Scene<2> scene = one_law<2>({});
  scene.walls = {flat_floor<2>(), half_space<2>(Vec2(1, 0), Vec2(-1, 0))};
  move_at(scene.walls[1], Vec2(-0.1, 0));
  scene.bodies = {round_body<2>(Vec2(0, 0.1), 0.1, 1)};
  const State<2> state = initial_state(scene);
  EXPECT_EQ(restart_mismatch(scene, state), "");
  Scene<2> lower = scene, faster = scene;
  lower.walls[0].a[1] = -0.1;
  EXPECT_TRUE(says(restart_mismatch(lower, state), "wall 0: place is not that of"));
  faster.walls[1].v[0] = -0.2;
  EXPECT_TRUE(says(restart_mismatch(faster, state), "wall 1: velocity is not that of"));
}

}  // namespace
}  // namespace bipot
