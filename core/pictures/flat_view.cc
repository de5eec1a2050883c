#include "core/pictures/flat_view.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/motion/periodic_state.h"
#include "core/scene/scene_box.h"
#include "core/scene/wall_pieces.h"

namespace bipot {
namespace {

/// The plane of the picture; `away` points from the eye into it.
struct View {
  Vec3 right, up, away;
  Vec2 operator()(const Vec3& x) const { return Vec2(right.dot(x), up.dot(x)); }
};

View view_of(const Vec3& gravity) {
  View view{.up = gravity.norm() > 0 ? Vec3(-gravity.normalized()) : Vec3(Vec3::UnitZ())};
  // The axis nearest to the horizontal; the first one of several.
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(view.up[k]) < std::abs(view.up[axis]) - 1e-9) axis = k;
  }
  const Vec3 side = Vec3::Unit(axis);
  view.right = (side - side.dot(view.up) * view.up).normalized();
  view.away = view.up.cross(view.right);
  return view;
}

/// Adds the lines in which a surface cuts the plane at this depth, or at its own middle.
void add_cut(const Wall<3>& w, const View& view, std::optional<double> at, FlatView& flat) {
  const std::vector<WallPiece> pieces = wall_pieces({&w, 1}, {});
  double low = kInfinity, high = -kInfinity;
  for (const WallPiece& piece : pieces) {
    for (const Vec3& corner : piece.corners) {
      low = std::min(low, view.away.dot(corner));
      high = std::max(high, view.away.dot(corner));
    }
  }
  const double depth = at.value_or(0.5 * (low + high));
  for (const WallPiece& piece : pieces) {
    std::vector<Vec2> ends;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 &a = piece.corners[k], &b = piece.corners[(k + 1) % 4];
      const double from = view.away.dot(a) - depth, to = view.away.dot(b) - depth;
      if ((from < 0) == (to < 0)) continue;
      ends.push_back(view(a + from / (from - to) * (b - a)));
    }
    if (ends.size() < 2 || ends[0] == ends[1]) continue;
    flat.state.walls.push_back(
        {.name = w.name, .shape = Wall<2>::Shape::kSegment, .a = ends[0], .b = ends[1]});
  }
}

/// Adds the walls that a plane picture can show. Half-spaces are shown if seen edge-on. A cylinder
/// is a circle if seen along its axis. A hollow one seen from the side is the two lines that bound
/// the content at distance `off` from its axis.
void add_wall(const Wall<3>& w, const View& view, double off, FlatView& flat) {
  Wall<2> wall{.name = w.name, .a = view(w.a)};
  const double away = std::abs(w.normal.dot(view.away));
  if (w.shape == Wall<3>::Shape::kHalfPlane) {
    if (away > 1e-9) return;
    wall.normal = view(w.normal).normalized();
    flat.state.walls.push_back(wall);
  } else if (away > 1 - 1e-9) {
    wall.shape = w.shape == Wall<3>::Shape::kHollowCircle ? Wall<2>::Shape::kHollowCircle
                                                          : Wall<2>::Shape::kSolidCircle;
    wall.radius = w.radius;
    flat.state.walls.push_back(wall);
  } else if (away < 1e-9 && w.shape == Wall<3>::Shape::kHollowCircle && std::abs(off) < w.radius) {
    const Vec2 axis = view(w.normal);
    const double half = std::sqrt(w.radius * w.radius - off * off);
    for (const double to : {-half, half}) {
      wall.normal = Vec2(-axis[1], axis[0]) * (to > 0 ? -1 : 1);
      wall.a = view(w.a) - std::abs(to) * wall.normal;
      flat.state.walls.push_back(wall);
    }
  }
}

