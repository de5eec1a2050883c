#include "core/scene/sphere_union.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/scene/disk_union.h"

namespace bipot {
namespace {

bool apart(std::span<const Sphere> spheres) {
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double reach = spheres[i].radius + spheres[j].radius;
      if ((spheres[i].x - spheres[j].x).norm() < reach * (1 - 1e-12)) return false;
    }
  }
  return true;
}

double volume_of(const Sphere& s) { return 4 * std::numbers::pi / 3 * std::pow(s.radius, 3); }

/// Nodes in [0, 1] and weights of Gauss's rule, by Newton's method for the zeros of Legendre's
/// polynomial.
std::vector<std::pair<double, double>> gauss_rule(int count) {
  std::vector<std::pair<double, double>> rule;
  for (int k = 0; k < count; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (count + 0.5)), slope = 1;
    for (int step = 0; step < 8; ++step) {
      double before = 1, value = x;
      for (int l = 2; l <= count; ++l) {
        before = std::exchange(value, ((2 * l - 1) * x * value - (l - 1) * before) / l);
      }
      slope = count * (x * value - before) / (x * x - 1);
      x -= value / slope;
    }
    rule.emplace_back(0.5 * (1 - x), 1 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

/// Heights along a unit vector where something begins or ends, increasing.
std::vector<double> breaks(std::span<const Sphere> spheres, const Vec3& axis) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere& a = spheres[i];
    for (const double side : {-1, 1}) heights.push_back(axis.dot(a.x) + side * a.radius);
    for (std::size_t j = 0; j < i; ++j) {
      const Sphere& b = spheres[j];
      const Vec3 way = b.x - a.x;
      const double d = way.norm();
      const double to = (d * d + a.radius * a.radius - b.radius * b.radius) / (2 * d);
      if (!(std::abs(to) < a.radius)) continue;  // apart or nested
      const Vec3 n = way / d;
      const double reach =
          std::sqrt((a.radius * a.radius - to * to) * std::max(0.0, 1 - std::pow(axis.dot(n), 2)));
      for (const double side : {-1, 1}) {
        heights.push_back(axis.dot(a.x + to * n) + side * reach);
      }
    }
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

/// Calls visit(height, weight, disks) for planes across an axis, from `first` to `last`.
template <class Visit>
void cut(std::span<const Sphere> spheres, const std::array<Vec3, 3>& frame, double first,
         double last, const Visit& visit) {
  static const std::vector<std::pair<double, double>> kRule = gauss_rule(16);
  std::vector<double> heights = breaks(spheres, frame[0]);
  for (double& height : heights) height = std::clamp(height, first, last);
  for (std::size_t k = 1; k < heights.size(); ++k) {
    const double length = heights[k] - heights[k - 1];
    if (!(length > 0)) continue;
    for (const auto& [node, weight] : kRule) {
      // Areas bend like roots at the ends: dense nodes there smooth them.
      const double height = heights[k - 1] + length * node * node * (3 - 2 * node);
      std::vector<Circle> circles;
      for (const Sphere& s : spheres) {
        const double off = height - frame[0].dot(s.x), square = s.radius * s.radius - off * off;
        if (!(square > 0)) continue;
        circles.push_back({Vec2(frame[1].dot(s.x), frame[2].dot(s.x)), std::sqrt(square)});
      }
      if (!circles.empty()) visit(height, weight * length * 6 * node * (1 - node), circles);
    }
  }
}

}  // namespace

Cluster<3> union_of_spheres(std::span<const Sphere> spheres) {
  Cluster<3> body;
  Vec3 middle = Vec3::Zero();
  for (const Sphere& s : spheres) middle += s.x / static_cast<double>(spheres.size());
  Mat<3> inertia = Mat<3>::Zero();
  const auto point = [](const Vec3& r) -> Mat<3> {
    return r.squaredNorm() * Mat<3>::Identity() - r * r.transpose();
  };
  if (apart(spheres)) {
    for (const Sphere& s : spheres) {
      body.size += volume_of(s);
      body.x += volume_of(s) * (s.x - middle);
    }
    body.x = middle + body.x / body.size;
    for (const Sphere& s : spheres) {
      inertia +=
          volume_of(s) * (0.4 * s.radius * s.radius * Mat<3>::Identity() + point(s.x - body.x));
    }
  } else {
    std::vector<Sphere> moved(spheres.begin(), spheres.end());
    for (Sphere& s : moved) s.x -= middle;
    const auto moment = [&](const Vec3& axis, Vec3& first, double& volume) {
      const auto frame = contact_frame<3>(axis);
      double about = 0;
      first.setZero();
      volume = 0;
      cut(moved, frame, -kInfinity, kInfinity,
          [&](double height, double weight, const auto& disks) {
            const UnionMoments m = union_moments(disks);
            volume += weight * m.area;
            first += weight * m.area *
                     (height * frame[0] + m.centre[0] * frame[1] + m.centre[1] * frame[2]);
            about += weight * (m.polar + m.area * m.centre.squaredNorm());
          });
      return about;
    };
    Vec3 first;
    for (int k = 0; k < 3; ++k) inertia(k, k) = moment(Vec3::Unit(k), first, body.size);
    for (int k = 0; k < 3; ++k) {
      const int l = (k + 1) % 3;
      double unused = 0;
      Vec3 again;
      const double slanted = moment((Vec3::Unit(k) + Vec3::Unit(l)).normalized(), again, unused);
      inertia(k, l) = inertia(l, k) = slanted - 0.5 * (inertia(k, k) + inertia(l, l));
    }
    first /= body.size;
    inertia -= body.size * point(first);
    body.x = middle + first;
  }
  body.mass = body.size;
  const Eigen::SelfAdjointEigenSolver<Mat<3>> principal(inertia);
  body.inertia = principal.eigenvalues();
  Mat<3> axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  body.axes = Eigen::Quaterniond(axes).normalized();
  return body;
}

double union_volume_in(std::span<const Sphere> spheres, const Vec3& low, const Vec3& high) {
  double volume = 0;
  cut(spheres, {Vec3::UnitZ(), Vec3::UnitX(), Vec3::UnitY()}, low[2], high[2],
      [&](double /*height*/, double weight, const auto& disks) {
        volume += weight * union_area_in(disks, low.head<2>(), high.head<2>());
      });
  return volume;
}

}  // namespace bipot
