#include "core/scene/disk_union.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace bipot {
namespace {

using Interval = std::pair<double, double>;
constexpr double kTurn = 2 * std::numbers::pi;

/// Adds the angles from `first` on, over less than a full turn, as intervals in [0, 2π].
void add_turned(double first, double width, std::vector<Interval>& covered) {
  if (first < 0) first += kTurn;
  const double last = first + width;
  covered.emplace_back(first, std::min(last, kTurn));
  if (last > kTurn) covered.emplace_back(0.0, last - kTurn);
}

/// Adds the angles at which circle k is covered by circle l, as intervals in [0, 2π]. False if
/// circle k is covered entirely.
bool add_covered(std::span<const Circle> circles, std::size_t k, std::size_t l,
                 std::vector<Interval>& covered) {
  const Circle &a = circles[k], &b = circles[l];
  const Vec2 way = b.centre - a.centre;
  const double d = way.norm();
  const bool same = d == 0 && a.radius == b.radius;
  if (same ? l < k : d + a.radius <= b.radius) return false;
  if (same || d >= a.radius + b.radius || d + b.radius <= a.radius) return true;
  const double cosine = (d * d + a.radius * a.radius - b.radius * b.radius) / (2 * d * a.radius);
  const double half = std::acos(std::clamp(cosine, -1.0, 1.0));
  const double first = std::atan2(way[1], way[0]) - half;
  add_turned(first, 2 * half, covered);
  return true;
}

/// Adds the angles at which a circle lies beyond a line, as intervals in [0, 2π]. The line lies at
/// `distance` from the centre, in the direction `angle`. False if the circle lies beyond it
/// entirely.
bool add_beyond(double distance, double radius, double angle, std::vector<Interval>& covered) {
  if (distance >= radius) return true;
  if (distance <= -radius) return false;
  const double half = std::acos(distance / radius);
  add_turned(angle - half, 2 * half, covered);
  return true;
}

/// ½ ∮ (x dy - y dx) along the segment from a to b where it lies in the union.
double side_part(std::span<const Circle> circles, const Vec2& a, const Vec2& b) {
  const double length = (b - a).norm();
  if (!(length > 0)) return 0;
  const Vec2 along = (b - a) / length;
  std::vector<Interval> inside;
  for (const Circle& c : circles) {
    const Vec2 from = a - c.centre;
    const double off = along[0] * from[1] - along[1] * from[0];
    if (std::abs(off) >= c.radius) continue;
    // The same value as in add_beyond(), to rounding: near the rim a root of differences deviates.
    const double half = c.radius * std::sin(std::acos(off / c.radius)), middle = -from.dot(along);
    const double first = std::max(0.0, middle - half), last = std::min(length, middle + half);
    if (first < last) inside.emplace_back(first, last);
  }
  std::sort(inside.begin(), inside.end());
  double covered = 0, reached = 0;
  for (const auto& [first, last] : inside) {
    covered += std::max(0.0, last - std::max(first, reached));
    reached = std::max(reached, last);
  }
  return 0.5 * (a[0] * along[1] - a[1] * along[0]) * covered;
}

/// The complement of the intervals in [0, 2π].
std::vector<Interval> gaps(std::vector<Interval> covered) {
  std::sort(covered.begin(), covered.end());
  std::vector<Interval> open;
  double reached = 0;
  for (const auto& [first, last] : covered) {
    if (first > reached) open.emplace_back(reached, first);
    reached = std::max(reached, last);
  }
  if (reached < kTurn) open.emplace_back(reached, kTurn);
  return open;
}

/// Integrals of the powers 1 to 4 of cosine and sine over an arc.
struct ArcIntegrals {
  double cosine[5], sine[5];
  explicit ArcIntegrals(const Interval& arc) {
    const double from = arc.first, to = arc.second;
    const auto change = [&](auto&& f) { return f(to) - f(from); };
    cosine[0] = sine[0] = to - from;
    const double s1 = change([](double t) { return std::sin(t); });
    const double c1 = change([](double t) { return std::cos(t); });
    const double s2 = change([](double t) { return std::sin(2 * t); });
    const double s4 = change([](double t) { return std::sin(4 * t); });
    const double s_cubed = change([](double t) { return std::pow(std::sin(t), 3); });
    const double c_cubed = change([](double t) { return std::pow(std::cos(t), 3); });
    cosine[1] = s1;
    sine[1] = -c1;
    cosine[2] = (to - from) / 2 + s2 / 4;
    sine[2] = (to - from) / 2 - s2 / 4;
    cosine[3] = s1 - s_cubed / 3;
    sine[3] = -c1 + c_cubed / 3;
    cosine[4] = 3 * (to - from) / 8 + s2 / 4 + s4 / 32;
    sine[4] = 3 * (to - from) / 8 - s2 / 4 + s4 / 32;
  }
};

/// ∫ (x + a c)^power a c over an arc, where c is cosine or sine with the given integrals of powers.
double along(const double* powers, double x, double a, int power) {
  double sum = 0, binomial = 1;
  for (int k = 0; k <= power; ++k) {
    sum += binomial * std::pow(x, power - k) * std::pow(a, k + 1) * powers[k + 1];
    binomial = binomial * (power - k) / (k + 1);
  }
  return sum;
}

}  // namespace