/// The parts that both views share: everything but disks and contacts. `depth` is that of the cut;
/// the full view has none and shows walls by their outlines.
FlatView frame_of(const Scene<3>& scene, const State<3>& state, const View& view,
                  std::optional<double> depth) {
  FlatView flat;
  flat.scene.title = scene.title;
  flat.scene.source = scene.source;
  flat.scene.gravity = view(scene.gravity);
  flat.scene.step = scene.step;
  flat.scene.materials = scene.materials;
  flat.scene.laws = scene.laws;
  flat.state.step = state.step;
  flat.state.time = state.time;
  for (const Wall<3>& w : state.walls) {
    if (!w.present) continue;
    if (w.is_surface()) {
      add_cut(w, view, depth, flat);
    } else {
      add_wall(w, view, depth ? *depth - view.away.dot(w.a) : 0, flat);
    }
  }
  flat.scene.walls = flat.state.walls;
  // The picture is periodic along x if it shows x to the right. Depth is not periodic.
  if (state.cell.periodic() && (view.right - Vec3::UnitX()).norm() < 1e-12) {
    flat.state.cell.in_x = true;
    flat.state.cell.width.length = state.cell.width.length;
  }
  return flat;
}

/// Contacts of the spheres that appear as disks.
void add_contacts(const State<3>& state, const View& view, FlatView& flat) {
  const int spheres = static_cast<int>(state.bodies.size());
  const int disks = static_cast<int>(flat.bodies.size());
  std::vector<int> disk_of(state.bodies.size(), -1);
  for (int k = 0; k < disks; ++k) disk_of[to_size(flat.bodies[to_size(k)])] = k;
  for (const ContactOutcome<3>& o : state.contacts) {
    const int i = disk_of[to_size(o.contact.i)];
    // All walls come after the disks: the picture only asks whether a body is a wall.
    const int j = o.contact.j < spheres ? disk_of[to_size(o.contact.j)] : disks;
    if (i < 0 || j < 0) continue;
    if (o.contact.image_x != 0 && !flat.state.cell.periodic()) continue;  // it has no place to end
    flat.state.contacts.push_back(
        {.contact = {i, j, view(o.contact.n), o.contact.gap, o.contact.image_x},
         .s_n = o.s_n,
         .s_t = o.s_t.norm(),
         .status = o.status});
  }
}

}  // namespace

FlatView project(const Scene<3>& scene, const State<3>& any, const std::vector<double>& front) {
  const State<3> state = wrapped_state(any);
  const View view = view_of(scene.gravity);
  FlatView flat = frame_of(scene, state, view, std::nullopt);
  flat.bodies.resize(state.bodies.size());
  std::iota(flat.bodies.begin(), flat.bodies.end(), 0);
  const auto place = [&](int k) {
    const double depth = view.away.dot(state.bodies[to_size(k)].x);
    return std::pair(front.empty() ? 0 : front[to_size(k)], -depth);
  };
  std::stable_sort(flat.bodies.begin(), flat.bodies.end(),
                   [&](int a, int b) { return place(a) < place(b); });
  for (const int k : flat.bodies) {
    const Sphere& s = state.bodies[to_size(k)];
    flat.state.bodies.push_back({.x = view(s.x), .radius = s.radius});
  }
  flat.scene.bodies = flat.state.bodies;
  add_contacts(state, view, flat);
  return flat;
}

FlatView slice(const Scene<3>& scene, const State<3>& any) {
  const State<3> state = wrapped_state(any);
  const View view = view_of(scene.gravity);
  double near = kInfinity, far = -kInfinity;
  for (const Sphere& s : state.bodies) {
    near = std::min(near, view.away.dot(s.x) - s.radius);
    far = std::max(far, view.away.dot(s.x) + s.radius);
  }
  const double middle = state.bodies.empty() ? 0 : 0.5 * (near + far);
  FlatView flat = frame_of(scene, state, view, middle);
  for (std::size_t k = 0; k < state.bodies.size(); ++k) {
    const Sphere& s = state.bodies[k];
    const double off = view.away.dot(s.x) - middle;
    if (!(std::abs(off) < s.radius)) continue;
    const double radius = std::sqrt(s.radius * s.radius - off * off);
    flat.state.bodies.push_back({.x = view(s.x), .radius = radius});
    flat.bodies.push_back(static_cast<int>(k));
  }
  flat.scene.bodies = flat.state.bodies;
  add_contacts(state, view, flat);
  return flat;
}

}  // namespace bipot
