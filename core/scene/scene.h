#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "core/scene/cell.h"
#include "core/scene/gates.h"
#include "core/scene/observable_choice.h"

namespace bipot {

/// A factor that depends on time: 1, linear between given times and constant outside them, or a
/// sine.
struct TimeFactor {
  std::vector<double> times;    ///< increasing [s]; empty: no table
  std::vector<double> factors;  ///< one for each
  double frequency = 0;         ///< of sin(2 π frequency t + phase), if > 0 [Hz]
  double phase = 0;             ///< [rad]

  bool constant() const { return times.empty() && frequency == 0; }
  double at(double time) const;
  double mean(double from, double to) const;     ///< exact; from <= to
  double largest(double from, double to) const;  ///< of its absolute values; from <= to
  double rate(double time) const;  ///< its derivative, at a kink that from then on [1/s]
  bool operator==(const TimeFactor&) const = default;
};

/// Empty for a sound factor, else one sentence.
std::string check_time_factor(const TimeFactor& factor);

/// Coulomb and rolling friction, Moreau's restitution coefficients and cohesion of one pair of
/// materials. The rows of rolling have the restitution e_t.
struct ContactLaw {
  /// How contacts that meet at the same time share an impact, for all pairs of a scene
  /// (core/motion/impact_law.h).
  enum class Impact { kNewton, kPoisson, kFremond };

  double mu = 0;        ///< friction coefficient, >= 0                    [-]
  double e_n = 0;       ///< normal restitution in [0, 1]                  [-]
  double e_t = 0;       ///< tangential restitution in [0, 1]              [-]
  double cohesion = 0;  ///< largest tension, >= 0: s_n/h >= -cohesion [N]
  double mu_r = 0;      ///< rolling friction, >= 0: moment <= mu_r s_n     [m]
  double mu_spin = 0;   ///< the same about the normal; in 3D only          [m]

  bool operator==(const ContactLaw&) const = default;
};

/// A round body: a disk in 2D, a sphere in 3D.
template <int D>
struct Body;

/// A rigid disk (a cylinder of unit length where a density gave the mass).
template <>
struct Body<2> {
  Vec2 x = Vec2::Zero();  ///< centre                                 [m]
  double angle = 0;       ///< rotation since the start               [rad]
  Vec2 v = Vec2::Zero();  ///< velocity of the centre                 [m/s]
  double spin = 0;        ///< angular velocity, counter-clockwise    [rad/s]
  double radius = 0;      ///< > 0                                    [m]
  double mass = 0;        ///< > 0                                    [kg]
  double inertia = 0;     ///< > 0; m a²/2 for a homogeneous cylinder [kg m²]
  int material = 0;       ///< index into Scene::materials
  /// Glued to this wall: it moves like the wall and has no mass; its contacts act on the wall. -1:
  /// free.
  int wall = -1;
  int cluster = -1;  ///< member of this cluster, without mass of its own; -1: of none

  bool operator==(const Body&) const = default;
};
using Disk = Body<2>;

/// A rigid sphere. Its orientation has no effect on the mechanics: it is for output and pictures.
template <>
struct Body<3> {
  Vec3 x = Vec3::Zero();  ///< centre                                 [m]
  /// Unit; rotation since the start.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 v = Vec3::Zero();     ///< velocity of the centre                 [m/s]
  Vec3 spin = Vec3::Zero();  ///< angular velocity                       [rad/s]
  double radius = 0;         ///< > 0                                    [m]
  double mass = 0;           ///< > 0                                    [kg]
  double inertia = 0;        ///< > 0; 2/5 m a² for a homogeneous sphere [kg m²]
  int material = 0;          ///< index into Scene::materials
  int wall = -1;             ///< as for a disk
  int cluster = -1;          ///< as for a disk

