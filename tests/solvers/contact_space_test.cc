#include "solvers/contact_space.h"

#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(WholeSpace, OneMadeOfAnotherGivesTheBitsOfOneMadeAnew) {
  for (const int dim : {1, 2, 3}) {
    const Manufactured m = manufactured_problem(dim, 20, 40, 5);
    const Vector s = 1.1 * m.s;
    ErrorShare share{.share = 0.5};
    share.others.friction = 3;
    WholeSpace anew(m.problem, 1, share);
    WholeSpace made(m.problem);
    made.error(m.s);  // a question asked before leaves no trace
    WholeSpace shared(made, share);
    const ContactError a = anew.error(s), b = shared.error(s);
    EXPECT_EQ(a.guarded(), b.guarded());
    EXPECT_EQ(a.energy, b.energy);
    EXPECT_EQ(anew.impulse_velocity(), shared.impulse_velocity());
    EXPECT_EQ(anew.energy_at_rest(), anew.error(Vector::Zero(s.size())).energy);
    EXPECT_EQ(shared.energy_at_rest(), anew.energy_at_rest());
  }
}

// A proof is that of one impulse to the last bit and of one tolerance. What was not proved is
// proved or refuted anew, as a solver that lies would find. `lie`: figures that no proof would
// accept.
TEST(WholeSpace, RemembersAProofForExactlyThatImpulse) {
  const Manufactured m = manufactured_problem(2, 15, 25, 7);
  WholeSpace made(m.problem);
  SolverOptions options{.tol = 1e-8};
  const Vector s = m.s, far = 1.05 * s;
  const ContactError truth = made.error(s), lie{.epsilon = 1e-8, .eta = 0};
  // Known: the answer for s whatever the figures say, as no error is taken again.
  const auto known = [&](const Vector& impulse) {
    return made.prove(options, impulse, ContactError{.epsilon = kNaN, .eta = kNaN}).error;
  };
  ASSERT_TRUE(made.prove(options, s, truth).holds);
  EXPECT_TRUE(std::isnan(known(s)));  // proved in double: no figure in a wider precision
  Vector other = s;
  other[0] = std::nextafter(other[0], 1e300);
  EXPECT_FALSE(std::isnan(known(other)));
  // A false claim: figures that say 0 for an impulse with an error of some per cent.
  EXPECT_FALSE(made.prove(options, far, lie).holds);
  EXPECT_FALSE(made.prove(options, far, lie).holds);
  // Another tolerance; and parts are judged by their share and leave no note.
  ASSERT_TRUE(made.prove(options, s, truth).holds);
  options.tol = 1e-7;
  ErrorShare half{.share = 0.5};
  WholeSpace part(made, half);
  ASSERT_TRUE(part.prove(options, s, truth).holds);
  EXPECT_FALSE(std::isnan(known(s)));
}

}  // namespace
}  // namespace bipot
