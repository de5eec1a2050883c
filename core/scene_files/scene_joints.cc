#include <cmath>
#include <string>

#include "core/scene_files/scene_tables.h"

namespace bipot {
namespace {

/// The bodies of a pin or rope: two, or one and the ground.
template <int D>
typename Scene<D>::Joint read_joined(const SceneTable& table, const Scene<D>& scene) {
  const std::vector<double> bodies = table.numbers("bodies");
  const auto there = [&](double x) {
    return x >= 0 && x < static_cast<double>(scene.bodies.size()) && x == std::floor(x);
  };
  if (bodies.empty() || bodies.size() > 2 || !there(bodies.front()) || !there(bodies.back())) {
    table.fail("bodies", fmt::format("expected one or two numbers of {}s, from 0 to {}",
                                     kBodyName<D>, static_cast<int>(scene.bodies.size()) - 1));
  }
  typename Scene<D>::Joint joint;
  joint.i = static_cast<int>(bodies[0]);
  if (bodies.size() == 2) joint.j = static_cast<int>(bodies[1]);
  return joint;
}

/// The point relative to the body; as it is on the ground.
template <int D>
Vec<D> on_body(const Scene<D>& scene, int body, const Vec<D>& point) {
  return body < 0 ? point : Vec<D>(point - scene.bodies[to_size(body)].x);
}

template <int D>
typename Scene<D>::Joint read_rope(const SceneTable& table, const Scene<D>& scene) {
  typename Scene<D>::Joint rope = read_joined(table, scene);
  const auto from = table.maybe_vec<D>("from"), to = table.maybe_vec<D>("to");
  if (!to && rope.j < 0) table.fail("to", "is missing: the point of the ground");
  const Vec<D> begin = from ? *from : scene.bodies[to_size(rope.i)].x;
  const Vec<D> end = to ? *to : scene.bodies[to_size(rope.j)].x;
  rope.at_i = on_body(scene, rope.i, begin);
  rope.at_j = on_body(scene, rope.j, end);
  rope.length = table.has("length") ? table.positive("length") : (begin - end).norm();
  if (rope.length == 0) table.fail("length", "is missing: its ends are at one place");
  return rope;
}

}  // namespace

template <int D>
void read_joints(const SceneTable& root, Scene<D>& scene) {
  for (const SceneTable& table : root.tables("pins")) {
    typename Scene<D>::Joint pin = read_joined(table, scene);
    const Vec<D> point = table.vec<D>("point");
    pin.at_i = on_body(scene, pin.i, point);
    pin.at_j = on_body(scene, pin.j, point);
    scene.joints.push_back(pin);
  }
  for (const SceneTable& table : root.tables("ropes")) {
    scene.joints.push_back(read_rope(table, scene));
  }
}

template void read_joints(const SceneTable&, Scene<2>&);
template void read_joints(const SceneTable&, Scene<3>&);

}  // namespace bipot
