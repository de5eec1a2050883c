#include "core/run_files/film.h"

#include "tests/support/scene_text.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(FilmFrame, LogarithmsAreWithinAThousandth) {
  // Half a step of 1/327 octave: 2^(0.5/327) - 1 = 1.06e-3.
  for (const double x : {1e-15, 3.3e-7, 0.02, 1.0, 9.81, 7.7e5, 1e15}) {
    EXPECT_NEAR(log_value(log_code(x)) / x, 1, 1.07e-3);
    EXPECT_NEAR(log_value(log_code(-x)) / -x, 1, 1.07e-3);
  }
  EXPECT_EQ(log_value(log_code(0)), 0);
  EXPECT_EQ(log_value(log_code(1e-16)), 0);  // below 2^-50 = 8.9e-16
  EXPECT_EQ(log_value(log_code(std::nan(""))), 0);
  EXPECT_NEAR(log_value(log_code(1e30)) / std::exp2(50), 1, 0.2);  // clipped
}

TEST(FilmFrame, AnglesAreWithinHalfAStep) {
  for (const double angle : {0.0, 1.0, 3.1, 6.2, -0.4, 123.4}) {
    const double apart =
        std::remainder(angle_value(angle_code(angle)) - angle, 2 * std::numbers::pi);
    EXPECT_LT(std::abs(apart), std::numbers::pi / 65536 * 1.001);
  }
}

TEST(FilmFrame, DirectionsAreWithinATenThousandth) {
  for (const Vec3& given : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-1, 2, -3),
                            Vec3(0.2, -0.9, 0.4), Vec3(-1, -1, -1e-3)}) {
    const Vec3 n = given.normalized();
    const auto [first, second] = direction_code(n);
    EXPECT_LT((direction_value(first, second) - n).norm(), 1e-4);
  }
}

Scene<2> two_disks() {
  return scene_of(floor_text(10) + R"(
disks = [{radius = 0.5, density = 1000, position = [0, 0.5]},
  {radius = 0.25, density = 1000, position = [3, 0.25]}]
)");
}

State<2> touching(const Scene<2>& scene) {
  State<2> state = initial_state(scene);
  state.step = 4;
  state.time = 0.04;
  state.bodies[1].v = Vec2(-2, 0.125);
  state.bodies[1].spin = -3;
  state.bodies[1].angle = 7;
  ContactOutcome<2> contact{.contact = {.i = 1, .j = 2, .n = Vec2(0, 1), .gap = -1e-4}};
  contact.s_n = 0.02;  // 2 N for a step of 0.01 s
  contact.s_t = -0.005;
  contact.status = ContactStatus::kSlip;
  state.contacts = {contact};
  return state;
}

TEST(FilmFrame, KeepsAStateWithinItsBounds) {
  const Scene<2> scene = two_disks();
  const FilmGrid grid = film_grid(scene);
  EXPECT_DOUBLE_EQ(grid.quantum, 0.25 / 1024);
  const FilmFrame frame =
      frame_of_bytes(to_bytes(film_frame(touching(scene), grid, scene.step, false)));
  EXPECT_EQ(frame.step, 4);
  EXPECT_EQ(frame.time, 0.04);
  ASSERT_EQ(frame.x.size(), 4u);
  EXPECT_NEAR(grid.position(frame.x[2], 0), 3, grid.quantum / 2);
  EXPECT_NEAR(log_value(frame.v[2]), -2, 2 * 1.07e-3);
  EXPECT_NEAR(log_value(frame.spin[1]), -3, 3 * 1.07e-3);
  EXPECT_NEAR(angle_value(frame.turn[1]), 7 - 2 * std::numbers::pi, 5e-5);
  ASSERT_EQ(frame.i.size(), 1u);
  EXPECT_EQ(frame.j[0], FilmFrame::kWall);
  EXPECT_NEAR(log_value(frame.force_n[0]), 2, 2 * 1.07e-3);
  EXPECT_NEAR(log_value(frame.force_t[0]), -0.5, 0.5 * 1.07e-3);
  EXPECT_NEAR(log_value(frame.gap[0]), -1e-4, 1.07e-7);
  EXPECT_EQ(frame.status[0], 2);
  const std::string bytes = to_bytes(frame);
  EXPECT_THROW(frame_of_bytes(bytes.substr(0, bytes.size() - 1)), std::invalid_argument);
  EXPECT_THROW(frame_of_bytes(bytes + "x"), std::invalid_argument);
}

// Places a millimetre apart, 5e6 m from the origin of the scene.
TEST(FilmFrame, KeepsPlacesFarFromTheOrigin) {
  Scene<2> scene = two_disks();
  for (Disk& disk : scene.bodies) disk.x += Vec2(5e6, -5e6);
  State<2> state = initial_state(scene);
  state.bodies[1].x[0] += 1e-3;
  const FilmGrid grid = film_grid(scene);
  const FilmFrame frame = film_frame(state, grid, scene.step, false);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(grid.position(frame.x[k], k % 2), state.bodies[k / 2].x[k % 2], grid.quantum / 2);
  }
  EXPECT_EQ(grid.place(1e300, 0), FilmGrid::kLast);
}

