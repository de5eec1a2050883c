#include "solvers/prepared_problem.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/manufactured.h"

namespace bipot {
namespace {

TEST(PreparedProblem, ItsCriterionGivesTheBitsOfOneMadeAnew) {
  for (const int dim : {1, 2, 3}) {
    const Manufactured m = manufactured_problem(dim, 20, 40, 5);
    const Vector s = 1.1 * m.s;
    SolverOptions options;
    options.share.share = 0.5;
    options.share.others.friction = 3;
    ContactErrorEvaluator anew = criterion_of(m.problem, options);
    PreparedProblem made(m.problem, 1);
    made.criterion()(m.s);  // what it was asked before leaves no trace
    options.prepared = &made;
    ContactErrorEvaluator shared = criterion_of(m.problem, options);
    const ContactError a = anew(s), b = shared(s);
    EXPECT_EQ(a.guarded(), b.guarded());
    EXPECT_EQ(a.energy, b.energy);
    EXPECT_EQ(anew.velocity(), shared.velocity());
    EXPECT_EQ(anew.energy_at_rest(), anew(Vector::Zero(s.size())).energy);
    EXPECT_EQ(shared.energy_at_rest(), anew.energy_at_rest());
  }
}

TEST(PreparedProblem, ServesItsOwnProblemOnly) {
  const Manufactured m = manufactured_problem(2, 8, 12, 5);
  const ContactProblem copy = m.problem;
  PreparedProblem made(m.problem, 2);
  SolverOptions options;
  options.prepared = &made;
  EXPECT_EQ(prepared(m.problem, options), nullptr);  // one thread
  options.execution.threads = 2;
  EXPECT_EQ(prepared(m.problem, options), &made);
  EXPECT_EQ(prepared(copy, options), nullptr);
}

// A proof is that of one impulse to the last bit and of one tolerance. What was not proved is proved
// or refuted anew, as a solver that lies would find.
TEST(PreparedProblem, RemembersAProofForExactlyThatImpulse) {
  const Manufactured m = manufactured_problem(2, 15, 25, 7);
  PreparedProblem made(m.problem, 1);
  SolverOptions options;
  options.tol = 1e-8;
  options.prepared = &made;
  const Vector s = m.s;
  EXPECT_EQ(made.proved(options.tol, s), nullptr);
  ASSERT_TRUE(prove_claim(m.problem, options, s, contact_error(m.problem, s)).holds);
  ASSERT_NE(made.proved(options.tol, s), nullptr);
  EXPECT_EQ(made.proved(options.tol / 10, s), nullptr);
  Vector other = s;
  other[0] = std::nextafter(other[0], 1e300);
  EXPECT_EQ(made.proved(options.tol, other), nullptr);
  // A false claim: figures that say 0 for an impulse with an error of some per cent.
  other = 1.05 * s;
  EXPECT_FALSE(
      prove_claim(m.problem, options, other, ContactError{.epsilon = 1e-8, .eta = 0}).holds);
  EXPECT_EQ(made.proved(options.tol, other), nullptr);
  // Parts are judged by their share and leave no note.
  options.share.share = 0.5;
  options.tol = 1e-7;
  ASSERT_TRUE(prove_claim(m.problem, options, s, contact_error(m.problem, s)).holds);
  EXPECT_EQ(made.proved(options.tol, s), nullptr);
}

}  // namespace
}  // namespace bipot
