#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/scene/contact.h"
#include "core/scene/scene.h"

namespace bipot {

/// Degrees of freedom of each body in the problem's v; -1 for bodies without contacts.
struct DofMap {
  int per_disk =
      3;  ///< position, then spin: 3, in 3D 6; without friction and clusters 2 or 3, no spin
  std::vector<int> disk;       ///< first dof of each disk; those of a cluster share its
  std::vector<int> wall;       ///< the dof of each driven wall
  int side[3] = {-1, -1, -1};  ///< the dof of each driven side of a periodic cell
  int size = 0;
};

/// A periodic cell at mid-step, with the speeds of its sides without contact impulses. Empty in
/// other scenes.
struct CellInput {
  const PeriodicCell* cell = nullptr;
  const double* v_free =
      nullptr;  ///< 3, in the order of PeriodicCell::side                      [m/s]
};

/// Clusters at mid-step; empty in most scenes.
template <int D>
struct ClusterInput {
  std::span<const Cluster<D>> bodies;
  std::span<const Vec<D>> v_free;  ///< of their centres of mass                             [m/s]
};

/// What a step is assembled from. `scene`: materials, joints, walls as given, the step's size.
template <int D>
struct StepInput {
  const Scene<D>& scene;
  std::span<const Body<D>> bodies;  ///< at mid-step, with their velocities before the step
  std::span<const Wall<D>> walls;   ///< likewise
  std::span<const Contact<D>> contacts;
  std::span<const Vec<D>> body_v_free;  ///< without contact impulses                       [m/s]
  std::span<const double> wall_v_free;  ///< of driven walls, along their direction         [m/s]
  CellInput cell = {};
  ClusterInput<D> clusters = {};
  std::span<const double> cohesion = {};  ///< of each contact; empty without                [N]
};

/// The problem of a step, and the map back to the bodies.
struct AssembledStep {
  ContactProblem problem;
  DofMap dofs;
  Vector u_before;  ///< m, physical relative velocities u⁻ before the step    [m/s]
  /// Part of u_free that is not a velocity, m values in the problem's variables: g/h of pairs not
  /// yet in contact, or the turning of contacts. Empty without both. [m/s]
  Vector shift;
  /// Cohesion h c in normal rows, m values in the problem's variables; empty without cohesion. The
  /// problem's impulses are the physical ones and this. [N s]
  Vector pull;
  /// n, velocities before the step in the degrees of freedom; empty without pins and ropes.
  Vector v_before;
};

/// Assembles A, H, u_free, mu (and W on request) of one step of size h. For a contact of disk i with
/// body j:
///
///   u_n = n·(v_i - v_j),  u_t = t·(v_i - v_j) - a_i w_i - a_j w_j,
///   in 3D for both tangents  u_t = t·(v_i - v_j) - (n x t)·(a_i w_i + a_j w_j),
///   D = diag 1/(1+e),  u = D (Hᵀ v⁺ + E Hᵀ v⁻)  (36),
///   symmetric form of data/manual/explanation/method.md §3.
///
/// A normal entry of u_free below the rounding of the contact's tangential ones is set to 0.
///
/// In a periodic cell v_j is that of the image. A driven side of the cell is a degree of freedom,
/// like a driven wall, and comes after these.
///
/// In a cluster the vector c from its centre of mass to the centre of the disk adds (e3 x c)·n w to
/// u_n and (e3 x c)·t w to u_t, in the three degrees of freedom of the cluster. In 3D it adds (w x
/// c)·n and (w x c)·t. The components of w are those along the principal axes of the cluster: so A
/// is diagonal.
///
/// With the scene's predict_gaps the normal row of a contact with a gap g > 0 reads u_n + g/h >= 0.
/// At the midpoint of the next step, h later, it is then closed without overlap (Stewart and
/// Trinkle, Int. J. Numer. Methods Eng. 39, 1996, for the end of the step).
///
/// Cohesion c of a contact is a pair of attractive forces: with s' = s + h c n the law is that of
/// Coulomb for s', u = W s' + u_free - W h c n. Its gap g > 0 is closed: u_n + g/h >= 0.
///
/// With the scene's accuracy the law holds for the velocities halfway to the last and the next
/// midpoint. On the way bodies go straight and the normal turns: u⁺ + δ and u⁻ - δ in place of u⁺
/// and u⁻. Then bodies that slide or roll on each other keep their gap and their energy to the
/// second order in h. δ: data/manual/explanation/accuracy.md. [ours]
///
/// Pins and ropes of the scene: core/motion/joint_rows.h. The contacts of ropes come last.
///
/// With rolling friction follow the rows ω_i - ω_j (a wall's spin in place of ω_j): one in the plane;
/// along t1, t2 and n in 3D.
///
/// If no pair of the scene's materials has friction, the contact dimension is 1 (no tangential
/// rows, no rotations). Only bodies in contact enter. Driven walls have a degree of freedom; other
/// moving walls enter the right-hand side. Restitution applies to every candidate alike. [ours,
/// data/manual/explanation/method.md §3]
template <int D>
AssembledStep assemble_step(const StepInput<D>& in, int threads = 1);

}  // namespace bipot