// Grains of 1 µm over 10 m: the grid holds 80 m, by steps that are larger than 1/1024 radius.
TEST(FilmFrame, ItsGridHoldsTheWholeScene) {
  Scene<2> scene = two_disks();
  scene.bodies[0].radius = 1e-6;
  scene.bodies[1].x[0] = 10;
  const FilmGrid grid = film_grid(scene);
  EXPECT_NEAR(grid.quantum * FilmGrid::kLast, 80, 1e-6);
  EXPECT_NEAR(grid.position(grid.place(40, 0), 0), 40, grid.quantum / 2);
}

/// Records the steps from `first` to `last`.
void record(FilmRecorder<2>& film, State<2> state, int first, int last) {
  for (int k = first; k <= last; ++k) {
    state.step = k;
    film.step(state);
  }
}

// 6 rad/s from 0.03 s on: 0.12 rad after 0.05 s, in which a wall without spin has not turned.
TEST(Film, HasTheTurnsOfWalls) {
  const TemporaryFolder folder;
  Scene<2> scene = two_disks();
  scene.walls.push_back({.shape = Wall<2>::Shape::kSolidCircle,
                         .motion = Wall<2>::Motion::kMoving,
                         .radius = 1,
                         .spin = 6,
                         .starts = 0.03});
  State<2> state = touching(scene);
  state.step = 5;
  state.time = 0.05;
  FilmRecorder<2> film(folder.path(), scene);
  film.step(state);
  const std::vector<std::uint16_t> turns = read_film(folder.path()).frames.at(0).wall_turn;
  ASSERT_EQ(turns.size(), 2u);
  EXPECT_EQ(turns[0], 0);
  EXPECT_NEAR(angle_value(turns[1]), 0.12, 5e-5);
}

TEST(Film, ThinsSoThatAnyLengthHasFourToEightHundredFrames) {
  const TemporaryFolder folder;
  const Scene<2> scene = two_disks();
  State<2> state = touching(scene);
  FilmRecorder<2> film(folder.path(), scene);
  record(film, state, 0, 5001);
  state.step = 5001;
  film.finish(state);
  const Film found = read_film(folder.path());
  // 800 steps by 1, to 1600 by 2, to 3200 by 4, then by 8: 0, 8, ... 5000, and the last.
  ASSERT_EQ(found.frames.size(), 5000u / 8 + 2);
  EXPECT_EQ(found.frames[1].step, 8);
  EXPECT_EQ(found.frames[found.frames.size() - 2].step, 5000);
  EXPECT_EQ(found.frames.back().step, 5001);
}

TEST(Film, KeepsTheLastFrameWhereItIsTheOneThatThins) {
  const Scene<2> scene = two_disks();
  State<2> state = touching(scene);
  // The 800th frame, by 1 and by 2, is of an odd multiple: thinning drops it.
  for (const int last : {799, 1598}) {
    const TemporaryFolder folder;
    FilmRecorder<2> film(folder.path(), scene);
    record(film, state, 0, last);
    state.step = last;
    film.finish(state);
    EXPECT_EQ(read_film(folder.path()).steps.back(), last);
  }
}

TEST(Film, GoesOnAfterARestartWithoutLaterFrames) {
  const TemporaryFolder folder;
  const Scene<2> scene = two_disks();
  const State<2> state = touching(scene);
  {
    FilmRecorder<2> film(folder.path(), scene);
    record(film, state, 0, 1000);  // by 2
  }
  FilmRecorder<2> film(folder.path(), scene, 500);
  record(film, state, 501, 510);
  const Film found = read_film(folder.path());
  ASSERT_EQ(found.frames.size(), 256u);  // 0, 2, ... 510
  EXPECT_EQ(found.frames.back().step, 510);
}

// A start that moved overlapping bodies apart; the scene that goes on has them where they were.
TEST(Film, KeepsItsGridThroughARestart) {
  const TemporaryFolder folder;
  Scene<2> scene = two_disks();
  const State<2> state = touching(scene);
  {
    FilmRecorder<2> film(folder.path(), scene);
    record(film, state, 0, 10);
  }
  const FilmGrid grid = film_grid(scene);
  scene.bodies[1].x[0] -= 0.1;
  FilmRecorder<2> film(folder.path(), scene, 10);
  record(film, state, 11, 12);
  EXPECT_EQ(read_film(folder.path()).frames.size(), 13u);
  EXPECT_EQ(read_film(folder.path()).grid, grid);
}

TEST(Film, AFrameThatIsCutOffDoesNotCount) {
  const TemporaryFolder folder;
  const Scene<2> scene = two_disks();
  {
    FilmRecorder<2> film(folder.path(), scene);
    record(film, touching(scene), 0, 9);
  }
  const auto path = folder.path() / "film.bin";
  fs::resize_file(path, fs::file_size(path) - 3);
  EXPECT_EQ(read_film(folder.path()).frames.size(), 9u);
  const Film later = read_film(folder.path(), 6);  // the frames after step 6
  ASSERT_EQ(later.frames.size(), 2u);
  EXPECT_EQ(later.frames[0].step, 7);
  EXPECT_EQ(later.steps, (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8}));
  fs::resize_file(path, 5);
  EXPECT_TRUE(read_film(folder.path()).frames.empty());
}

}  // namespace
}  // namespace bipot
