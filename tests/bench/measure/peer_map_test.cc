#include "bench/measure/peer_map.h"

#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Two contacts that do not couple, W = diag(2, 1, 6, 3), mu = 0.5.
ContactProblem two_contacts() {
  return delassus_problem(2, vec({2, 1, 6, 3}).asDiagonal().toDenseMatrix(), vec({-4, 0.5, 1, 0}),
                          vec({0.5, 0.5}));
}

TEST(PeerNaturalMap, IsTheOneByHand) {
  // w = (2 + 6) / 2 = 4. With s = (2, 0; 0, 0): u = (0, 0.5; 1, 0), û = (0.25, 0.5; 1, 0). Contact
  // 0: s - û / 4 = (1.9375, -0.125), inside the cone (0.125 <= 0.96875): off by (0.0625, 0.125).
  // Contact 1: -û / 4 = (-0.25, 0) lies in the polar cone: 0, no residual. ‖s‖ = 2; ‖b‖ / w =
  // sqrt(17.25) / 4 = 1.04; ‖u‖ / w = sqrt(1.25) / 4: the impulse is the scale.
  EXPECT_NEAR(peer_natural_map(two_contacts(), vec({2, 0, 0, 0})),
              std::sqrt(0.0625 * 0.0625 + 0.125 * 0.125) / 2, 1e-15);
}

TEST(PeerNaturalMap, OfNoImpulseIsMeasuredAgainstTheFreeVelocity) {
  // s = 0: û / 4 of contact 0 = (-4 + 0.25, 0.5) / 4, its negative (0.9375, -0.125) inside the
  // cone; contact 1 opens. ‖b‖ = ‖u‖.
  EXPECT_NEAR(peer_natural_map(two_contacts(), Vector::Zero(4)),
              std::hypot(0.9375, 0.125) / (std::sqrt(17.25) / 4), 1e-15);
}

TEST(PeerNaturalMap, DoesNotDependOnUnits) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 4, 0.3, 10);
  // Kilogrammes, metres and seconds to grammes, millimetres and minutes; impulses follow.
  const double mass = 1e3, length = 1e3, time = 1.0 / 60;
  const ContactProblem q = in_units(p, mass, length, time);
  Vector s(p.num_rows());
  for (Eigen::Index i = 0; i < s.size(); ++i) s[i] = 0.1 + 0.01 * std::cos(static_cast<double>(i));
  const double here = peer_natural_map(p, s);
  EXPECT_GT(here, 1e-3);
  EXPECT_NEAR(peer_natural_map(q, s * (mass * length / time)), here, 1e-12 * here);
}

TEST(PeerNaturalMap, RefusesAnImpulseOfAnotherSize) {
  EXPECT_THROW((void)peer_natural_map(two_contacts(), Vector::Zero(3)), std::invalid_argument);
}

}  // namespace
}  // namespace bipot
