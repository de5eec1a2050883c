#include "core/scene/start_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/scene/contact_detection.h"
#include "core/scene/joints.h"
#include "core/scene/periodic_detection.h"
#include "core/scene/wall_motion.h"

namespace bipot {
namespace {

/// Deeper overlaps count, over the smaller radius. Springs of the model dem need overlaps.
constexpr double kTouching = 1e-6, kSpringsTouch = 0.1;

/// How far x, or an image of it in a box, is inside; negative: outside. For a box longer than the
/// cell it is a lower bound.                                                               [m]
template <int D>
double depth_inside(const Outlet<D>& outlet, const PeriodicCell& cell, Vec<D> x) {
  if (cell.periodic()) x.template head<2>() = wrapped(cell, x.template head<2>());
  if (!outlet.box) return -outlet.normal.dot(x - outlet.point);
  Box<2> at;
  at.include(x.template head<2>());
  double depth = -kInfinity;
  for (const auto& [kx, ky] :
       first_images_over(cell, at, 0, Box<D>{outlet.lower, outlet.upper}.flat())) {
    const Vec<D> image = x + in_dimensions<D>(cell.shift(kx, ky));
    depth = std::max(
        depth, std::min((image - outlet.lower).minCoeff(), (outlet.upper - image).minCoeff()));
  }
  return depth;
}

template <int D>
void find_in_outlets(const Scene<D>& scene, std::vector<StartOverlap<D>>& overlaps) {
  const std::size_t first = scene.bodies.size() + scene.walls.size();
  for (std::size_t k = 0; k < scene.outlets.size(); ++k) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Body<D>& body = scene.bodies[i];
      if (body.wall >= 0) continue;
      Vec<D> x = body.x;
      if (body.cluster >= 0) x = scene.clusters.bodies[to_size(body.cluster)].x;
      const double depth = depth_inside(scene.outlets[k], scene.cell, x);
      if (depth < 0) continue;
      overlaps.push_back(
          {{.i = static_cast<int>(i), .j = static_cast<int>(first + k), .gap = -depth},
           depth / body.radius});
    }
  }
}

/// True if no body's centre is before the half-plane.
template <int D>
bool all_behind(const Scene<D>& scene, const Wall<D>& wall) {
  return wall.shape == Wall<D>::Shape::kHalfPlane &&
         std::all_of(scene.bodies.begin(), scene.bodies.end(), [&](const Body<D>& body) {
           return body.wall >= 0 || wall.normal.dot(body.x - wall.a) < 0;
         });
}

std::string length_text(double metres) {
  return metres < 1 ? fmt::format("{:.3g} mm", 1e3 * metres) : fmt::format("{:.4g} m", metres);
}

}  // namespace

template <int D>
std::vector<StartOverlap<D>> start_overlaps(const Scene<D>& scene, int threads) {
  const std::vector<Wall<D>> walls = walls_at(scene.walls, scene.walls, 0.5 * scene.step);
  std::vector<Contact<D>> contacts =
      scene.cell.periodic()
          ? detect_periodic_contacts<D>(scene.bodies, walls, scene.cell, 0, threads)
          : detect_contacts<D>(scene.bodies, walls, 0, threads);
  leave_out_pinned(scene, contacts);
  const double touching = scene.model == Model::kSpringDashpot ? kSpringsTouch : kTouching;
  std::vector<StartOverlap<D>> overlaps;
  for (const Contact<D>& c : contacts) {
    const double radii = -c.gap / pair_radius(scene.bodies, scene.walls, c.i, c.j);
    if (radii > touching) overlaps.push_back({c, radii});
  }
  find_in_outlets(scene, overlaps);
  std::stable_sort(overlaps.begin(), overlaps.end(),
                   [](const auto& a, const auto& b) { return a.radii > b.radii; });
  return overlaps;
}

template <int D>
std::string overlap_name(const Scene<D>& scene, const std::type_identity_t<Contact<D>>& contact) {
  const std::string first = fmt::format("{} {} and ", kBodyName<D>, contact.i);
  std::size_t j = to_size(contact.j);
  if (j < scene.bodies.size()) {
    return fmt::format("{}{} {}{}", first, kBodyName<D>, j,
                       contact.with_image() ? " across the border of the cell" : "");
  }
  j -= scene.bodies.size();
  if (j < scene.walls.size()) return fmt::format("{}wall '{}'", first, scene.walls[j].name);
  return fmt::format("{}outlet '{}'", first, scene.outlets[j - scene.walls.size()].name);
}

template <int D>
std::vector<int> overlapping_bodies(const Scene<D>& scene,
                                    const std::vector<StartOverlap<D>>& overlaps) {
  std::set<int> bodies;
  for (const StartOverlap<D>& overlap : overlaps) {
    bodies.insert(overlap.contact.i);
    if (to_size(overlap.contact.j) < scene.bodies.size()) bodies.insert(overlap.contact.j);
  }
  return {bodies.begin(), bodies.end()};
}

template <int D>
std::string start_sentence(const Scene<D>& scene, const std::vector<StartOverlap<D>>& overlaps) {
  if (overlaps.empty()) return {};
  const std::size_t count = overlapping_bodies(scene, overlaps).size();
  const StartOverlap<D>& worst = overlaps[0];
  std::string text = fmt::format("{} {}{} overlap{} at the start, worst {}: {}, {:.2g} radii",
                                 count, kBodyName<D>, count == 1 ? "" : "s", count == 1 ? "s" : "",
                                 overlap_name<D>(scene, worst.contact),
                                 length_text(0 - worst.contact.gap), worst.radii + 0.0);
  for (const Wall<D>& wall : scene.walls) {
    if (all_behind(scene, wall)) {
      text += fmt::format("; all lie behind wall '{}': turn its normal, which points to the bodies",
                          wall.name);
    }
  }
  return text;
}

template std::vector<StartOverlap<2>> start_overlaps(const Scene<2>&, int);
template std::vector<StartOverlap<3>> start_overlaps(const Scene<3>&, int);
template std::string overlap_name(const Scene<2>&, const Contact<2>&);
template std::string overlap_name(const Scene<3>&, const Contact<3>&);
template std::vector<int> overlapping_bodies(const Scene<2>&, const std::vector<StartOverlap<2>>&);
template std::vector<int> overlapping_bodies(const Scene<3>&, const std::vector<StartOverlap<3>>&);
template std::string start_sentence(const Scene<2>&, const std::vector<StartOverlap<2>>&);
template std::string start_sentence(const Scene<3>&, const std::vector<StartOverlap<3>>&);

}  // namespace bipot
