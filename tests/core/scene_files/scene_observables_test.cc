#include "tests/support/refused_scene.h"
#include "tests/support/scene_text.h"

namespace bipot {
namespace {

const std::string kTenSteps = "[time]\nstep = 1e-3\nsteps = 10\n";

TEST(SceneObservables, AreMeasuredWhereTheyAreAskedFor) {
  const auto refused = [](const std::string& text, std::initializer_list<std::string> parts) {
    expect_scene_refused(kTenSteps + "[observables]\n" + text, parts);
  };
  EXPECT_FALSE(scene_of(kTenSteps).observables.has_value());
  const std::string table = "[observables]\n";
  const Scene<2> least = scene_of(kTenSteps + table);
  ASSERT_TRUE(least.observables.has_value());
  EXPECT_EQ(least.observables->every, 10);
  EXPECT_FALSE(least.observables->window.has_value());
  EXPECT_FALSE(least.observables->profile.has_value());
  const Scene<2> s =
      scene_of(kTenSteps + table +
               "every = 3\nstarts = 4\nwindow = [1, 2, 3, 5]\nprofile = 'x'\n"
               "profile_bins = 7\nprofile_range = [-1, 1]\nforce_bins = 8\nforce_limit = 9\n"
               "[[observables.lines]]\nfrom = [0, 1]\nto = [2, 3]\n");
  EXPECT_EQ(s.observables->every, 3);
  EXPECT_EQ(s.observables->starts, 4);
  EXPECT_EQ(s.observables->window->upper, Vec2(3, 5));
  EXPECT_EQ(s.observables->profile->axis, 0);
  EXPECT_EQ(s.observables->profile->bins, 7);
  EXPECT_EQ(s.observables->profile->low, -1);
  EXPECT_EQ(s.observables->force_bins, 8);
  EXPECT_EQ(s.observables->force_limit, 9);
  ASSERT_EQ(s.observables->crossings.size(), 1u);
  EXPECT_EQ(s.observables->crossings[0].name, "line0");
  EXPECT_EQ(s.observables->crossings[0].b, Vec2(2, 3));

  refused("every = 0\n", {"test.toml:5", "'every'", "positive"});
  refused("window = [0, 0, 0, 1]\n", {"test.toml:5", "'window'", "right"});
  refused("profile = 'y'\n", {"'profile_range'", "two numbers"});
  refused("profile_bins = 3\n", {"'profile_bins'", "belongs to a profile"});
  refused("profile = 'z'\n", {"test.toml:5", "'profile'"});
  const std::string line = "[[observables.lines]]\nname = 'a'\nfrom = [0, 0]\nto = [1, 0]\n";
  refused(line + line, {"test.toml:10", "'name'", "must differ"});
  refused("[[observables.lines]]\nname = 'a,b'\n", {"letters"});
  refused("[[observables.lines]]\nfrom = [1, 1]\nto = [1, 1]\n", {"two different points"});
}

TEST(SceneObservables, InSpace) {
  const std::string start = "dim = 3\n[time]\nstep = 0.1\nsteps = 1\n";
  const std::string table = "[observables]\n", face = "[[observables.faces]]\n";
  const auto read = [&](const std::string& text) { return *scene_of<3>(start + text).observables; };
  const auto s =
      read(table + "window = [0, 1, 2, 3, 4, 5]\nprofile = 'z'\nprofile_range = [-1, 1]\n" + face +
           "point = [1, 2, 3]\nnormal = [0, -2, 0]\n" + face +
           "name = 'round'\npoint = [1, 2, 3]\nnormal = [3, 0, 4]\nradius = 2\n" + face +
           "point = [1, 2, 3]\nnormal = [0, 0, 1]\nsize = [4, 5]\n" + face +
           "point = [1, 2, 3]\nnormal = [0, 0, 1]\nsize = [4, 5]\nalong = [0, 2, 9]\n");
  EXPECT_EQ(s.window->lower, Vec3(0, 1, 2));
  EXPECT_EQ(s.window->upper, Vec3(3, 4, 5));
  EXPECT_EQ(s.profile->axis, 2);
  using FaceShape = FluxFace::Shape;
  ASSERT_EQ(s.crossings.size(), 4u);
  EXPECT_EQ(s.crossings[0].name, "face0");
  EXPECT_EQ(s.crossings[0].shape, FaceShape::kPlane);
  EXPECT_EQ(s.crossings[0].normal, Vec3(0, -1, 0));
  EXPECT_EQ(s.crossings[1].shape, FaceShape::kDisk);
  EXPECT_LT((s.crossings[1].normal - Vec3(0.6, 0, 0.8)).norm(), 1e-15);
  EXPECT_EQ(s.crossings[2].shape, FaceShape::kRectangle);
  EXPECT_EQ(s.crossings[2].along, Vec3(1, 0, 0));
  EXPECT_EQ(s.crossings[3].along, Vec3(0, 1, 0));
  EXPECT_EQ(s.crossings[3].size, Vec2(4, 5));

  const auto refused = [&](const std::string& text, std::initializer_list<std::string> parts) {
    expect_scene_refused(start + text, parts);
  };
  refused(table + "window = [0, 0, 1, 1]\n", {"test.toml:6", "'window'", "opposite corners"});
  refused(table + "window = [0, 0, 0, 1, 1, 0]\n", {"test.toml:6", "opposite corners"});
  refused(table + "profile = 'w'\n", {"test.toml:6", "'profile'"});
  refused(table + "[[observables.lines]]\n", {"'lines'", "in 3D, faces"});
  refused(table + face + "normal = [0, 0, 1]\n", {"'point'", "is missing"});
  refused(table + face + "point = [0, 0, 0]\nnormal = [0, 0, 0]\n", {"test.toml:8", "'normal'"});
  const std::string at = face + "point = [1, 1, 1]\n";
  refused(table + at + "normal = [0, 0, 1]\nradius = 1\nsize = [1, 1]\n",
          {"test.toml:10", "'size'", "a radius (a disk), or a size"});
  refused(table + at + "normal = [0, 0, 1]\nradius = 1\nalong = [1, 0, 0]\n",
          {"test.toml:10", "'along'", "belongs to a rectangle"});
  refused(table + at + "normal = [0, 0, 1]\nsize = [1, 1]\nalong = [0, 0, 3]\n",
          {"test.toml:10", "'along'", "along the normal"});
  refused(table + at + "normal = [0, 1, 1]\nsize = [1, 1]\n", {"'along'", "is missing"});
  refused(table + at + "normal = [0, 1, 1]\nsize = [1, -1]\n", {"test.toml:9", "'size'"});
  const std::string cell = "[cell]\nwidth = 3\n";
  refused(cell + table + "window = [-1, 0, 0, 2, 1, 1]\n",
          {"'window'", "x = -1 to 2", "(0 to 3 m)"});
  refused(cell + table + "profile = 'x'\nprofile_range = [0, 4]\n", {"'profile_range'", "cell"});
  refused(cell + table + at + "normal = [1, 0, 1]\n", {"'normal'", "along an axis"});
  refused(cell + table + at + "normal = [0, 0, 1]\nradius = 1.5\n", {"'point'", "x = -0.5 to 2.5"});
  read(cell + table + at + "normal = [1, 0, 0]\nradius = 1.5\n");  // reaches along y and z
  refused(table + at +
              "normal = [0, 0, 1]\n[[clusters]]\nposition = [0, 0, 0]\nmass = 1\n"
              "parts = [[0, 0, 0, 1], [1, 0, 0, 1]]\n",
          {"faces do not measure the flux of clusters"});
  EXPECT_THROW(scene_of("[observables]\n[[observables.faces]]\n" + kTenSteps), SceneFileError);
}

}  // namespace
}  // namespace bipot
