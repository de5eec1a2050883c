// What is said about keys that users type and scene files do not have.

#include "core/scene_files/scene_keys.h"

#include "tests/support/refused_scene.h"

namespace bipot {
namespace {

const std::string kFriction = "[contact]\nmu = 0.5\n";
const std::string kTwoSteps = "[time]\nstep = 1e-3\nsteps = 2\n";

/// Of a text before its two steps.
void expect_key_refused(const std::string& text, std::initializer_list<std::string> parts) {
  expect_scene_refused(text + kTwoSteps, parts);
}

void expect_nothing_proposed(const std::string& text) {
  const auto refused = caught<SceneFileError>([&] { parse_scene(text + kTwoSteps, "test.toml"); });
  EXPECT_FALSE(says(refused.value().what(), "did you mean")) << text;
}

TEST(SceneKeys, SynonymsLeadToTheKey) {
  expect_key_refused("[contact]\nfriction = 0.5\n", {"test.toml:2", "did you mean 'mu'"});
  expect_key_refused("[contact]\nmu_s = 0.5\n", {"did you mean 'mu'"});
  expect_key_refused("[contact]\nrestitution = 0.5\n", {"did you mean 'e_n'"});
  expect_key_refused("[contact]\nrolling_friction = 0.1\n", {"test.toml:2", "did you mean 'mu_r'"});
  expect_key_refused("[contact]\nspinning_friction = 0.1\n", {"'mu_spin'"});
  expect_key_refused("mu_r = 0.1\n", {"'mu_r' belongs to [contact]"});
  expect_key_refused("[contact]\ne = 0.5\n", {"did you mean 'e_n'"});
  expect_scene_refused("[time]\ndt = 1e-3\nsteps = 2\n", {"test.toml:2", "did you mean 'step'"});
  expect_key_refused("[[disks]]\ntype = 'random'\n", {"did you mean 'arrangement'"});
  expect_key_refused("[[disks]]\nn = 5\n", {"did you mean 'count'"});
  expect_key_refused("[[disks]]\nr = 5\n", {"did you mean 'radius'"});
  expect_key_refused("[[disks]]\nrho = 5\n", {"did you mean 'density'"});
  expect_key_refused("[[walls]]\nposition = [0, 0]\nnormal = [0, 1]\n", {"did you mean 'point'"});
  expect_key_refused("[[walls]]\ntype = 'plane'\nnormal = [0, 1]\n",
                     {"test.toml:2", "'from' and 'to' a segment"});
  expect_key_refused("[output]\ninterval = 5\n", {"did you mean 'every'"});
  expect_key_refused("[[walls]]\npos = [0, 0]\nnormal = [0, 1]\n", {"did you mean 'point'"});
}

TEST(SceneKeys, AWordMayMeanAnotherKeyOnlyInThisTable) {
  const std::string random = "[[disks]]\narrangement = 'random'\nmass = 1\ncount = 3\nwidth = 1\n";
  expect_key_refused(random + "radius = 0.1\n", {"test.toml:6", "did you mean 'radii'"});
  expect_key_refused("[[disks]]\nposition = [0, 0]\nradii = [0.1]\nmass = 1\n",
                     {"test.toml:3", "did you mean 'radius'"});
}

TEST(SceneKeys, UnknownKeysAreToldBeforeMissingOnes) {
  expect_key_refused("[[disks]]\nradius = 0.1\nmass = 1\nfixed = true\n",
                     {"test.toml:4", "unknown key 'fixed'"});
  expect_key_refused("[[disks]]\nfixed = true\n", {"unknown key 'fixed'", "wall = \"NAME\""});
  expect_key_refused("mu = 0.5\n[[disks]]\nradius = 1\n", {"test.toml:1", "[contact]"});
  expect_key_refused("friction = 0.5\n[[disks]]\nradius = 1\n",
                     {"test.toml:1", "'mu' belongs to [contact]"});
}

TEST(SceneKeys, KeysOfAnotherArrangementOrShapeOrSolverAreToldSo) {
  expect_key_refused("[[disks]]\nposition = [0, 0]\nradius = 1\nmass = 1\ncolumns = 3\n",
                     {"test.toml:5", "'columns' here; it does not go with this arrangement"});
  expect_key_refused("[[walls]]\npoint = [0, 0]\nnormal = [0, 1]\nhollow = true\n",
                     {"'hollow' here; it does not go with this arrangement, shape or motion"});
  expect_key_refused("[solver]\nname = 'pgs'\nomega = 1.2\n",
                     {"test.toml:3", "parameters = { omega = ... }"});
  expect_key_refused("[solver]\nname = 'pgs'\nseed = 3\n", {"parameters = { seed = ... }"});
  expect_key_refused("[solver]\nname = 'pgs'\ngravity = [0, 0]\n", {"belongs to the top level"});
  expect_key_refused("[start]\nmu = 0.3\n", {"'mu' belongs to [contact]"});
}

TEST(SceneKeys, WhatIsNotModelledIsSaid) {
  expect_key_refused("[[boxes]]\nsize = 1\n", {"'boxes'", "rigid clusters of disks"});
  expect_key_refused("[[disks]]\ndiameter = 1\n", {"radius"});
}

TEST(SceneKeys, NothingIsProposedWhereNothingIsNear) {
  expect_nothing_proposed("[contact]\nzzz = 0.5\n");
  expect_nothing_proposed("[contact]\nyoung = 0.5\n");
  expect_nothing_proposed("foo = 1\n");
}

TEST(SceneKeys, ValuesAndMissingKeysHaveTheirLine) {
  expect_key_refused("[contact]\nmu = -0.5\n", {"test.toml:2", "mu = -0.5"});
  expect_key_refused("[contact]\nmu = 0.5\ne_n = 1.5\n", {"test.toml:3", "e_n = 1.5"});
  expect_key_refused(kFriction + "[[disks]]\nradius = 0.1\nmass = 1\n",
                     {"test.toml:3", "[disks[0]]", "'position': is missing"});
}

TEST(SceneKeys, TablesThatTakeAnyKeyHaveNoList) {
  for (const char* table : {"", "contact", "time", "disks", "spheres", "walls", "solver"}) {
    EXPECT_FALSE(keys_of_table(table).empty()) << table;
  }
  EXPECT_TRUE(keys_of_table("solver.parameters").empty());  // takes any
  EXPECT_TRUE(is_synonym("friction", "mu"));
  EXPECT_FALSE(is_synonym("mu", "friction"));
}

}  // namespace
}  // namespace bipot
