#include "core/motion/sample_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace bipot {
namespace {

constexpr int kPrism = 64;  // sides that stand for a cylinder

/// Sorts the corners of a convex polygon with normal n around their mean.
void put_in_order(std::vector<Vec3>& corners, const Vec3& n) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& c : corners) mean += c / static_cast<double>(corners.size());
  const auto frame = contact_frame<3>(n);
  std::vector<std::pair<double, Vec3>> by_angle;
  for (const Vec3& c : corners) {
    by_angle.emplace_back(std::atan2(frame[2].dot(c - mean), frame[1].dot(c - mean)), c);
  }
  std::sort(by_angle.begin(), by_angle.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k] = by_angle[k].second;
}

/// Directions that cover the sphere evenly, and the triangles between them, outward.
struct Directions {
  std::vector<Vec3> normals;
  std::vector<std::array<int, 3>> triangles;
  double reach = 1;  // at which the triangles enclose the volume of the unit sphere
};

double enclosed_by(const std::vector<std::array<int, 3>>& triangles,
                   const std::vector<Vec3>& corners) {
  double sum = 0;
  for (const auto& [a, b, c] : triangles) {
    sum += corners[to_size(a)].dot(corners[to_size(b)].cross(corners[to_size(c)]));
  }
  return sum / 6;
}

/// An icosahedron whose triangles are cut in four three times: 642 directions.
Directions icosphere() {
  Directions d;
  const double golden = std::numbers::phi;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 n = Vec3::Zero();
        n[axis] = a;
        n[(axis + 1) % 3] = b;
        d.normals.push_back(n.normalized());
      }
    }
  }
  // Neighbours of the icosahedron are 2 apart where its corners have a norm of sqrt(1 + golden²).
  const double side = 2 / std::hypot(1, golden);
  const auto joined = [&](int a, int b) {
    return std::abs((d.normals[to_size(a)] - d.normals[to_size(b)]).norm() - side) < 0.1;
  };
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      for (int c = b + 1; c < 12; ++c) {
        if (!joined(a, b) || !joined(b, c) || !joined(c, a)) continue;
        const bool outward = enclosed_by({{a, b, c}}, d.normals) > 0;
        d.triangles.push_back(outward ? std::array{a, b, c} : std::array{a, c, b});
      }
    }
  }
  for (int level = 0; level < 3; ++level) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
      const auto [at, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<int>(d.normals.size()));
      if (is_new) {
        d.normals.push_back((d.normals[to_size(a)] + d.normals[to_size(b)]).normalized());
      }
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : d.triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    d.triangles = std::move(finer);
  }
  d.reach = std::cbrt(4 * std::numbers::pi / 3 / enclosed_by(d.triangles, d.normals));
  return d;
}

/// A sphere at mid-step, reduced to the data for its tangent planes.
struct Ball {
  Vec3 x;
  double radius;
};

/// Spheres that may extend farthest in some direction. Excluded are those within the hull of 26
/// others, which lie far out along 26 rays from the origin, the middle of all. The hull of their centres is not computed: it contains
/// the tetrahedra between the mean of the 26 and three that are neighbours by direction.
std::vector<Ball> outer_spheres(const std::vector<Ball>& all) {
  constexpr double kInside = 1 - 1e-3, kFlat = 1e-3;
  const auto at = [](const Vec3& ways) {
    const Eigen::Vector3i k = ways.cast<int>() + Eigen::Vector3i::Ones();
    return to_size(9 * k[0] + 3 * k[1] + k[2]);
  };
  std::array<Vec3, 27> corners;  // the middle one is the mean
  Vec3 mean = Vec3::Zero();
  double smallest = kInfinity;
  for (int k = 0; k < 27; ++k) {
    const Vec3 ways(k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1);
    if (k == 13) continue;
    const Ball* farthest = &all[0];
    double reach = -kInfinity;
    for (const Ball& s : all) {
      const Vec3& x = s.x;
      const double along = x.dot(ways) / ways.norm();
      const double here = along - 0.5 * std::sqrt(std::max(0.0, x.squaredNorm() - along * along));
      if (here > reach) {
        reach = here;
        farthest = &s;
      }
    }
    corners[at(ways)] = farthest->x;
    mean += corners[at(ways)] / 26;
    smallest = std::min(smallest, farthest->radius);
  }
  // Indexed by signs and by the order of the sizes of the coordinates, two digits of three.
  std::array<Eigen::Matrix3d, 72> barycentric;
  for (int signs = 0; signs < 8; ++signs) {
    const Vec3 corner(signs & 4 ? 1 : -1, signs & 2 ? 1 : -1, signs & 1 ? 1 : -1);
    for (int order = 0; order < 9; ++order) {
      const int first = order / 3, second = order % 3;
      Eigen::Matrix3d& inverse = barycentric[to_size(9 * signs + order)];
      inverse.setConstant(kNaN);
      if (first == second) continue;
      const Vec3 axis = corner[first] * Vec3::Unit(first);
      const Vec3 edge = axis + corner[second] * Vec3::Unit(second);
      Eigen::Matrix3d sides;
      sides << corners[at(axis)] - mean, corners[at(edge)] - mean, corners[at(corner)] - mean;
      const double size = sides.cwiseAbs().maxCoeff();
      if (std::abs(sides.determinant()) > kFlat * size * size * size) inverse = sides.inverse();
    }
  }
  // False for NaN too.
  const auto within = [&](const Vec3& x) {
    const Vec3 size = x.cwiseAbs();
    int first = 0, last = 0;
    size.maxCoeff(&first);
    size.minCoeff(&last);
    const int second = first == last ? (first + 1) % 3 : 3 - first - last;
    const int signs = (x[0] > 0 ? 4 : 0) + (x[1] > 0 ? 2 : 0) + (x[2] > 0 ? 1 : 0);
    const Vec3 part = barycentric[to_size(9 * signs + 3 * first + second)] * x;
    return part.minCoeff() >= 0 && part.sum() <= kInside;
  };
  std::vector<Ball> outer;
  for (const Ball& ball : all) {
    const Vec3 x = ball.x - mean;
    // For a larger sphere, an octahedron around the excess.
    const double more = std::sqrt(3.0) * (ball.radius - smallest);
    bool inner = within(x);
    for (int axis = 0; axis < 3 && inner && more > 0; ++axis) {
      inner = within(x + more * Vec3::Unit(axis)) && within(x - more * Vec3::Unit(axis));
    }
    if (!inner) outer.push_back(ball);
  }
  return outer;
}

