#include "tests/support/small_problems.h"

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
  ContactProblem p{.dim = dim};
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