  bool operator==(const Body&) const = default;
};
using Sphere = Body<3>;

/// The word for a body in messages.
template <int D>
inline constexpr const char* kBodyName = D == 2 ? "disk" : "sphere";

/// Disks or spheres that are joined rigidly: one body, with its degrees of freedom at its centre of
/// mass.
template <int D>
struct Cluster;

template <>
struct Cluster<2> {
  Vec2 x = Vec2::Zero();  ///< centre of mass                         [m]
  double angle = 0;       ///< rotation since the start               [rad]
  Vec2 v = Vec2::Zero();  ///< velocity of the centre of mass         [m/s]
  double spin = 0;        ///< angular velocity, counter-clockwise    [rad/s]
  double mass = 0;        ///< > 0                                    [kg]
  double inertia = 0;     ///< > 0, about the centre of mass          [kg m²]
  double size = 0;        ///< > 0, area of the union of its disks    [m²]
};

template <>
struct Cluster<3> {
  Vec3 x = Vec3::Zero();  ///< centre of mass                                 [m]
  /// Unit; rotation since the start.
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 v = Vec3::Zero();        ///< velocity of the centre of mass                 [m/s]
  Vec3 spin = Vec3::Zero();     ///< angular velocity, in the axes of space         [rad/s]
  double mass = 0;              ///< > 0                                            [kg]
  Vec3 inertia = Vec3::Zero();  ///< > 0, principal moments about the centre of mass [kg m²]
  /// Unit; turns the axes of space to those of `inertia`, before anything turned.
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();
  double size = 0;  ///< > 0, volume of the union of its spheres                     [m³]
};

/// The clusters of a scene or a state. A body of a cluster (Body::cluster) has no mass of its own.
/// Its position and velocity follow from its cluster (core/scene/cluster_motion.h).
template <int D>
struct Clusters {
  std::vector<Cluster<D>> bodies;
  /// Of each body of the scene: from the centre of mass of its cluster to its own, before anything
  /// turned; empty without clusters [m]
  std::vector<Vec<D>> arms;

  /// Mass of a cluster as it is given.
  struct Mass {
    double mass = 0;              ///< > 0, or 0: by density                                 [kg]
    double density = 0;           ///< of the union, where no mass is given               [kg/m³]
    Spin<D> inertia = Spin<D>();  ///< about the centre of mass; 0: homogeneous          [kg m²]
  };

  bool empty() const { return bodies.empty(); }
};

/// Moves the body with its present velocities for a time h.
inline void drift(Disk& d, double h) {
  d.x += h * d.v;
  d.angle += h * d.spin;
}
void drift(Sphere& sphere, double h);

/// A wall: a half-plane, a segment or a circle. Behind a half-plane's line through a with outward
/// normal `normal` all is solid. A segment from a to b is solid from both sides, ends included. A
/// circle about a is solid outside (hollow: a drum) or inside. In 3D a half-plane is a half-space,
/// and a circle an infinite cylinder about the line through a along `normal`. In 3D there are
/// triangles and cones too: surfaces that are solid from both sides, edges included. Walls
/// translate; only circles turn, about their centre or axis. State of a wall at a given time:
/// core/scene/wall_motion.h.
template <int D>
struct Wall {
  enum class Shape { kHalfPlane, kSegment, kHollowCircle, kSolidCircle, kMesh, kCone };
  enum class Motion {
    kFixed,
    kMoving,  ///< prescribed velocity
    kDriven   ///< prescribed force along `direction`; mass and one degree of freedom of its own
  };
  struct Mesh;  ///< of triangles: core/scene/triangle_mesh.h
  std::string name;
  Shape shape = Shape::kHalfPlane;
  Motion motion = Motion::kFixed;
  Vec<D> a = Vec<D>::Zero(), b = Vec<D>::Zero();  ///< b: segments, cones   [m]
  Vec<D> normal = Vec<D>::Unit(D - 1);            ///< unit; half-planes, in 3D also cylinders: axis
  Vec<D> v = Vec<D>::Zero();                      ///< current velocity     [m/s]
  Vec<D> direction = Vec<D>::Zero();              ///< unit; driven walls only
  double force = 0;                               ///< along direction      [N]
  double mass = 0;                                ///< driven walls only    [kg]
  int material = 0;
  double radius = 0;    ///< circles, > 0; cones: at a, >= 0                        [m]
  double radius_b = 0;  ///< cones: at b, >= 0                                      [m]
  /// Meshes: the triangles, relative to a.
  std::shared_ptr<const Mesh> mesh;
  double spin = 0;  ///< circles only: counter-clockwise, in 3D about `normal`    [rad/s]
  Vec<D> across =
      Vec<D>::Zero();  ///< driven walls only: prescribed velocity, normal to direction [m/s]
  /// Half-planes and segments: velocity of the surface along the wall, relative to v: a belt. [m/s]
  Vec<D> belt = Vec<D>::Zero();
  /// In 3D, half-spaces and polygons: unit, direction along the wall in which friction is mu. Across
  /// it friction is grain_ratio mu. 0: the same in all directions.
  Vec<D> grain = Vec<D>::Zero();
  double grain_ratio = 1;      ///< > 0                                                    [-]
  double starts = 0;           ///< before that it stands still                            [s]
  double stops = kInfinity;    ///< from then on it stands still                           [s]
  double removed = kInfinity;  ///< from then on it is not there                           [s]
  TimeFactor time_factor;      ///< factor of velocity, spin and belt, or of the force
  double factor_rate = 0;      ///< in a state: of a prescribed velocity's time_factor [1/s]
  bool present = true;         ///< in a state: false once it has been removed