UnionMoments union_moments(std::span<const Circle> circles) {
  UnionMoments moments;
  if (circles.empty()) return moments;
  if (circles.size() == 1) {
    const double square = circles[0].radius * circles[0].radius;
    return {std::numbers::pi * square, circles[0].centre, std::numbers::pi / 2 * square * square};
  }
  Vec2 origin = Vec2::Zero();
  for (const Circle& c : circles) origin += c.centre / static_cast<double>(circles.size());
  Vec2 first = Vec2::Zero();
  double second = 0;
  for (std::size_t k = 0; k < circles.size(); ++k) {
    std::vector<Interval> covered;
    bool seen = true;
    for (std::size_t l = 0; l < circles.size() && seen; ++l) {
      if (l != k) seen = add_covered(circles, k, l, covered);
    }
    if (!seen) continue;
    const Vec2 c = circles[k].centre - origin;
    const double a = circles[k].radius;
    for (const Interval& arc : gaps(std::move(covered))) {
      const ArcIntegrals of(arc);
      // dA = d(x)∧d(y): ∫ dA = ½∮(x dy - y dx), ∫ x dA = ½∮ x² dy, ∫ y dA = -½∮ y² dx,
      // ∫ (x² + y²) dA = ⅓∮(x³ dy - y³ dx), with dy = a cos t dt, -dx = a sin t dt.
      moments.area += (along(of.cosine, c[0], a, 1) + along(of.sine, c[1], a, 1)) / 2;
      first += Vec2(along(of.cosine, c[0], a, 2), along(of.sine, c[1], a, 2)) / 2;
      second += (along(of.cosine, c[0], a, 3) + along(of.sine, c[1], a, 3)) / 3;
    }
  }
  const Vec2 centre = first / moments.area;
  moments.centre = origin + centre;
  moments.polar = second - moments.area * centre.squaredNorm();
  return moments;
}

double union_area_in(std::span<const Circle> circles, const Vec2& low, const Vec2& high) {
  if (circles.empty()) return 0;
  Vec2 from = circles[0].centre, to = from;
  for (const Circle& c : circles) {
    from = from.cwiseMin(c.centre - Vec2::Constant(c.radius));
    to = to.cwiseMax(c.centre + Vec2::Constant(c.radius));
  }
  const Vec2 origin = 0.5 * (from + to);
  from = from.cwiseMax(low);
  to = to.cwiseMin(high);
  if (!(from.array() < to.array()).all()) return 0;
  std::vector<Circle> moved(circles.begin(), circles.end());
  for (Circle& c : moved) c.centre -= origin;
  const Vec2 a = from - origin, b = to - origin;
  double area = 0;
  for (std::size_t k = 0; k < moved.size(); ++k) {
    const Circle& c = moved[k];
    std::vector<Interval> covered;
    constexpr double kQuarter = kTurn / 4;
    bool seen = add_beyond(b[0] - c.centre[0], c.radius, 0, covered) &&
                add_beyond(b[1] - c.centre[1], c.radius, kQuarter, covered) &&
                add_beyond(c.centre[0] - a[0], c.radius, 2 * kQuarter, covered) &&
                add_beyond(c.centre[1] - a[1], c.radius, 3 * kQuarter, covered);
    for (std::size_t l = 0; l < moved.size() && seen; ++l) {
      if (l != k) seen = add_covered(moved, k, l, covered);
    }
    if (!seen) continue;
    for (const Interval& arc : gaps(std::move(covered))) {
      const ArcIntegrals of(arc);
      area +=
          (along(of.cosine, c.centre[0], c.radius, 1) + along(of.sine, c.centre[1], c.radius, 1)) /
          2;
    }
  }
  const Vec2 c(b[0], a[1]), d(a[0], b[1]);
  area += side_part(moved, a, c) + side_part(moved, c, b) + side_part(moved, b, d) +
          side_part(moved, d, a);
  return std::max(0.0, area);
}

}  // namespace bipot
