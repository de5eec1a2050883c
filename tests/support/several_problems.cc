#include "tests/support/several_problems.h"

namespace bipot {
namespace {

Vector vector_of(std::initializer_list<double> x) {
  Vector v(static_cast<Eigen::Index>(x.size()));
  std::copy(x.begin(), x.end(), v.begin());
  return v;
}

}  // namespace

SeveralProblem painleve_problem() {
  SeveralProblem made;
  ContactProblem& p = made.problem;
  p.dim = 2;
  p.W.resize(4, 4);
  p.W.insert(0, 0) = 1;
  p.W.insert(0, 1) = 1;
  p.W.insert(1, 0) = 1;
  p.W.insert(1, 1) = 1.5;
  p.W.insert(2, 2) = 1;
  p.W.insert(3, 3) = 1;
  p.W.makeCompressed();
  p.u_free = vector_of({1, 4, -1, 0});
  p.mu = vector_of({2, 0.5});
  made.answers = {vector_of({0, 0, 1, 0}), vector_of({1, -2, 1, 0}), vector_of({5, -6, 1, 0})};
  return made;
}

SeveralProblem two_frictions_problem() {
  SeveralProblem made;
  ContactProblem& p = made.problem;
  p.dim = 2;
  p.A.resize(3, 3);
  p.A.setIdentity();
  // Normal: y; tangent: x. The third degree of freedom, the spin, is not touched.
  p.H.resize(3, 4);
  for (int c = 0; c < 2; ++c) {
    p.H.insert(1, 2 * c) = 1;
    p.H.insert(0, 2 * c + 1) = 1;
  }
  p.H.makeCompressed();
  p.v_free = vector_of({5, -1, 0});
  p.u_free = p.H.transpose() * p.v_free;
  p.mu = vector_of({0.2, 0.6});
  made.answers = {vector_of({1, -0.2, 0, 0}), vector_of({0, 0, 1, -0.6})};
  return made;
}

}  // namespace bipot
