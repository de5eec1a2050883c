#include "core/scene/triangle_mesh.h"

#include "core/motion/passage.h"
#include "core/scene/contact_detection.h"
#include "tests/support/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/small_scenes.h"

namespace bipot {
namespace {

using Triangle = Wall<3>::Mesh::Triangle;

Wall<3> mesh_of(std::vector<Triangle> triangles) {
  Wall<3> wall{.name = "mesh", .shape = Wall<3>::Shape::kMesh};
  wall.mesh = std::make_shared<const Wall<3>::Mesh>(std::move(triangles));
  return wall;
}

void add_quad(std::vector<Triangle>& to, const Vec3& a, const Vec3& b, const Vec3& c,
              const Vec3& d) {
  to.push_back({a, b, c});
  to.push_back({a, c, d});
}

/// Squares of the side 1 about the origin on z = 0, with diagonals of both directions.
Wall<3> tiled_floor(int half) {
  std::vector<Triangle> triangles;
  for (int x = -half; x < half; ++x) {
    for (int y = -half; y < half; ++y) {
      const Vec3 corners[] = {Vec3(x, y, 0), Vec3(x + 1, y, 0), Vec3(x + 1, y + 1, 0),
                              Vec3(x, y + 1, 0)};
      const int k = (x + y) % 2 == 0 ? 0 : 1;
      add_quad(triangles, corners[k], corners[k + 1], corners[(k + 2) % 4], corners[(k + 3) % 4]);
    }
  }
  return mesh_of(triangles);
}

/// A cone about z from radius r at 0 to R at the height 1, as inscribed triangles.
Wall<3> funnel_of_triangles(double r, double R, int sides) {
  std::vector<Triangle> triangles;
  const auto at = [&](double radius, int k, double z) {
    const double angle = 2 * std::numbers::pi * k / sides;
    return Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  for (int k = 0; k < sides; ++k) {
    add_quad(triangles, at(r, k, 0), at(r, k + 1, 0), at(R, k + 1, 1), at(R, k, 1));
  }
  return mesh_of(triangles);
}

Wall<3> cone(double r, double R) {
  return {.name = "cone",
          .shape = Wall<3>::Shape::kCone,
          .b = Vec3(0, 0, 1),
          .radius = r,
          .radius_b = R};
}

std::vector<Contact<3>> contacts_at(const Vec3& x, const Wall<3>& wall, double radius = 1,
                                    double eta = 1e-9) {
  const std::vector<Sphere> spheres = {round_body<3>(x, radius, 1)};
  return detect_contacts<3>(spheres, {&wall, 1}, eta);
}

// A ridge along y; both sides fall at 45°.
TEST(TriangleMesh, OverAConvexEdgeASphereTouchesTheEdgeOnce) {
  std::vector<Triangle> sides;
  for (const double side : {-3, 3}) {
    add_quad(sides, Vec3(0, -3, 0), Vec3(side, -3, -3), Vec3(side, 3, -3), Vec3(0, 3, 0));
  }
  const Wall<3> roof = mesh_of(sides);
  // The foot on the slope would be (x - z)/√2 < 0 from the ridge: the ridge is nearest, at √(x² + z²).
  for (const double x : {0.0, 0.2, -0.5}) {
    const auto found = contacts_at(Vec3(x, 0.1, 0.8), roof);
    ASSERT_EQ(found.size(), 1u) << x;
    const Vec3 from(x, 0, 0.8);
    EXPECT_LT((found[0].n - from.normalized()).norm(), 1e-14);
    EXPECT_NEAR(found[0].gap, from.norm() - 1, 1e-15);
  }
  // On the slope, the normal is (1, 0, 1)/√2 and the distance (x + z)/√2.
  const auto slope = contacts_at(Vec3(1.1, 0.3, 0.3), roof);
  ASSERT_EQ(slope.size(), 1u);
  EXPECT_NEAR(slope[0].n[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(slope[0].gap, 1.4 * std::sqrt(0.5) - 1, 1e-15);
}

TEST(TriangleMesh, AVertexOfManyTrianglesIsOneContact) {
  std::vector<Triangle> faces;
  for (int k = 0; k < 7; ++k) {
    const double a = 2 * std::numbers::pi * k / 7, b = 2 * std::numbers::pi * (k + 1) / 7;
    faces.push_back({Vec3::Zero(), 3 * Vec3(std::cos(a), std::sin(a), -1),
                     3 * Vec3(std::cos(b), std::sin(b), -1)});
  }
  const Vec3 x(0.1, -0.2, 0.9);
  const auto found = contacts_at(x, mesh_of(faces));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_LT((found[0].n - x.normalized()).norm(), 1e-14);
  EXPECT_NEAR(found[0].gap, x.norm() - 1, 1e-15);
}

// A groove of two planes at 45°: the centre at the height √2 is 1 from both. A corner of three faces.
TEST(TriangleMesh, InAConcaveCornerASphereTouchesEachFace) {
  std::vector<Triangle> groove;
  for (const double side : {-3, 3}) {
    add_quad(groove, Vec3(0, -3, 0), Vec3(side, -3, 3), Vec3(side, 3, 3), Vec3(0, 3, 0));
  }
  const auto two = contacts_at(Vec3(0, 0.2, std::sqrt(2)), mesh_of(groove));
  ASSERT_EQ(two.size(), 2u);
  for (const auto& c : two) {
    EXPECT_NEAR(std::abs(c.n[0]), std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(c.n[2], std::sqrt(0.5), 1e-15);
    EXPECT_NEAR(c.gap, 0, 1e-15);
  }
  std::vector<Triangle> corner;
  for (int k = 0; k < 3; ++k) {
    const Vec3 a = 3 * Vec3::Unit((k + 1) % 3), b = 3 * Vec3::Unit((k + 2) % 3);
    add_quad(corner, Vec3::Zero(), a, a + b, b);
  }
  EXPECT_EQ(contacts_at(Vec3(1, 1, 1), mesh_of(corner)).size(), 3u);
  EXPECT_EQ(contacts_at(Vec3(1, 2, 1), mesh_of(corner)).size(), 2u);
}

TEST(TriangleMesh, AFlatMeshIsAPlane) {
  const Wall<3> floor = tiled_floor(3);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 2000; ++k) {
    // A third of the centres lies over an edge, a third over a vertex, to rounding.
    Vec3 x(1.5 * unit(random), 1.5 * unit(random), 0.7 + 0.3 * unit(random));
    if (k % 3 > 0) x[0] = std::round(x[0]) + 1e-15 * unit(random);
    if (k % 3 > 1) x[1] = std::round(x[1]) + 1e-15 * unit(random);
    const auto found = contacts_at(x, floor);
    ASSERT_EQ(found.size(), 1u) << x.transpose();
    EXPECT_LT((found[0].n - Vec3::UnitZ()).norm(), 1e-14);
    EXPECT_NEAR(found[0].gap, x[2] - 1, 1e-15);
  }
}

TEST(TriangleMesh, ASphereSlidesOverTrianglesAsOverAPlane) {
  const auto end = [](const Wall<3>& floor) {
    Scene<3> scene = heavy_scene<3>({.mu = 0.2}, 2e-3);
    scene.walls = {floor};
    scene.bodies = {round_body<3>(Vec3(-2, -1.7, 0.25), 0.25, 2, Vec3(3, 2.1, 0), Vec3(0, 0, 4))};
    scene.contact_distance = 1e-9;
    scene.num_steps = 500;
    scene.solver.tol = 1e-13;
    return solved_run(scene);
  };
  const State<3> tiles = end(tiled_floor(3)), plane = end(flat_floor<3>());
  EXPECT_GT(plane.bodies[0].x[0], 0.1);  // over several triangles
  EXPECT_LT((tiles.bodies[0].x - plane.bodies[0].x).norm(), 1e-12);
  EXPECT_LT((tiles.bodies[0].v - plane.bodies[0].v).norm(), 1e-12);
  EXPECT_LT((tiles.bodies[0].spin - plane.bodies[0].spin).norm(), 1e-11);
}

// On the inside of ρ = 0.2 + z, a slope of 45°, the gap is (0.2 + z - ρ)/√2 - a.
TEST(TriangleMesh, AFunnelOfTrianglesIsTheCone) {
  const Wall<3> round = cone(0.2, 1.2);
  constexpr int kSides = 48;
  const Wall<3> faces = funnel_of_triangles(0.2, 1.2, kSides);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int k = 0; k < 200; ++k) {
    const double z = 0.3 + 0.4 * unit(random), away = 0.05 + z * unit(random);
    const double angle = 2 * std::numbers::pi * unit(random);
    const Vec3 x(away * std::cos(angle), away * std::sin(angle), z);
    const double distance = (0.2 + z - away) * std::sqrt(0.5);
    const auto found = contacts_at(x, round, 0.1, 1);
    ASSERT_LE(found.size(), 2u);  // a farther one behind the axis
    const Contact<3>& near = *std::ranges::min_element(found, {}, &Contact<3>::gap);
    EXPECT_NEAR(near.gap, distance - 0.1, 1e-14);
    EXPECT_NEAR(near.n[2], std::sqrt(0.5), 1e-13);
    // Inscribed: nearer by at most R (1 - cos π/N).
    double gap = kInfinity;
    for (const auto& c : contacts_at(x, faces, 0.1, 1)) gap = std::min(gap, c.gap);
    EXPECT_LE(gap, near.gap + 1e-14);
    EXPECT_GE(gap, near.gap - 1.2 * (1 - std::cos(std::numbers::pi / kSides)));
  }
}

TEST(TriangleMesh, RimsTipsAndAxesOfACone) {
  // The rim at z = 1 is nearest to a point above it.
  const Vec3 over(0, 1.4, 1.5);
  const auto rim = contacts_at(over, cone(0.2, 1.2));
  ASSERT_EQ(rim.size(), 1u);
  EXPECT_LT((rim[0].n - Vec3(0, 0.2, 0.5).normalized()).norm(), 1e-14);
  // The tip of a cone, from below on its axis.
  const auto tip = contacts_at(Vec3(0, 0, -0.9), cone(0, 1));
  ASSERT_EQ(tip.size(), 1u);
  EXPECT_LT((tip[0].n + Vec3::UnitZ()).norm(), 1e-14);
  // Within, on the axis: four points, 45 degrees below the centre at its radius 0.7 there. The
  // distance to the generators is 0.7 / sqrt(2).
  const auto round = contacts_at(Vec3(0, 0, 0.5), cone(0.2, 1.2));
  ASSERT_EQ(round.size(), 4u);
  Vec3 sum = Vec3::Zero();
  for (const Contact<3>& c : round) {
    EXPECT_NEAR(c.gap, 0.7 / std::sqrt(2.0) - 1, 1e-14);
    EXPECT_NEAR(c.n[2], std::sqrt(0.5), 1e-14);
    sum += c.n;
  }
  EXPECT_LT((sum - 4 * std::sqrt(0.5) * Vec3::UnitZ()).norm(), 1e-14);
  // Beside the axis: the two half-planes through the centre.
  EXPECT_EQ(contacts_at(Vec3(0.02, 0.01, 0.45), cone(0.2, 1.2)).size(), 2u);
  EXPECT_TRUE(contacts_at(Vec3(0, 0, 0.5), cone(2, 2)).empty());
}

/// A sphere plugs a cone whose radius grows by a half: its centre rests where generators are one
/// radius away, (0.1 + z/2) / sqrt(1 + 1/4) = 0.3.
TEST(TriangleMesh, ASphereThatPlugsAConeStays) {
  const double height = 2 * (0.3 * std::sqrt(1.25) - 0.1);
  for (const double mu : {0.0, 0.3}) {
    for (const double aside : {0.0, 1e-4}) {
      Scene<3> scene = heavy_scene<3>({.mu = mu});
      scene.walls = {cone(0.1, 0.6)};
      scene.bodies = {round_body<3>(Vec3(aside, 0.5 * aside, height + aside), 0.3, 2)};
      scene.step = 1e-3;
      scene.num_steps = 1000;
      const State<3> end = solved_run(scene);
      // The first step may be free: it falls by g h².
      EXPECT_NEAR(end.bodies[0].x[2], height, 5 * aside + 2e-5) << mu << " " << aside;
      EXPECT_LT(end.bodies[0].v.norm(), 1e-3);
    }
  }
}

/// Within a tube, on its axis, detection looks ahead without a touch: any direction is a normal.
TEST(TriangleMesh, OnTheAxisOfATubeNothingIsRefusedBeforeATouch) {
  Wall<3> tube;
  tube.shape = Wall<3>::Shape::kHollowCircle;
  tube.normal = Vec3::UnitZ();
  tube.radius = 0.5;
  for (const Wall<3>& wall : {cone(0.5, 0.5), tube}) {
    const auto found = contacts_at(Vec3(0, 0, 0.4), wall, 0.45, 0.1);
    ASSERT_FALSE(found.empty());
    for (const Contact<3>& c : found) {
      EXPECT_NEAR(c.gap, 0.05, 1e-15);
      EXPECT_NEAR(c.n[2], 0, 1e-15);
    }
  }
}

TEST(TriangleMesh, KeptContactsAreThoseOfASearch) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Triangle> rough;
  for (int k = 0; k < 200; ++k) {
    const auto any = [&] { return Vec3(unit(random), unit(random), unit(random)); };
    const Vec3 at = 3 * any();
    rough.push_back({at + any(), at + any(), at + any()});
  }
  // The last one is plugged by some spheres, which it has several contacts with.
  std::vector<Wall<3>> walls = {mesh_of(rough), cone(0.5, 2), cone(0.1, 0.6)};
  std::vector<Sphere> spheres;
  for (int k = 0; k < 40; ++k) {
    spheres.push_back(round_body<3>(3 * Vec3(unit(random), unit(random), unit(random)), 0.4, 1));
  }
  for (int k = 1; k < 5; ++k) {
    spheres.push_back(round_body<3>(Vec3(-0.01 * k, 0.005, 0.68), 0.4, 1));
  }
  KeptContacts<3> kept;
  std::size_t several = 0;
  for (int step = 0; step < 20; ++step) {
    for (Sphere& s : spheres) s.x += 2e-3 * Vec3(unit(random), unit(random), unit(random));
    const auto a = detect_contacts<3>(spheres, walls, 1e-3), b = kept(spheres, walls, 1e-3);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t c = 0; c < a.size(); ++c) {
      EXPECT_EQ(a[c].i, b[c].i);
      EXPECT_EQ(a[c].j, b[c].j);
      EXPECT_EQ(bits_of_all(a[c].n, a[c].gap), bits_of_all(b[c].n, b[c].gap));
      several += c > 0 && a[c].i == a[c - 1].i && a[c].j == a[c - 1].j;
    }
  }
  EXPECT_GT(several, 100u);
  EXPECT_LT(kept.searches(), 20);
}

// Friction μ g speeds a sphere up to the belt's surface: after t = 0.1 s to μ g t, with a spin of
// 5/2 μ g t/a; the belt's rectangle stays.
TEST(TriangleMesh, ARectangleCanBeABeltAndAPress) {
  const std::string head = R"(
dim = 3
contact = {mu = 0.1}
spheres = [{position = [0.1, 0.2, 0.5], radius = 0.5, mass = 2}]
time = {step = 1e-3, steps = 100}
solver = {tol = 1e-12}
[[walls]]
corners = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
)";
  const State<3> moved = solved_run(scene_of<3>(head + "surface_velocity = [5, 0, 0]\n"));
  EXPECT_NEAR(moved.bodies[0].v[0], 0.1 * 9.81 * 0.1, 1e-9);
  EXPECT_NEAR(moved.bodies[0].spin[1], -2.5 * 0.1 * 9.81 * 0.1 / 0.5, 1e-8);
  EXPECT_EQ(moved.walls[0].a, Vec3(-1, -1, 0));
  // A lid pressed by 30 N: the floor bears it and the weight.
  const State<3> pressed =
      solved_run(scene_of<3>(
          head + "[[walls]]\ncorners = [[-1, -1, 1], [1, -1, 1], [0, 1, 1]]\nforce = 30\nmass = 1\n"
                 "direction = [0, 0, -1]\n"));
  ASSERT_EQ(pressed.contacts.size(), 2u);
  EXPECT_NEAR(pressed.contacts[0].s_n / 1e-3, 30 + 2 * 9.81, 1e-6);
  EXPECT_NEAR(pressed.contacts[1].s_n / 1e-3, 30, 1e-6);
}

/// A pentagram turns left at each corner, twice round: its fan of triangles is another surface.
TEST(TriangleMesh, APolygonThatWindsTwiceIsRefused) {
  const auto scene = [](int stride) {
    std::string corners;
    for (int k = 0; k < 5; ++k) {
      const double angle = 2 * std::numbers::pi * (stride * k % 5) / 5;
      corners += fmt::format("[{}, {}, 0], ", std::cos(angle), std::sin(angle));
    }
    return "dim = 3\nspheres = [{position = [0, 0, 1], radius = 0.5, mass = 2}]\n"
           "time = {step = 1e-3, steps = 1}\n[[walls]]\ncorners = [" +
           corners + "]\n";
  };
  EXPECT_NO_THROW(scene_of<3>(scene(1)));
  EXPECT_TRUE(says(refusal_of([&] { scene_of<3>(scene(2)); }), "round a convex polygon"));
}

TEST(TriangleMesh, WhatGoesThroughASurfaceIsSeen) {
  // 300 m/s for 1 ms, over x from -0.1 to 0.2: through a plate at x = 0.03, and through both sides of
  // a cone about z with the radius 0.05 there.
  Wall<3> plate = mesh_of({{Vec3(0.03, -1, -1), Vec3(0.03, 1, -1), Vec3(0.03, 0, 1)}});
  Wall<3> tube = cone(0.02, 0.08);
  tube.a[2] = -0.5;
  tube.b[2] = 0.5;
  for (const Wall<3>& wall : {plate, tube}) {
    for (const double height : {0.0, 1.2}) {
      Scene<3> scene = one_law<3>({});
      scene.step = 1e-3;
      scene.walls = {wall};
      scene.bodies = {round_body<3>(Vec3(-0.1, 0.001, height), 0.01, 1, Vec3(300, 0, 0))};
      const State<3> before = initial_state(scene);
      State<3> after = before;
      drift(after.bodies[0], scene.step);
      EXPECT_EQ(find_passages(before, after, scene.step).size(), height == 0 ? 1u : 0u);
    }
  }
}

}  // namespace
}  // namespace bipot
