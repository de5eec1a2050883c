#include "tests/small_problems.h"

#include <cmath>
#include <numbers>

#include "core/assembly.h"
#include "core/contact_detection.h"
#include "core/delassus.h"
#include "core/generators.h"

namespace bipot {

ContactProblem one_contact_problem(int dim, double w_n, double w_t, double mu, double b_n,
                                   const Vector& b_t) {
  ContactProblem p;
  p.dim = dim;
  p.A.resize(dim, dim);
  p.H.resize(dim, dim);
  for (int k = 0; k < dim; ++k) {
    p.A.insert(k, k) = 1 / (k == 0 ? w_n : w_t);
    p.H.insert(k, k) = 1;
  }
  p.A.makeCompressed();
  p.H.makeCompressed();
  p.W = assemble_delassus(p.A, p.H, dim);
  p.u_free.resize(dim);
  p.u_free << b_n, b_t.head(dim - 1);
  p.v_free = p.u_free;
  p.mu = Vector::Constant(1, mu);
  return p;
}

ContactProblem local_form(const ContactProblem& problem) {
  ContactProblem p = problem;
  if (!p.has_delassus()) p.W = assemble_delassus(p.A, p.H, p.dim);
  p.A = SparseMatrix();
  p.H = SparseMatrix();
  p.v_free = Vector();
  return p;
}

ContactProblem lattice_step(Lattice lattice, int rows, double mu, double tilt) {
  constexpr double kRadius = 0.5, kStep = 0.01, kGravity = 9.81;
  Scene scene;
  scene.materials = {"disk"};
  scene.laws = {{.mu = mu, .e_n = 0, .e_t = 0}};
  const Vec2 corner(0, 0);
  switch (lattice) {
    case Lattice::kSquare:
      scene.disks = rectangular_lattice(rows, rows, kRadius, corner);
      break;
    case Lattice::kTriangular:
      scene.disks = triangular_lattice(rows, rows, kRadius, corner);
      break;
    case Lattice::kPyramid:
      scene.disks = pyramid(rows, kRadius, corner);
      break;
  }
  for (Disk& disk : scene.disks) {
    disk.mass = 1;
    disk.inertia = 0.5 * kRadius * kRadius;
  }
  const auto wall = [](const Vec2& a, const Vec2& normal) {
    Wall w;
    w.a = a;
    w.normal = normal;
    return w;
  };
  scene.walls = {wall(corner, Vec2(0, 1))};
  if (lattice != Lattice::kPyramid) {
    scene.walls.push_back(wall(corner, Vec2(1, 0)));
    scene.walls.push_back(wall(Vec2(rows * 2 * kRadius, 0), Vec2(-1, 0)));
  }
  const double angle = tilt * std::numbers::pi / 180;
  const std::vector<Vec2> fall(scene.disks.size(),
                               kStep * kGravity * Vec2(std::sin(angle), -std::cos(angle)));
  const std::vector<double> still(scene.walls.size(), 0.0);
  const auto contacts = detect_contacts(scene.disks, scene.walls, 1e-9);
  return assemble_step(scene, scene.disks, scene.walls, contacts, fall, still, false).problem;
}

ContactProblem in_units(const ContactProblem& problem, double mass, double length, double time) {
  ContactProblem p = local_form(problem);
  p.W *= 1 / mass;
  p.u_free *= length / time;
  return p;
}

}  // namespace bipot