  bool operator==(const Wall&) const = default;  ///< with the very same mesh, if any
  bool has_grain() const { return !grain.isZero(0); }
  bool is_circle() const { return shape == Shape::kHollowCircle || shape == Shape::kSolidCircle; }
  /// A surface in 3D that ends, and may touch a sphere at several points.
  bool is_surface() const { return shape == Shape::kMesh || shape == Shape::kCone; }
};

/// A force on each of some bodies.
template <int D>
struct BodyForce {
  int first = 0, last = -1;       ///< bodies, the last one included
  Vec<D> force = Vec<D>::Zero();  ///< on each, times the factor [N]
  TimeFactor time_factor;
};

/// Drag on the centre of each body: -coefficient × radius × (v - velocity).
template <int D>
struct Drag {
  double coefficient = 0;            ///< 6 π viscosity for spheres; 0: none [N s/m²]
  Vec<D> velocity = Vec<D>::Zero();  ///< of the fluid [m/s]
};

/// Gravity that turns from the first axis to the last one, in their plane (2D: counter-clockwise).
struct Tilt {
  double rate = 0;           ///< 0: it does not turn                 [rad/s]
  double starts = 0;         ///< [s]
  double stops = kInfinity;  ///< [s]

  bool operator==(const Tilt&) const = default;
};

/// The solver that a scene asks for; the command line may override each entry.
struct SolverChoice {
  std::string name = "auto";
  double tol = 1e-8;
  std::string stop = "guarded";
  int max_iterations = 1000000;
  bool limits_iterations = false;  ///< that number was asked for
  bool warm_start = true;
  std::map<std::string, std::string> parameters;
};

/// How contacts are modelled. nscd: rigid disks with exact contact laws, one implicit problem for
/// each step (core/motion/time_stepping.h). dem: springs and dashpots, explicit
/// (core/motion/spring_dashpot.h).
enum class Model { kNonsmooth, kSpringDashpot };

/// Parameters of the spring-dashpot model. Zero: chosen from the scene
/// (core/motion/spring_dashpot_setup.h).
struct SpringDashpotChoice {
  double stiffness = 0;   ///< k_n of every contact                           [N/m]
  double overlap = 1e-3;  ///< target when stiffness is 0, relative to the smallest radius
  double tangential_ratio = 1.0 / 3;  ///< k_t / k_n                                      [-]
  double substep = 0;                 ///< largest substep                                [s]
  double safety = 0.5;                ///< substep over the critical one, when substep is 0
};

/// What becomes of bodies that overlap at the start (core/scene/start_check.h).
enum class StartChoice {
  kRefuse,    ///< the scene is not run
  kAllow,     ///< they stay as they are
  kPushApart  ///< core/motion/push_apart.h
};

/// Output of a run, and how often (in steps; 0: never, but the last step is always written).
struct OutputChoice {
  int every = 100;              ///< HDF5/XDMF frames
  int ledger_every = 1;         ///< rows of the CSV ledger
  bool picture = true;          ///< force-chain picture of the last step (SVG and PNG)
  bool stress_picture = false;  ///< disks coloured by pressure, last step (SVG and PNG)
  bool page = true;             ///< index.html, which shows the run, and its film
  std::vector<int> track;       ///< disks whose trajectory goes to trajectory.csv at every step

  bool operator==(const OutputChoice&) const = default;
};

/// A whole scene file, ready to run, in D dimensions. SI units.
template <int D>
struct Scene {
  /// A pin holds a point of body i at a point of body j or of the ground. A rope holds two such
  /// points within its length: it only pulls.
  struct Joint {
    int i = -1, j = -1;            ///< bodies; j = -1: the ground
    Vec<D> at_i = Vec<D>::Zero();  ///< from the centre of i, before anything turned [m]
    Vec<D> at_j = Vec<D>::Zero();  ///< likewise; on the ground: its place           [m]
    double length = 0;             ///< of a rope, > 0; 0: a pin                     [m]

