#include "core/scene/joints.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace bipot {
namespace {

Vec2 turned(const Disk& d, const Vec2& arm) { return Eigen::Rotation2D<double>(d.angle) * arm; }
Vec3 turned(const Sphere& s, const Vec3& arm) { return s.orientation * arm; }

/// The number of a body for pairs: all disks of a cluster have one, below 0.
template <int D>
int rigid_body(const Scene<D>& scene, int i) {
  const int cluster = scene.bodies[to_size(i)].cluster;
  return cluster < 0 ? i : -1 - cluster;
}

template <int D>
std::string check_joint(const Scene<D>& scene, const typename Scene<D>::Joint& joint) {
  const int bodies = static_cast<int>(scene.bodies.size());
  for (const int i : {joint.i, joint.j}) {
    if (i == joint.j && i == -1) continue;
    if (i < 0 || i >= bodies) return fmt::format("there is no {} {}", kBodyName<D>, i);
    if (scene.bodies[to_size(i)].wall >= 0) {
      return fmt::format("{} {} is glued to a wall", kBodyName<D>, i);
    }
  }
  if (joint.j >= 0 && rigid_body(scene, joint.i) == rigid_body(scene, joint.j)) {
    return fmt::format("{} {} and {} are one body", kBodyName<D>, joint.i, joint.j);
  }
  if (!joint.at_i.allFinite() || !joint.at_j.allFinite() || !std::isfinite(joint.length)) {
    return "a point or the length is not finite";
  }
  if (!joint.is_rope()) return {};
  const auto [from, to] = joint_points<D>(joint, scene.bodies);
  const double apart = (from - to).norm();
  if (apart <= joint.length * (1 + 1e-9)) return {};
  return fmt::format("its length is {:.6g} m, its ends are {:.6g} m apart", joint.length, apart);
}

}  // namespace

template <int D>
std::pair<Vec<D>, Vec<D>> joint_points(const typename Scene<D>::Joint& joint,
                                       std::span<const std::type_identity_t<Body<D>>> bodies) {
  const auto place = [&](int i, const Vec<D>& at) -> Vec<D> {
    if (i < 0) return at;
    return bodies[to_size(i)].x + turned(bodies[to_size(i)], at);
  };
  return {place(joint.i, joint.at_i), place(joint.j, joint.at_j)};
}

template <int D>
void leave_out_pinned(const Scene<D>& scene, std::vector<Contact<D>>& contacts) {
  std::set<std::pair<int, int>> pairs;
  for (const typename Scene<D>::Joint& joint : scene.joints) {
    if (joint.is_rope() || joint.j < 0) continue;
    const int i = rigid_body(scene, joint.i), j = rigid_body(scene, joint.j);
    pairs.insert({std::min(i, j), std::max(i, j)});
  }
  if (pairs.empty()) return;
  std::erase_if(contacts, [&](const Contact<D>& c) {
    if (to_size(c.j) >= scene.bodies.size()) return false;
    const int i = rigid_body(scene, c.i), j = rigid_body(scene, c.j);
    return pairs.contains({std::min(i, j), std::max(i, j)});
  });
}

template <int D>
std::string check_joints(const Scene<D>& scene) {
  if (scene.joints.empty()) return {};
  const char* excluded = nullptr;
  if (scene.model == Model::kSpringDashpot) excluded = "the model \"dem\"";
  if (scene.has_gates()) excluded = "outlets and inlets, which renumber bodies";
  if (scene.cell.periodic()) excluded = "a periodic cell";
  if (scene.accuracy > 0) excluded = "accuracy";
  if (scene.project_overlaps) excluded = "overlaps = \"project\"";
  if (scene.predict_gaps) excluded = "overlaps = \"predict\"";
  if (scene.start == StartChoice::kPushApart) excluded = "[start] overlaps = \"push apart\"";
  if (excluded != nullptr) return fmt::format("pins and ropes do not go with {}", excluded);
  int pins = 0, ropes = 0;
  for (const typename Scene<D>::Joint& joint : scene.joints) {
    const int number = joint.is_rope() ? ropes++ : pins++;
    if (const std::string defect = check_joint(scene, joint); !defect.empty()) {
      return fmt::format("{}[{}]: {}", joint.is_rope() ? "ropes" : "pins", number, defect);
    }
  }
  return {};
}

template std::pair<Vec2, Vec2> joint_points<2>(const Scene<2>::Joint&, std::span<const Disk>);
template std::pair<Vec3, Vec3> joint_points<3>(const Scene<3>::Joint&, std::span<const Sphere>);
template void leave_out_pinned(const Scene<2>&, std::vector<Contact<2>>&);
template void leave_out_pinned(const Scene<3>&, std::vector<Contact<3>>&);
template std::string check_joints(const Scene<2>&);
template std::string check_joints(const Scene<3>&);

}  // namespace bipot