/// Volume of a periodic cell, between the walls; where these leave it open, up to the spheres.
double cell_volume(const State<3>& state, double step, const Box<3>& spheres) {
  constexpr double kFar = 1e3;
  const PeriodicCell& cell = state.cell;
  Box<3> far = spheres;
  far.widen(kFar * spheres.size().maxCoeff());
  far.lower[0] = 0;
  far.upper[0] = cell.width.length;
  if (cell.in_y) {
    far.lower[1] = 0;
    far.upper[1] = cell.height.length;
  }
  ConvexBody body(far.lower, far.upper);
  for (const Wall<3>& w : state.walls) {
    if (!w.present) continue;
    const Vec3 point = w.a - 0.5 * step * w.v;
    if (w.shape == Wall<3>::Shape::kHalfPlane) body.clip(point, w.normal);
    if (w.shape == Wall<3>::Shape::kHollowCircle) clip_by_cylinder(body, point, w);
  }
  for (int axis = cell.in_y ? 2 : 1; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      const double edge = sign < 0 ? far.lower[axis] : far.upper[axis];
      double reach = -kInfinity;
      for (const auto& face : body.faces()) {
        for (const Vec3& corner : face) reach = std::max(reach, sign * corner[axis]);
      }
      if (reach < sign * edge - spheres.size().maxCoeff()) continue;  // a wall ends it
      const Vec3 end = (sign < 0 ? spheres.lower[axis] : spheres.upper[axis]) * Vec3::Unit(axis);
      body.clip(end, -sign * Vec3::Unit(axis));
    }
  }
  return body.volume();
}

/// Volume enclosed by the walls; NaN if they leave the sample open, or do not contain all spheres.
double enclosed_volume(const State<3>& state, double step, const Box<3>& spheres) {
  constexpr double kFar =
      1e3;  // an enclosure this many times as wide as the spheres counts as none
  const double width = spheres.size().maxCoeff();
  Box<3> far = spheres;
  far.widen(kFar * width);
  ConvexBody body(far.lower, far.upper);
  for (const Wall<3>& w : state.walls) {
    if (!w.present) continue;
    const Vec3 point = w.a - 0.5 * step * w.v;
    if (w.shape == Wall<3>::Shape::kHollowCircle) {
      for (const Sphere& s : state.bodies) {
        const Vec3 d = middle_of_step(s, step) - point;
        if (!(d.cross(w.normal).norm() < w.radius)) return kNaN;
      }
      clip_by_cylinder(body, point, w);
    }
    if (w.shape != Wall<3>::Shape::kHalfPlane) continue;
    for (const Sphere& s : state.bodies) {
      if ((middle_of_step(s, step) - point).dot(w.normal) < 0) return kNaN;
    }
    body.clip(point, w.normal);
  }
  for (const auto& face : body.faces()) {
    for (const Vec3& corner : face) {
      const Vec3 room = (corner - far.lower).cwiseMin(far.upper - corner);
      if (room.minCoeff() <= width) return kNaN;
    }
  }
  return body.faces().empty() ? kNaN : body.volume();
}

}  // namespace

