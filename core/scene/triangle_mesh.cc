#include "core/scene/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace bipot {
namespace {

/// Points of a surface nearer to each other than this part of the radius are one.
constexpr double kSamePoint = 1e-5;
constexpr int kLeaf = 4;

}  // namespace

Vec3 nearest_point(const std::array<Vec3, 3>& triangle, const Vec3& x) {
  const auto& [a, b, c] = triangle;
  const Vec3 n = (b - a).cross(c - a);
  Vec3 best = x - n.dot(x - a) / n.squaredNorm() * n;
  double nearest = kInfinity;
  for (int k = 0; k < 3; ++k) {
    const Vec3 &from = triangle[to_size(k)], &to = triangle[to_size((k + 1) % 3)];
    const Vec3 along = to - from;
    if (!(n.cross(along).dot(x - from) < 0)) continue;
    const double t = std::clamp((x - from).dot(along) / along.squaredNorm(), 0.0, 1.0);
    const Vec3 point = t < 1 ? Vec3(from + t * along) : to;
    if (const double distance = (x - point).squaredNorm(); distance < nearest) {
      nearest = distance;
      best = point;
    }
  }
  return best;
}

Wall<3>::Mesh::Mesh(std::vector<Triangle> from) : triangles(std::move(from)) {
  order_.resize(triangles.size());
  std::iota(order_.begin(), order_.end(), 0);
  if (!triangles.empty()) build(0, static_cast<int>(triangles.size()));
}

void Wall<3>::Mesh::build(int first, int last) {
  const std::size_t at = nodes_.size();
  Node node;
  for (int k = first; k < last; ++k) {
    for (const Vec3& corner : triangles[to_size(order_[to_size(k)])]) node.box.include(corner);
  }
  node.first = first;
  if (last - first <= kLeaf) node.count = last - first;
  nodes_.push_back(node);
  if (node.count > 0) return;
  int axis = 0;
  node.box.size().maxCoeff(&axis);
  const auto place = [&](int k) {
    const Triangle& t = triangles[to_size(k)];
    return std::pair(t[0][axis] + t[1][axis] + t[2][axis], k);
  };
  const int middle = (first + last) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](int k, int l) { return place(k) < place(l); });
  build(first, middle);
  nodes_[at].other = static_cast<int>(nodes_.size());
  build(middle, last);
}

template <class Visit>
void Wall<3>::Mesh::near(const Vec3& x, double reach, const Visit& visit) const {
  int waiting[64], count = 0;  // halves of halves: never so deep
  if (!nodes_.empty()) waiting[count++] = 0;
  while (count > 0) {
    const int at = waiting[--count];
    const Node& node = nodes_[to_size(at)];
    if ((x - node.box.nearest(x)).squaredNorm() > reach * reach) continue;
    for (int k = node.first; k < node.first + node.count; ++k) visit(order_[to_size(k)]);
    if (node.count > 0) continue;
    waiting[count++] = node.other;
    waiting[count++] = at + 1;
  }
}

void Wall<3>::Mesh::find_contacts(const Sphere& sphere, const Vec3& x, int i, int j, double eta,
                                  std::vector<Contact<3>>& out) const {
  struct Nearest {
    double distance;
    int triangle;
    Vec3 point;
  };
  std::vector<Nearest> found;
  const double reach = sphere.radius + eta, same = kSamePoint * sphere.radius;
  near(x, reach, [&](int triangle) {
    const Vec3 point = nearest_point(triangles[to_size(triangle)], x);
    const double distance = (x - point).norm();
    if (distance <= reach) found.push_back({distance, triangle, point});
  });
  std::sort(found.begin(), found.end(), [](const Nearest& one, const Nearest& other) {
    return std::tie(one.distance, one.triangle) < std::tie(other.distance, other.triangle);
  });
  const std::size_t first = out.size();
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Nearest& here = found[k];
    const auto holds = [&](const Nearest& nearer) {
      return nearer.distance < here.distance &&
             (here.point - nearest_point(triangles[to_size(nearer.triangle)], here.point)).norm() <=
                 same;
    };
    const auto is_same = [&](const Vec3& other) { return (other - here.point).norm() <= same; };
    if (std::any_of(points.begin(), points.end(), is_same)) continue;
    if (std::any_of(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(k), holds)) continue;
    if (here.distance <= kNoDirection * sphere.radius) {
      throw std::invalid_argument(fmt::format(
          "the centre of sphere {} lies on a wall of triangles: their contact has no normal", i));
    }
    points.push_back(here.point);
    out.push_back({i, j, (x - here.point) / here.distance, here.distance - sphere.radius});
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
            [](const Contact<3>& one, const Contact<3>& other) {
              return std::lexicographical_compare(one.n.begin(), one.n.end(), other.n.begin(),
                                                  other.n.end());
            });
}

bool Wall<3>::Mesh::crossed(const Vec3& p, const Vec3& q) const {
  bool crosses = false;
  near(0.5 * (p + q), 0.5 * (q - p).norm(), [&](int triangle) {
    if (crosses) return;
    const auto& [k, l, m] = triangles[to_size(triangle)];
    const Vec3 n = (l - k).cross(m - k);
    const double before = n.dot(p - k), after = n.dot(q - k);
    if (before == 0 || before * after > 0) return;
    const Vec3 at = p + before / (before - after) * (q - p);
    crosses = n.dot((l - k).cross(at - k)) >= 0 && n.dot((m - l).cross(at - l)) >= 0 &&
              n.dot((k - m).cross(at - m)) >= 0;
  });
  return crosses;
}

}  // namespace bipot
