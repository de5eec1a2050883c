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
                   const Box<D>& box) {
  const Body<D>& first = state.bodies[body.parts.front()];
  if (body.parts.size() == 1) return part_in_box(first.x + shift, first.radius, box);
  if constexpr (D == 2) {
    std::vector<Circle> circles;
    for (const std::size_t i : body.parts) {
      circles.push_back({state.bodies[i].x + shift, state.bodies[i].radius});
    }
    return union_area_in(circles, box.lower, box.upper);
  } else {
    Box<3> around;
    std::vector<Sphere> spheres;
    for (const std::size_t i : body.parts) {
      Sphere& s = spheres.emplace_back(state.bodies[i]);
      s.x += shift;
      around.include(s.x, s.radius);
    }
    const auto from = around.lower.array(), to = around.upper.array();
    const auto low = box.lower.array(), high = box.upper.array();
    if ((from >= low).all() && (to <= high).all()) return body.size;
    if ((from >= high).any() || (to <= low).any()) return 0;
    return union_volume_in(spheres, box.lower, box.upper);
  }
}

template MeasuredBodies<2> measured_bodies(const State<2>&);
template MeasuredBodies<3> measured_bodies(const State<3>&);
template double part_in_box(const State<2>&, const MeasuredBody<2>&, const Vec2&, const Box<2>&);
template double part_in_box(const State<3>&, const MeasuredBody<3>&, const Vec3&, const Box<3>&);

}  // namespace bipot
