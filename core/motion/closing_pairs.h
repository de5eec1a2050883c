#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/near_pairs.h"
#include "core/scene/scene.h"

namespace bipot {

/// Accelerations of everything that moves.                                         [m/s², rad/s²]
template <int D>
struct Accelerations {
  std::vector<Vec<D>> bodies;
  std::vector<Spin<D>> spins;  ///< of the bodies
  std::vector<Vec<D>> walls;
  double sides[3] = {0, 0, 0};  ///< of the lengths of a periodic cell
};

/// Those without contacts: by gravity, by forces on bodies and drag, by the forces that drive walls
/// and sides, by schedules.
template <int D>
Accelerations<D> free_accelerations(const Scene<D>& scene, const State<D>& state,
                                    const std::vector<Wall<D>>& walls);
/// The means of a step of size h; of walls with a schedule, that of its middle.
template <int D>
Accelerations<D> mean_accelerations(const Scene<D>& scene, const State<D>& before,
                                    const State<D>& after, double h);

/// A body against another one, an image of it or a wall, at one time.
template <int D>
struct PairPlace {
  double gap = kInfinity;
  Vec<D> n = Vec<D>::Zero();  ///< unit, to the body; 0 in the middle of a hollow circle
  double bend = 0;  ///< 1 over the distance between the centres; negative in a hollow circle [1/m]
};
/// j: of a body, or bodies.size() + wall.
template <int D>
PairPlace<D> pair_place(const std::vector<Body<D>>& bodies, const std::vector<Wall<D>>& walls,
                        const PeriodicCell& cell, const typename NearPairs<D>::Pair& pair);

/// A pair that is about to collide.
template <int D>
struct Closing {
  int i, j;
  double time;   ///< until then; 0 where it overlaps                                        [s]
  double speed;  ///< of approach, > 0                                                     [m/s]
  double bend;   ///< second derivative of the gap                                        [m/s²]
};

/// Foresees which pairs collide within a part of a step, from positions, velocities and
/// accelerations alone. With the normal n of the pair at the start, and the tangential velocity u_t
/// of the centres,
///   gap(t) = gap + u_n t + c t²/2,   c = a_n + u_t²/ℓ,
/// ℓ: the distance between the centres of two disks, infinite for a plane.
template <int D>
class ClosingPairs {
 public:
  explicit ClosingPairs(const Scene<D>& scene, int threads = 1);

  /// The collisions within h, sorted by time. Pairs whose gap is at most the scene's contact
  /// distance collide now if they approach. `walls`: as they are in the part. h becomes shorter
  /// where bodies are too fast to look so far ahead: in large scenes and cells.
  std::vector<Closing<D>> find(const State<D>& state, const std::vector<Wall<D>>& walls,
                               const Accelerations<D>& a, double& h);
  /// The pairs that overlap in a state.
  std::vector<typename NearPairs<D>::Pair> overlapping(const State<D>& state);
  /// To be called where bodies came or went.
  void forget() { near_.forget(); }

 private:
  template <class Visit>
  void visit_walls(const State<D>& state, const std::vector<Wall<D>>& walls, const Visit& visit);

  const Scene<D>& scene_;
  int threads_;
  double longest_body_ = 0;
  NearPairs<D> near_;
  std::vector<double> ways_;
};

}  // namespace bipot