    bool is_rope() const { return length > 0; }
  };
  std::string title;
  std::string source;               ///< file name, or "generated"
  Vec<D> gravity = Vec<D>::Zero();  ///< before it turns        [m/s²]
  Tilt tilt;
  std::vector<BodyForce<D>> forces;
  Drag<D> drag;
  PeriodicCell cell;  ///< periodic scenes
  std::vector<Body<D>> bodies;
  Clusters<D> clusters;       ///< bodies that are joined rigidly
  std::vector<Joint> joints;  ///< pins and ropes (core/scene/joints.h)
  std::vector<Wall<D>> walls;
  std::vector<Outlet<D>> outlets;      ///< where bodies leave
  std::vector<Inlet<D>> inlets;        ///< where bodies come in
  std::vector<std::string> materials;  ///< names
  std::vector<ContactLaw> laws;        ///< materials² entries, symmetric, row-major
  double step = 0;                     ///< h > 0                    [s]
  int num_steps = 0;
  double duration = 0;  ///< where the scene file gives it instead of steps; else 0 [s]
  /// Largest path of a body or wall in a step, relative to the smallest radius. A step with a
  /// longer path is cut into 2, 4, 8 ... parts. 0: never cut.
  double travel = 0;
  /// Radii by which an impact, or a radius of way, may misplace a body: steps are cut into parts
  /// accordingly (solvers/simulation/accurate_step.h). 0: they are not.
  double accuracy = 0;
  double contact_distance = 0;  ///< eta of data/manual/explanation/method.md §4 [m]
  ContactLaw::Impact impact = ContactLaw::Impact::kNewton;
  bool project_overlaps = false;  ///< after every step: core/motion/projection.h
  bool predict_gaps = false;      ///< pairs that may meet before the next detection take part
  double cohesion_range = 0;      ///< largest gap over which cohesion acts, if > 0          [m]
  /// False: bonds. Cohesion acts at the contacts of the start alone, and no more at those that have
  /// opened.
  bool heal = true;
  StartChoice start = StartChoice::kRefuse;
  Model model = Model::kNonsmooth;
  SolverChoice solver;      ///< nonsmooth model only
  SpringDashpotChoice dem;  ///< spring-dashpot model only
  OutputChoice output;
  std::optional<ObservableChoice<D>> observables;
  std::string caution;  ///< what is left out of its files or looks wrong; empty: nothing

  const ContactLaw& law(int material_a, int material_b) const {
    return laws[to_size(material_a) * materials.size() + to_size(material_b)];
  }
  /// True if some pair of materials is cohesive.
  bool has_cohesion() const;
  /// Largest gap of a candidate, but for those of predict_gaps. [m]
  double detection_distance() const { return std::max(contact_distance, cohesion_range); }
  /// True if bodies may come or go: their number and numbering change (core/motion/population.h).
  bool has_gates() const { return !outlets.empty() || !inlets.empty(); }
  /// True if some pair of materials has friction, rolling included: contacts have tangents.
  bool has_friction() const;
  /// True if some pair of materials has rolling friction.
  bool has_rolling() const;
  /// Rows of a contact.
  int contact_rows() const { return has_rolling() ? 3 * (D - 1) : (has_friction() ? D : 1); }
};

/// From here on an overlap over the smaller radius is worth a warning.
inline constexpr double kDeepOverlap = 0.05;

/// The wall that `k` is, or that the body `k` is glued to; -1: neither. k = bodies.size() + wall.
template <class Bodies>
int wall_of(const Bodies& bodies, int k) {
  const int count = static_cast<int>(bodies.size());
  return k < count ? bodies[to_size(k)].wall : k - count;
}
/// The smaller radius of the pair of a body with another one or with a wall: j = bodies.size() +
/// wall.
template <class Bodies, class Walls>
double pair_radius(const Bodies& bodies, const Walls& walls, int i, int j) {
  const double radius = bodies[to_size(i)].radius;
  const std::size_t other = to_size(j);
  if (other < bodies.size()) return std::min(radius, bodies[other].radius);
  const auto& wall = walls[other - bodies.size()];
  const bool solid = wall.shape == decltype(wall.shape)::kSolidCircle;
  return solid ? std::min(radius, wall.radius) : radius;
}
/// Its contact law.
template <int D, class Bodies, class Walls>
const ContactLaw& pair_law(const Scene<D>& scene, const Bodies& bodies, const Walls& walls, int i,
                           int j) {
  const std::size_t other = to_size(j);
  return scene.law(bodies[to_size(i)].material, other < bodies.size()
                                                    ? bodies[other].material
                                                    : walls[other - bodies.size()].material);
}

/// Gravity at a time; a step takes that at its middle. [m/s²]
template <int D>
Vec<D> gravity_at(const Scene<D>& scene, double time);

/// Radius of the smallest disk, those of inlets included; infinite in a scene without disks. [m]
template <int D>
double smallest_radius(const Scene<D>& scene);

/// Empty for a sound scene, else one sentence that names the entry, its index and its value.
template <int D>
std::string validate(const Scene<D>& scene);

}  // namespace bipot
