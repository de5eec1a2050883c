#include "bench/measure/moving_problems.h"

#include <atomic>
#include <thread>

#include "bench/measure/iteration_growth.h"
#include "bench/measure/problem_target.h"
#include "bench/problems/moving_scene.h"
#include "core/criterion/contact_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// A cache folder of its own for the time of a test.
class OwnCache {
 public:
  OwnCache() { setenv("BIPOT_CACHE", folder_.path().c_str(), 1); }
  ~OwnCache() { unsetenv("BIPOT_CACHE"); }
  std::vector<fs::path> files() const {
    std::vector<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      if (entry.path().extension() == ".hdf5") paths.push_back(entry.path());
    }
    return paths;
  }

 private:
  TemporaryFolder folder_;
};

TEST(MovingScene, IsLooseHeavyAndAboveTheFloor) {
  for (const std::string& family : moving_family_names()) {
    const Scene<2> scene = make_moving_scene(family, 6, {});
    EXPECT_EQ(validate(scene), "") << family;
    EXPECT_GE(scene.bodies.size(), 36u) << family;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Disk& a = scene.bodies[i];
      EXPECT_GE(a.x.y(), a.radius) << family;
      for (std::size_t j = 0; j < i; ++j) {
        const Disk& b = scene.bodies[j];
        EXPECT_GE((a.x - b.x).norm(), (a.radius + b.radius) * (1 - 1e-12)) << family;
      }
    }
    const Disk& first = scene.bodies.front();
    EXPECT_NEAR(first.mass, 1000 * std::numbers::pi * first.radius * first.radius, 1e-9);
  }
  EXPECT_EQ(make_moving_scene("collapse", 6, {}).walls.size(), 1u);
  EXPECT_EQ(make_moving_scene("pour", 6, {}).walls.size(), 3u);
  // Gravity leans by 30 degrees unless an angle is given.
  EXPECT_NEAR(make_moving_scene("tilt", 6, {}).gravity.x(), 9.81 / 2, 1e-12);
  EXPECT_NEAR(make_moving_scene("tilt", 6, {.tilt_degrees = 45}).gravity.x(),
              9.81 / std::numbers::sqrt2, 1e-12);
  EXPECT_EQ(make_moving_scene("pour", 32, {}).num_steps, 600);
  EXPECT_EQ(make_moving_scene("pour", 8, {}).num_steps, 300);
  EXPECT_THROW(make_moving_scene("pours", 6, {}), std::invalid_argument);
}

TEST(MovingProblems, AreStepsOfOneRunWithTheirStart) {
  const OwnCache cache;
  const std::vector<int> steps = moving_steps("pour", 6, 3);
  ASSERT_EQ(steps.size(), 3u);  // of 260: 0.217, 0.55 and 0.883
  EXPECT_EQ(steps[0], 56);
  EXPECT_EQ(steps[2], 230);
  const MovingRunRequest request{"pour", 6, {}, steps};
  const std::vector<TestProblem> made = moving_problems(request);
  ASSERT_EQ(made.size(), 3u);
  EXPECT_EQ(cache.files().size(), 3u);
  for (const TestProblem& p : made) {
    EXPECT_EQ(validate(p.problem), "");
    EXPECT_GT(p.problem.num_contacts(), 0);
    EXPECT_EQ(p.start.size(), p.problem.num_rows());
    EXPECT_EQ(p.step, 0.005);
    EXPECT_EQ(p.smallest_radius, 0.4);
  }
  EXPECT_LT(made[0].problem.num_contacts(), made[2].problem.num_contacts());
  EXPECT_GT(made[2].problem.num_contacts(), 36);  // 36 disks that hold each other
  // A late step starts near its solution: better than from nothing.
  const ContactProblem& last = made[2].problem;
  EXPECT_LT(contact_error(last, made[2].start).guarded(),
            contact_error(last, Vector::Zero(last.num_rows())).guarded());
}