ConvexBody::ConvexBody(const Vec3& lower, const Vec3& upper) {
  for (int axis = 0; axis < 3; ++axis) {
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (const Vec3& at : {lower, upper}) {
      std::vector<Vec3> face(4, at);
      face[0][b] = face[3][b] = lower[b];
      face[1][b] = face[2][b] = upper[b];
      face[0][c] = face[1][c] = lower[c];
      face[2][c] = face[3][c] = upper[c];
      faces_.push_back(std::move(face));
    }
  }
}

void ConvexBody::clip(const Vec3& point, const Vec3& normal) {
  std::vector<std::vector<Vec3>> kept;
  std::vector<Vec3> cut;  // corners in the plane
  bool removed = false;
  for (std::vector<Vec3>& face : faces_) {
    const bool in_front = std::all_of(face.begin(), face.end(),
                                      [&](const Vec3& p) { return (p - point).dot(normal) > 0; });
    if (in_front) {
      kept.push_back(std::move(face));
      continue;
    }
    std::vector<Vec3> rest;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const Vec3 &p = face[k], &q = face[(k + 1) % face.size()];
      const double at_p = (p - point).dot(normal), at_q = (q - point).dot(normal);
      if (at_p >= 0) rest.push_back(p);
      if (at_p == 0) cut.push_back(p);
      removed = removed || at_p < 0;
      if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) {
        rest.emplace_back(p + at_p / (at_p - at_q) * (q - p));
        cut.push_back(rest.back());
      }
    }
    if (rest.size() >= 3) kept.push_back(std::move(rest));
  }
  if (removed && cut.size() >= 3) {
    put_in_order(cut, normal);
    kept.push_back(std::move(cut));
  }
  faces_ = std::move(kept);
}

double ConvexBody::volume() const {
  if (faces_.empty()) return 0;
  Vec3 inside = Vec3::Zero();
  double corners = 0;
  for (const auto& face : faces_) {
    for (const Vec3& c : face) inside += c;
    corners += static_cast<double>(face.size());
  }
  inside /= corners;
  // Sum of pyramids from an inner point to the faces.
  double sum = 0;
  for (const auto& face : faces_) {
    Vec3 twice = Vec3::Zero();
    for (std::size_t k = 1; k + 1 < face.size(); ++k) {
      twice += (face[k] - face[0]).cross(face[k + 1] - face[0]);
    }
    sum += std::abs(twice.dot(face[0] - inside)) / 6;
  }
  return sum;
}

void clip_by_cylinder(ConvexBody& body, const Vec3& point, const Wall<3>& wall) {
  const auto frame = contact_frame<3>(wall.normal);
  // A polygon of n sides at a distance d has the area n d² tan(pi/n).
  const double turn = 2 * std::numbers::pi / kPrism;
  const double distance =
      wall.radius * std::sqrt(std::numbers::pi / (kPrism * std::tan(0.5 * turn)));
  for (int k = 0; k < kPrism; ++k) {
    const Vec3 out = std::cos(k * turn) * frame[1] + std::sin(k * turn) * frame[2];
    body.clip(point + distance * out, -out);
  }
}

double sample_measure(const State<3>& state, double step) {
  if (state.bodies.empty()) return 0;
  Box<3> box;
  for (const Sphere& s : state.bodies) box.include(middle_of_step(s, step), s.radius);
  if (state.cell.periodic()) return cell_volume(state, step, box);
  if (const double enclosed = enclosed_volume(state, step, box); std::isfinite(enclosed)) {
    return enclosed;
  }
  std::vector<Ball> all;
  all.reserve(state.bodies.size());
  const Vec3 middle = 0.5 * (box.lower + box.upper);
  for (const Sphere& s : state.bodies) {
    all.push_back({middle_of_step(s, step) - middle, s.radius});
  }
  constexpr std::size_t kFew = 100;  // for fewer, to look for outer ones costs more than it saves
  const std::vector<Ball> outer = all.size() < kFew ? all : outer_spheres(all);
  static const Directions directions = icosphere();
  std::vector<Vec3> touched;
  touched.reserve(directions.normals.size());
  for (const Vec3& out : directions.normals) {
    const Ball* farthest = outer.data();
    double reach = -kInfinity;
    for (const Ball& ball : outer) {
      if (const double here = ball.x.dot(out) + ball.radius; here > reach) {
        reach = here;
        farthest = &ball;
      }
    }
    touched.push_back(farthest->x + directions.reach * farthest->radius * out);
  }
  return enclosed_by(directions.triangles, touched);
}

}  // namespace bipot
