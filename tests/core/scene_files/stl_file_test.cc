#include "core/scene_files/stl_file.h"

#include <cctype>

#include "core/scene/triangle_mesh.h"
#include "core/scene_files/scene_file.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

const std::string kText = R"(solid two faces
  facet normal 0 0 1
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 0 2.5e-1 0
    endloop
  endfacet
  facet normal 0 0 0
    outer loop
      vertex 0 0 0
      vertex 1 0 0
      vertex 2 0 0
    endloop
  endfacet
endsolid two faces
)";

/// The same two facets, the second one without an area.
std::string binary(float last = 0.25F) {
  std::string bytes(80, 's');
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(std::uint32_t{2});
  for (const float y : {last, 0.0F}) {
    const float numbers[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, y == 0 ? 2.0F : 0.0F, y, 0};
    put(numbers);
    put(std::uint16_t{0});
  }
  return bytes;
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

struct StlFile : testing::Test {
  const TemporaryFolder folder;
};

TEST_F(StlFile, BothFormsGiveTheSameTrianglesAndDropThoseWithoutArea) {
  for (const std::string& bytes : {kText, binary()}) {
    write(folder / "a.stl", bytes);
    const auto triangles = read_stl(folder / "a.stl");
    ASSERT_EQ(triangles.size(), 1u);
    EXPECT_EQ(triangles[0][0], Vec3(0, 0, 0));
    EXPECT_EQ(triangles[0][1], Vec3(1, 0, 0));
    EXPECT_EQ(triangles[0][2], Vec3(0, 0.25, 0));
  }
}

TEST_F(StlFile, ATextMayBreakItsLinesAnywhere) {
  const std::string facet =
      "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 2.5e-1 0 endloop endfacet";
  std::string large = kText;
  for (char& c : large) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  for (const std::string& text : {"solid one\n" + facet + "\nendsolid one\n", large,
                                  "\r\n  " + kText, "\xEF\xBB\xBF" + kText}) {
    write(folder / "a.stl", text);
    const auto triangles = read_stl(folder / "a.stl");
    ASSERT_EQ(triangles.size(), 1u) << text;
    EXPECT_EQ(triangles[0][2], Vec3(0, 0.25, 0)) << text;
  }
}

TEST_F(StlFile, ADamagedFileIsRefused) {
  const auto refused = [&](const std::string& bytes, const char* why) {
    write(folder / "a.stl", bytes);
    EXPECT_TRUE(says(refusal_of<SceneFileError>([&] { read_stl(folder / "a.stl"); }), why));
  };
  const auto without = [](std::string text, const std::string& part) {
    return text.erase(text.find(part), part.size());
  };
  refused(binary().substr(0, 150), "150 bytes, but 2 triangles need 184: damaged");
  refused(binary(std::numeric_limits<float>::quiet_NaN()), "triangle 0 is not finite");
  refused("nothing", "is no STL file");
  refused(without(kText, "endsolid two faces"), "ends before 'endsolid'");
  refused(without(kText, "      vertex 1 0 0\n"), "line 7: a facet needs three vertices");
  refused(without(kText, " 2.5e-1 0"), "line 6: expected three numbers");
  refused("solid a\n vertex 0 0 0 1\nendsolid\n", "line 2: no word of an STL file");
  refused("solid a\nfacets\nendsolid\n", "line 2: no word of an STL file");
  refused("solid a\nendsolid\n", "has no triangle with an area");
}

TEST_F(StlFile, AWallScalesAndMovesItsTriangles) {
  write(folder / "a.stl", kText);
  const auto scene = std::get<Scene<3>>(parse_any_scene(
      "dim = 3\nwalls = [{file = \"a.stl\", scale = 0.1, point = [1, 2, 3], velocity = [0, 0, 1]}]\n"
      "time = {step = 0.1, steps = 1}\n",
      (folder / "scene.toml").string()));
  const Wall<3>& wall = scene.walls[0];
  EXPECT_EQ(wall.shape, Wall<3>::Shape::kMesh);
  EXPECT_EQ(wall.a, Vec3(1, 2, 3));
  EXPECT_LT((wall.mesh->triangles[0][2] - Vec3(0, 0.025, 0)).norm(), 1e-16);
  const std::string two = refusal_of<SceneFileError>([&] {
    parse_any_scene("dim = 3\n[[walls]]\nname = 'a'\nfile = \"a.stl\"\nnormal = [0, 0, 1]\n",
                    (folder / "scene.toml").string());
  });
  EXPECT_TRUE(says(two, "scene.toml:4: [walls[0]] 'file': give one shape"));
}

}  // namespace
}  // namespace bipot
