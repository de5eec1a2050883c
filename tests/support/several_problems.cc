#include "tests/support/several_problems.h"

#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"

namespace bipot {

SeveralProblem painleve_problem() {
  const Eigen::Matrix4d W{{1, 1, 0, 0}, {1, 1.5, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  return {delassus_problem(2, W, vec({1, 4, -1, 0}), vec({2, 0.5})),
          {vec({0, 0, 1, 0}), vec({1, -2, 1, 0}), vec({5, -6, 1, 0})}};
}

SeveralProblem two_frictions_problem() {
  // Normal: y; tangent: x. The third degree of freedom, the spin, is not touched.
  const Eigen::MatrixXd H{{0, 1, 0, 1}, {1, 0, 1, 0}, {0, 0, 0, 0}};
  return {unit_masses(2, H, vec({5, -1, 0}), vec({0.2, 0.6})),
          {vec({1, -0.2, 0, 0}), vec({0, 0, 1, -0.6})}};
}

}  // namespace bipot
