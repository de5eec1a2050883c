#include "tests/support/several_problems.h"

#include "tests/support/random_vector.h"

namespace bipot {
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
  p.u_free = vec({1, 4, -1, 0});
  p.mu = vec({2, 0.5});
  made.answers = {vec({0, 0, 1, 0}), vec({1, -2, 1, 0}), vec({5, -6, 1, 0})};
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
  p.v_free = vec({5, -1, 0});
  p.u_free = p.H.transpose() * p.v_free;
  p.mu = vec({0.2, 0.6});
  made.answers = {vec({1, -0.2, 0, 0}), vec({0, 0, 1, -0.6})};
  return made;
}

}  // namespace bipot
