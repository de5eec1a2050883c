#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Triangles of a wall, relative to its point a, in a tree of boxes.
///
/// A sphere touches a mesh where the distance from its centre has a local minimum. The nearest point
/// of a triangle is none if another triangle contains it and is nearer elsewhere: triangles are
/// convex. So an edge or vertex of several triangles is found once, and in a flat mesh never beside
/// the nearest point.
template <>
struct Wall<3>::Mesh {
  using Triangle = std::array<Vec3, 3>;

  /// Triangles must be finite and have an area.
  explicit Mesh(std::vector<Triangle> from);

  std::vector<Triangle> triangles;

  /// Contacts of a sphere with gaps of at most eta, sorted by their normals. `x`: its centre, from the
  /// point a of the wall. Throws std::invalid_argument for a centre on a triangle.
  void find_contacts(const Sphere& sphere, const Vec3& x, int i, int j, double eta,
                     std::vector<Contact<3>>& out) const;
  /// Whether the way from p to q crosses a triangle, or ends on one.
  bool crossed(const Vec3& p, const Vec3& q) const;

 private:
  struct Node {
    Box<3> box;
    int first = 0, count = 0;  // of a leaf: places in order_
    int other = 0;             // count = 0: the second child; the first one follows the node
  };
  void build(int first, int last);
  /// Calls visit(triangle) for those whose boxes are within `reach` of x.
  template <class Visit>
  void near(const Vec3& x, double reach, const Visit& visit) const;

  std::vector<Node> nodes_;
  std::vector<int> order_;
};

/// The point of the triangle that is nearest to x.
Vec3 nearest_point(const std::array<Vec3, 3>& triangle, const Vec3& x);

}  // namespace bipot
