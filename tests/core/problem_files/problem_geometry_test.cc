#include "core/problem_files/problem_geometry.h"

#include <sys/resource.h>

#include <csignal>

#include "core/base/file_error.h"
#include "core/files/hdf5_file.h"
#include "core/motion/time_stepping.h"
#include "core/problem_files/fclib_file.h"
#include "core/scene/scene_family.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// A step of a small box with its problem in a file.
struct Written {
  Scene<2> scene = make_family_scene("square", 3);
  State<2> state = initial_state(scene);
  ContactProblem problem = step_problem(scene, state);
  TemporaryFolder folder;
  fs::path path = folder / "p.hdf5";

  Written() {
    state.step = 7;
    state.time = 0.07;
    for (int c = 0; c < problem.num_contacts(); ++c) {
      ContactOutcome<2> outcome{
          .contact = {c % 9, c % 12 == c % 9 ? 9 : c % 12, Vec2(0.6, 0.8), 1e-7}};
      state.contacts.push_back(outcome);
    }
    write_fclib(path, problem, {});
  }
};

TEST(ProblemGeometry, ComesBackBitForBit) {
  Written w;
  EXPECT_FALSE(read_geometry(w.path, w.problem.num_contacts()).has_value());
  write_geometry(w.path, w.scene, w.state);
  write_geometry(w.path, w.scene, w.state);  // in place of the one before
  const auto read = read_geometry(w.path, w.problem.num_contacts());
  ASSERT_TRUE(read.has_value());
  ASSERT_EQ(read->state.bodies.size(), 9u);
  EXPECT_EQ(read->state.bodies[4].x, w.state.bodies[4].x);
  EXPECT_EQ(read->state.bodies[4].radius, 0.5);
  ASSERT_EQ(read->state.walls.size(), 3u);
  EXPECT_EQ(read->state.walls[1].normal, w.state.walls[1].normal);
  EXPECT_EQ(read->state.walls[2].a, w.state.walls[2].a);
  ASSERT_EQ(read->state.contacts.size(), w.state.contacts.size());
  for (std::size_t c = 0; c < w.state.contacts.size(); ++c) {
    EXPECT_EQ(read->state.contacts[c].contact.i, w.state.contacts[c].contact.i);
    EXPECT_EQ(read->state.contacts[c].contact.j, w.state.contacts[c].contact.j);
    EXPECT_EQ(read->state.contacts[c].contact.n, w.state.contacts[c].contact.n);
  }
  EXPECT_EQ(read->state.step, 7);
  EXPECT_EQ(read->state.time, 0.07);
  EXPECT_EQ(read->scene.step, w.scene.step);
  EXPECT_TRUE(read->scene.has_friction());
  // The problem itself is as it was.
  EXPECT_EQ(Vector(read_fclib(w.path).problem.mu), w.problem.mu);
}

/// A file that may not grow is a full disk without one.
TEST(ProblemGeometry, AFullDiskLeavesTheProblemWhole) {
  Written w;
  const auto fill = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{fs::file_size(w.path), RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::exit(refusal_of<FileError>([&] { write_geometry(w.path, w.scene, w.state); }).empty() ? 0
                                                                                               : 4);
  };
  EXPECT_EXIT(fill(), testing::ExitedWithCode(4), "");
  EXPECT_EQ(read_fclib(w.path).problem.mu, w.problem.mu);
}

TEST(ProblemGeometry, CirclesNeedTheirRadiiButNotWhetherTheyArePresent) {
  Written w;
  w.state.walls[0].shape = Wall<2>::Shape::kHollowCircle;
  w.state.walls[0].radius = 2;
  write_geometry(w.path, w.scene, w.state);
  const auto without = [&](const char* entry) {
    Hdf5File file(w.path, Hdf5File::Mode::kAppend);
    file.remove(std::string("/bipot/geometry/walls/") + entry);
    file.close();
    return read_geometry(w.path, w.problem.num_contacts());
  };
  const auto read = without("present");
  EXPECT_EQ(read->state.walls[0].radius, 2);
  EXPECT_TRUE(read->state.walls[0].present);
  EXPECT_TRUE(says(refusal_of<FileError>([&] { without("radius"); }), "walls/radius: missing"));
}

TEST(ProblemGeometry, RefusesWhatDoesNotFitTheProblem) {
  Written w;
  write_geometry(w.path, w.scene, w.state);
  EXPECT_THROW(read_geometry(w.path, w.problem.num_contacts() + 1), FileError);
  {
    Hdf5File file(w.path, Hdf5File::Mode::kAppend);
    std::vector<int> i = file.read_ints("/bipot/geometry/contacts/i");
    i[0] = 99;
    file.write("/bipot/geometry/contacts/i", std::span<const int>(i));
    file.close();
  }
  EXPECT_THROW(read_geometry(w.path, w.problem.num_contacts()), FileError);
  std::ofstream(w.folder / "text.dat") << "no HDF5";
  EXPECT_FALSE(read_geometry(w.folder / "text.dat", 1).has_value());
}

}  // namespace
}  // namespace bipot
