#include "bench/compare/case_parts.h"

#include "core/motion/midpoint.h"
#include "core/motion/state.h"
#include "core/motion/time_stepping.h"
#include "core/scene/generators.h"

namespace bipot {

Scene<2> empty_scene(double mu, double e_n, double e_t) {
  Scene<2> scene = one_law<2>({.mu = mu, .e_n = e_n, .e_t = e_t});
  scene.source = "generated";
  scene.gravity = Vec2(0, -kGravity);
  scene.step = 0.01;
  scene.num_steps = 1;
  scene.contact_distance = 1e-9;
  return scene;
}

ContactProblem first_step(const Scene<2>& scene) {
  return step_problem(scene, initial_state(scene));
}

std::function<ContactProblem()> step_of(const Scene<2>& scene) {
  return [scene] { return first_step(scene); };
}

Scene<2> tower(const std::vector<double>& masses, const std::vector<double>& radii) {
  Scene<2> scene = empty_scene(0.3);
  double top = 0;
  for (std::size_t k = 0; k < masses.size(); ++k) {
    const double a = radii[k % radii.size()];
    scene.bodies.push_back(round_body<2>(Vec2(0, top + a), a, masses[k]));
    top += 2 * a;
  }
  scene.walls = {flat_floor<2>()};
  return scene;
}

double relative_difference(const Vector& x, const Vector& y) {
  return (x - y).cwiseAbs().maxCoeff() / y.cwiseAbs().maxCoeff();
}

Vector tower_impulses(const Scene<2>& scene) {
  const Midpoint<2> mid = make_midpoint(scene, initial_state(scene));
  const int dim = scene.has_friction() ? 2 : 1;
  Vector s = Vector::Zero(static_cast<Eigen::Index>(mid.contacts.size()) * dim);
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    // The upper one of the pair and all above it; disks are numbered from the bottom.
    const Contact<2>& contact = mid.contacts[c];
    const bool floor = to_size(contact.j) >= scene.bodies.size();
    double mass = 0;
    for (std::size_t k = to_size(floor ? contact.i : std::max(contact.i, contact.j));
         k < scene.bodies.size(); ++k) {
      mass += scene.bodies[k].mass;
    }
    s[static_cast<Eigen::Index>(c) * dim] = scene.step * scene.gravity.norm() * mass;
  }
  return s;
}

ExtremeCase::Error against(const Vector& known) {
  return [known](const Vector& s, const Vector&) { return relative_difference(s, known); };
}

void add_wedge(Scene<2>& scene, double half_angle) {
  const Disk& disk = scene.bodies[0];
  for (const double side : {1.0, -1.0}) {
    const Vec2 n(side * std::cos(half_angle), std::sin(half_angle));
    scene.walls.push_back(half_space<2>(disk.x - disk.radius * n, n, side > 0 ? "left" : "right"));
  }
}

std::vector<Disk> touching_rows(int columns, int rows) {
  std::vector<Disk> disks = rectangular_lattice(columns, rows, 0.5, Vec2::Zero());
  for (Disk& d : disks) give_mass(d, 1);
  return disks;
}

double push_on_wall(const Scene<2>& scene, std::size_t wall, const Vector& s) {
  const Midpoint<2> mid = make_midpoint(scene, initial_state(scene));
  const int dim = scene.has_friction() ? 2 : 1;
  double sum = 0;
  for (std::size_t c = 0; c < mid.contacts.size(); ++c) {
    if (to_size(mid.contacts[c].j) == scene.bodies.size() + wall) {
      sum += s[static_cast<Eigen::Index>(c) * dim];
    }
  }
  return sum;
}

}  // namespace bipot