/// In space: side³ spheres without overlap, and problems with three rows a contact.
TEST(MovingProblems, AreOfSpheresToo) {
  const OwnCache cache;
  for (const std::string& family : moving_sphere_names()) {
    const Scene<3> scene = make_moving_spheres(family, 4, {});
    EXPECT_EQ(validate(scene), "") << family;
    EXPECT_EQ(scene.bodies.size(), 64u);
    EXPECT_EQ(bodies_in(family, 4), 64);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Sphere &a = scene.bodies[i], &b = scene.bodies[j];
        EXPECT_GE((a.x - b.x).norm(), (a.radius + b.radius) * (1 - 1e-12)) << family;
      }
    }
    const auto made = moving_problems({family, 4, {}, moving_steps(family, 4, 1)});
    ASSERT_EQ(made.size(), 1u);
    EXPECT_EQ(validate(made[0].problem), "");
    EXPECT_EQ(made[0].problem.dim, 3);
    EXPECT_GT(made[0].problem.num_contacts(), 20) << family;
  }
  EXPECT_EQ(bodies_in("pour", 4), 16);
  EXPECT_THROW(make_moving_spheres("pour", 4, {}), std::invalid_argument);
}

TEST(MovingProblems, TheCacheGivesTheSameBits) {
  const OwnCache cache;
  const MovingRunRequest request{"collapse", 5, {.mu = 0.4, .seed = 3}, {60, 90}};
  const std::vector<TestProblem> fresh = moving_problems(request);
  const std::vector<TestProblem> kept = moving_problems(request);
  ASSERT_EQ(fresh.size(), kept.size());
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    EXPECT_EQ(fresh[k].origin, kept[k].origin);
    EXPECT_EQ(Vector(fresh[k].problem.u_free), Vector(kept[k].problem.u_free));
    EXPECT_EQ(fresh[k].start, kept[k].start);
  }
  // Another seed, another run, other files.
  MovingRunRequest other = request;
  other.options.seed = 4;
  EXPECT_NE(moving_problems(other)[0].problem.u_free, fresh[0].problem.u_free);
  EXPECT_EQ(cache.files().size(), 4u);
}

TEST(MovingProblems, DoNotDependOnWhatOthersDoToTheCache) {
  const OwnCache cache;
  std::atomic<bool> done = false;
  std::thread other([&] {
    while (!done) {
      for (const fs::path& path : cache.files()) fs::remove(path);
    }
  });
  const auto made =
      moving_problems({.family = "pour", .side = 6, .options = {}, .steps = {150, 250}});
  done = true;
  other.join();
  ASSERT_EQ(made.size(), 2u);
  for (const TestProblem& problem : made) EXPECT_GT(problem.problem.num_contacts(), 0);
}

TEST(MovingProblems, AreTargetsAndFamilies) {
  const OwnCache cache;
  const auto sources = expand_targets({"pour:5", "tilt:5:angle=45:mu=0.5"}, {.scene_problems = 2});
  ASSERT_EQ(sources.size(), 4u);
  EXPECT_TRUE(sources[0].name.starts_with("pour:5@")) << sources[0].name;
  EXPECT_EQ(sources[0].series, "pour@1/2");
  EXPECT_EQ(sources[3].series, "tilt:angle=45:mu=0.5@2/2");
  EXPECT_EQ(sources[3].size, 5);
  EXPECT_EQ(cache.files().size(), 0u);  // nothing runs before a problem is asked for
  EXPECT_GT(sources[1].load().problem.num_contacts(), 0);
  EXPECT_EQ(cache.files().size(), 2u);
  for (const char* bad : {"pour:5:ratio=2", "pour:5:angle=3", "pour", "strike:0"}) {
    EXPECT_THROW(expand_targets({bad}), std::invalid_argument) << bad;
  }
  const GrowthScene::Problem growth = make_growth_problem({.family = "pour"}, 5);
  EXPECT_EQ(growth.bodies, 25u);
  EXPECT_GT(growth.problem.num_contacts(), 0);
}

}  // namespace
}  // namespace bipot
