#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/motion/state.h"

namespace bipot {

/// How far things move in a step, at the faster of their velocities at its two ends. Bodies move
/// against the cell that they are in (image_velocity()); `way` adds how far cells move against each
/// other.
struct StepTravel {
  double radii = 0;          ///< largest of the bodies, over the radius of the body
  double way = 0;            ///< largest of the bodies                                    [m]
  double wall_way = 0;       ///< largest of plates and cylinders, which have a far side   [m]
  double least = kInfinity;  ///< smallest radius of the bodies and cylinders              [m]

  /// Contacts are looked for at mid-steps, which lie a step's way apart. Slower bodies are seen
  /// before their centres meet.
  bool may_pass() const { return way + wall_way > least; }
};
template <int D>
StepTravel step_travel(const State<D>& before, const State<D>& after, double h);

/// The centre of a body in a step: straight from its first place to mid-step, and on to the last.
/// `before`: where it was at the mid-step before.
template <int D>
struct BodyPath {
  int number = -1;  ///< of the body
  Vec<D> before = Vec<D>::Zero(), from = Vec<D>::Zero(), mid = Vec<D>::Zero(), to = Vec<D>::Zero();
  double radius = 0;
  int wall = -1, cluster = -1;  ///< as of Body
  bool fast = false;            ///< it may pass something
  bool elsewhere = false;       ///< of another process, which looks at its walls
};
/// The ways of all bodies of the states. `number`: of the body at an index. `travel`: the largest of
/// all processes.
template <int D>
std::vector<BodyPath<D>> paths_of(const State<D>& before, const State<D>& after, double h,
                                  const StepTravel& travel, const std::function<int(int)>& number);

/// Two bodies, or a body and a wall, that went through each other.
struct Passage {
  int i = -1;        ///< number of a body
  int j = -1;        ///< of a body with a larger number; -1: a wall
  int wall = -1;     ///< its index
  double speed = 0;  ///< of one against the other in the faster half of the step        [m/s]
};

/// The passages of a step of size h. In each half of it the ways are straight. Two bodies passed
/// each other if they came closer than half the smaller radius below touching, and parted or turned
/// up on the other side. A step may end in between: then the mid-steps around it tell. A
/// plate, half-plane or hollow circle is passed where a centre crosses it. `ways`: of the bodies
/// here and the fast ones elsewhere; a pair of two processes is found on one. Sorted.
template <int D>
std::vector<Passage> find_passages(const State<D>& before, const State<D>& after, double h,
                                   const std::vector<BodyPath<D>>& ways);

/// The same for states of which this process has all; numbers as of body_number().
template <int D>
std::vector<Passage> find_passages(const State<D>& before, const State<D>& after, double h);

/// "disk 3 went through wall 'lid' at 300 m/s"
template <int D>
std::string passage_text(const Scene<D>& scene, const Passage& passage);

/// Numbers for other processes, and back.
template <int D>
std::vector<double> packed(const std::vector<BodyPath<D>>& ways);
template <int D>
std::vector<BodyPath<D>> unpacked(const std::vector<double>& numbers);

}  // namespace bipot
