#include "tests/support/small_problems.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/problem/delassus.h"
#include "core/problem_files/problem_file.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/source_folder.h"

namespace bipot {

ContactProblem shipped_file(const std::string& name) {
  return read_problem(source_folder() / "data/problems" / name).problem;
}

ContactProblem one_contact_problem(int dim, double w_n, double w_t, double mu, double b_n,
                                   const Vector& b_t) {
  Vector mass = Vector::Constant(dim, 1 / w_t), b(dim);
  mass[0] = 1 / w_n;
  b << b_n, b_t.head(dim - 1);
  ContactProblem p{.dim = dim,
                   .A = Eigen::MatrixXd(mass.asDiagonal()).sparseView(),
                   .H = Eigen::MatrixXd::Identity(dim, dim).sparseView(),
                   .v_free = b,
                   .u_free = b,
                   .mu = Vector::Constant(1, mu)};
  p.W = assemble_delassus(p.A, p.H, dim);
  return p;
}

FourBars four_bars() {
  constexpr double kWeight = 9.81e-3;  // of a bar, times the step
  const double mu = 0.3, r = std::sqrt(0.5), impulse = 1.6 * kWeight;
  FourBars bars;
  bars.s = impulse * Vec2(1, mu);
  bars.slides_at = -(0.5 - 0.625 * mu * impulse);
  bars.turns_at = -0.75 * r * impulse * Vec2(mu + 1, mu - 1);
  const Vec2 vertices[] = {{0, -r}, {r, 0}, {0, r}, {-r, 0}};  // bar k ends at k and k + 1
  // The impulse that a bar gets from a unit impulse along the axis at a vertex.
  const auto wrench = [&](int bar, int vertex, const Vec2& axis) {
    const Vec2 arm = vertices[vertex] - 0.5 * (vertices[bar] + vertices[(bar + 1) % 4]);
    return Eigen::Vector3d(axis[0], axis[1], arm[0] * axis[1] - arm[1] * axis[0]);
  };
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(12, 2), G = Eigen::MatrixXd::Zero(8, 12);
  H.col(0).head<3>() = wrench(0, 0, Vec2(0, 1));
  H.col(1).head<3>() = wrench(0, 0, Vec2(-1, 0));
  Vector mass(12);
  ContactProblem& p = bars.problem;
  p.v_free.resize(12);
  for (int k = 0; k < 4; ++k) {
    const int other = (k + 3) % 4;
    for (int x = 0; x < 2; ++x) {
      G.block<1, 3>(2 * k + x, 3 * k) = wrench(k, k, Vec2::Unit(x)).transpose();
      G.block<1, 3>(2 * k + x, 3 * other) = -wrench(other, k, Vec2::Unit(x)).transpose();
    }
    mass.segment<3>(3 * k) << 1, 1, 1.0 / 12;
    p.v_free.segment<3>(3 * k) << 0.5, -kWeight, 0;
  }
  p.A = Eigen::MatrixXd(mass.asDiagonal()).sparseView();
  p.H = H.sparseView();
  p.u_free = H.transpose() * p.v_free;
  p.mu = Vector::Constant(1, mu);
  bars.G = SparseRows(G.sparseView());
  return bars;
}

ContactProblem delassus_problem(int dim, const Eigen::MatrixXd& W, const Vector& b,
                                const Vector& mu) {
  return {.dim = dim, .W = SparseRows(W.sparseView()), .u_free = b, .mu = mu};
}

ContactProblem unit_masses(int dim, const Eigen::MatrixXd& H, const Vector& v_free,
                           const Vector& mu) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(H.rows(), H.rows());
  return {.dim = dim,
          .A = A.sparseView(),
          .H = H.sparseView(),
          .v_free = v_free,
          .u_free = H.transpose() * v_free,
          .mu = mu};
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
  const LatticeOptions options{.dim = mu == 0 ? 1 : 2,
                               .mu = mu,
                               .tilt = tilt * std::numbers::pi / 180,
                               .radius = 0.5,
                               .mass = 1,
                               .time_step = 0.01};
  switch (lattice) {
    case Lattice::kSquare:
      return square_lattice(rows, options);
    case Lattice::kTriangular:
      return triangular_lattice(rows, options);
    case Lattice::kPyramid:
      return pyramid(rows, options);
  }
  throw std::invalid_argument("unknown lattice");
}

ContactProblem in_units(const ContactProblem& problem, double mass, double length, double time) {
  ContactProblem p = local_form(problem);
  p.W *= 1 / mass;
  p.u_free *= length / time;
  return p;
}

}  // namespace bipot
