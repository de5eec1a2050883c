#include "core/observables/measured_bodies.h"

#include "core/observables/cut_bodies.h"
#include "core/scene/scene_parts.h"
#include "core/scene/sphere_union.h"

namespace bipot {

template <int D>
MeasuredBodies<D> measured_bodies(const State<D>& state) {
  MeasuredBodies<D> bodies;
  bodies.of_disk.assign(state.bodies.size(), -1);
  std::vector<int> of_cluster(state.clusters.bodies.size(), -1);
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Body<D>& d = state.bodies[i];
    if (d.wall >= 0) continue;
    int& body = d.cluster < 0 ? bodies.of_disk[i] : of_cluster[to_size(d.cluster)];
    if (body < 0) {
      body = static_cast<int>(bodies.list.size());
      if (d.cluster < 0) {
        bodies.list.push_back({d.x, d.v, d.spin, d.mass, extent(d), {}});
      } else {
        const Cluster<D>& c = state.clusters.bodies[to_size(d.cluster)];
        bodies.list.push_back({c.x, c.v, c.spin, c.mass, c.size, {}});
      }
    }
    bodies.of_disk[i] = body;
    bodies.list[to_size(body)].parts.push_back(i);
  }
  return bodies;
}

template <int D>
double part_in_box(const State<D>& state, const MeasuredBody<D>& body, const Vec<D>& shift,
                   const Vec<D>& low, const Vec<D>& high) {
  const Body<D>& first = state.bodies[body.parts.front()];
  if (body.parts.size() == 1) return part_in_box(first.x + shift, first.radius, low, high);
  if constexpr (D == 2) {
    std::vector<Circle> circles;
    for (const std::size_t i : body.parts) {
      circles.push_back({state.bodies[i].x + shift, state.bodies[i].radius});
    }
    return union_area_in(circles, low, high);
  } else {
    Vec3 from = Vec3::Constant(kInfinity), to = -from;
    std::vector<Sphere> spheres;
    for (const std::size_t i : body.parts) {
      Sphere& s = spheres.emplace_back(state.bodies[i]);
      s.x += shift;
      from = from.cwiseMin(s.x - Vec3::Constant(s.radius));
      to = to.cwiseMax(s.x + Vec3::Constant(s.radius));
    }
    const bool inside = (from.array() >= low.array()).all() && (to.array() <= high.array()).all();
    const bool outside = (from.array() >= high.array()).any() || (to.array() <= low.array()).any();
    return inside ? body.size : outside ? 0 : union_volume_in(spheres, low, high);
  }
}

template MeasuredBodies<2> measured_bodies(const State<2>&);
template MeasuredBodies<3> measured_bodies(const State<3>&);
template double part_in_box<2>(const State<2>&, const MeasuredBody<2>&, const Vec2&, const Vec2&,
                               const Vec2&);
template double part_in_box<3>(const State<3>&, const MeasuredBody<3>&, const Vec3&, const Vec3&,
                               const Vec3&);

}  // namespace bipot
