#include "core/criterion/impulse_verdict.h"

#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

using Kind = ContactFault::Kind;

/// W = diag(w_n, 1), mu = 1/2, u_free = (b_n, b_t).
ContactProblem one_contact(double w_n, double b_n, double b_t) {
  return one_contact_problem(2, w_n, 1, 0.5, b_n, vec({b_t}));
}

/// The only contact's only fault.
ContactFault only_fault(const ImpulseVerdict& v) {
  EXPECT_EQ(v.worst.size(), 1u);
  if (v.worst.size() != 1) return {};
  EXPECT_EQ(v.worst[0].contact, 0);
  EXPECT_EQ(v.worst[0].share, 1);
  EXPECT_EQ(v.worst[0].faults.size(), 1u);
  return v.worst[0].faults.empty() ? ContactFault{} : v.worst[0].faults[0];
}

TEST(ImpulseVerdict, FindsNothingWrongWithTheLawsThreeStates) {
  // Take-off; stick: s = -b; slip: |s_t| = mu s_n against u_t = b_t + s_t = 0.3.
  for (const auto& [b, s] :
       {std::pair{vec({1, 2}), vec({0, 0})}, std::pair{vec({-1, 0.25}), vec({1, -0.25})},
        std::pair{vec({-1, 0.75}), vec({1, -0.5})}}) {
    const ImpulseVerdict v = judge(one_contact(1, b[0], b[1]), s);
    EXPECT_EQ(v.guarded(), 0);
    EXPECT_EQ(v.cone, 0);
    EXPECT_EQ(v.siconos_map, 0);
    EXPECT_TRUE(v.worst.empty());
    EXPECT_EQ(v.penetration_contact, -1);
    EXPECT_EQ(v.cone_contact, -1);
    EXPECT_EQ(sentence(v, 1e-8), "within the tolerance 1e-8: error 0.00e+00");
  }
}

TEST(ImpulseVerdict, SaysThatAContactPulls) {
  // The projection is 0 and u = b opens: the law holds, but what was given does not.
  const ImpulseVerdict v = judge(one_contact(2, 1, 0), vec({-0.1, 0}));
  EXPECT_EQ(v.error.guarded(), 0);
  EXPECT_EQ(v.guarded(), kInfinity);  // nothing moves that it could be compared with
  const ContactFault f = only_fault(v);
  EXPECT_EQ(f.kind, Kind::kPulls);
  EXPECT_EQ(f.size, -0.1);
  EXPECT_DOUBLE_EQ(f.energy, 0.5 * 2 * 0.01);
  EXPECT_DOUBLE_EQ(v.cone_violation, 0.1);
  EXPECT_EQ(v.cone_contact, 0);
  EXPECT_EQ(sentence(v.worst[0]), "contact 0: pulls with s_n = -1.0e-01 N s");
}

TEST(ImpulseVerdict, SaysThatAnImpulseLiesOutsideTheCone) {
  // P(1, 0.8) = (1.12, 0.56), (1 + 0.5 * 0.8) / 1.25 = 1.12: off by (0.12, 0.24), energy 0.036.
  // With b = -(1.12, 0.56) the projected impulse sticks: it is the solution.
  const ImpulseVerdict v = judge(one_contact(1, -1.12, -0.56), vec({1, 0.8}));
  EXPECT_LT(v.error.guarded(), 1e-12);
  const ContactFault f = v.worst.at(0).faults.at(0);
  EXPECT_EQ(f.kind, Kind::kOutsideCone);
  EXPECT_NEAR(f.size, 0.8 - 0.5, 1e-15);
  EXPECT_NEAR(f.energy, 0.036, 1e-15);
  EXPECT_NEAR(v.cone_violation, std::sqrt(0.072), 1e-15);
  // E = s·W s / 2 = (1.12² + 0.56²) / 2 = 0.784, D = 0.
  EXPECT_NEAR(v.cone, std::sqrt(0.036 / 0.0784), 1e-12);
  EXPECT_EQ(v.guarded(), v.cone);
  EXPECT_EQ(sentence(v, 1e-8).find("not within the tolerance 1e-8: distance to the cone"), 0u);
}

TEST(ImpulseVerdict, SaysThatAContactPenetrates) {
  // u_n = -1, V = 1/2 / 2; E is the same energy: epsilon = 1 / theta.
  const ImpulseVerdict v = judge(one_contact(2, -1, 0), vec({0, 0}));
  const ContactFault f = only_fault(v);
  EXPECT_EQ(f.kind, Kind::kPenetrates);
  EXPECT_EQ(f.size, -1);
  EXPECT_DOUBLE_EQ(f.energy, 0.25);
  EXPECT_DOUBLE_EQ(v.error.epsilon, 1 / kTheta);
  EXPECT_EQ(v.penetration_velocity, 1);
  EXPECT_EQ(v.penetration_contact, 0);
  EXPECT_EQ(v.count.take_off, 1);
}

TEST(ImpulseVerdict, SaysThatAnImpulseActsAcrossAGap) {
  // u_n = 2 * 1 - 1.
  const ContactFault f = only_fault(judge(one_contact(2, -1, 0), vec({1, 0})));
  EXPECT_EQ(f.kind, Kind::kActsAcrossGap);
  EXPECT_EQ(f.size, 1);
  EXPECT_DOUBLE_EQ(f.energy, 1);
}

TEST(ImpulseVerdict, SaysThatAContactSlidesInsideItsCone) {
  // u = (0, 0.8 - 0.25): mu s_n |u_t| + s_t u_t = (0.5 - 0.25) 0.55.
  const ImpulseVerdict v = judge(one_contact(1, -1, 0.8), vec({1, -0.25}));
  const ContactFault f = only_fault(v);
  EXPECT_EQ(f.kind, Kind::kSlidesInside);
  EXPECT_DOUBLE_EQ(f.size, 0.55);
  EXPECT_DOUBLE_EQ(f.energy, 0.1375);
  EXPECT_EQ(sentence(v.worst[0]), "contact 0: slides at 5.5e-01 m/s, |s_t| being 0.5 of mu s_n");
  // û = (0.275, 0.55), P(s - û) = P(0.725, -0.8) = (0.9, -0.45): off by (0.1, 0.2); ‖b‖² = 1.64 is
  // the largest of the three norms.
  EXPECT_NEAR(v.siconos_map, std::sqrt(0.05 / 1.64), 1e-15);
}

TEST(ImpulseVerdict, SaysThatFrictionDoesNotOppose) {
  const ContactFault along = only_fault(judge(one_contact(1, -1, 0.8), vec({1, 0.5})));
  EXPECT_EQ(along.kind, Kind::kNotOpposed);
  EXPECT_DOUBLE_EQ(along.size, 1.3);
  EXPECT_DOUBLE_EQ(along.energy, 0.5 * 1.3 + 0.5 * 1.3);
  // In space: at right angles to the slip, u_t = (0, 0.8 + 0.5) and s_t = (0.5, 0) less the 0.5
  // that b_t takes away.
  const ContactProblem p = one_contact_problem(3, 1, 1, 0.5, -1, vec({-0.5, 0.8}));
  const ImpulseVerdict right_angle = judge(p, vec({1, 0.5, 0}));
  const ContactFault across = only_fault(right_angle);
  EXPECT_EQ(across.kind, Kind::kNotOpposed);
  EXPECT_EQ(sentence(right_angle.worst[0]),
            "contact 0: slides at 8.0e-01 m/s, which s_t does not oppose: 1.6e+00 rad off");
  EXPECT_DOUBLE_EQ(across.energy, 0.5 * 0.8);
}

TEST(ImpulseVerdict, IsTheCriterionAndNamesTheSameWorstContact) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 20, 40, 7);
    Vector s = m.s;
    for (Eigen::Index i = 0; i < s.size(); i += 3) s[i] += 1e-3 * std::cos(static_cast<double>(i));
    const ContactProblem& p = m.problem;
    const ImpulseVerdict v = judge(p, s, p.num_contacts());
    const ContactError e = contact_error(p, s);
    EXPECT_EQ(v.error.epsilon, e.epsilon);
    EXPECT_EQ(v.error.eta, e.eta);
    // Inside the cone, so that nothing but the law ranks.
    const ImpulseVerdict inside = judge(p, v.s, p.num_contacts());
    EXPECT_LT(inside.cone, 1e-14);
    ASSERT_FALSE(inside.worst.empty());
    EXPECT_EQ(inside.worst[0].contact, e.eta > e.epsilon ? e.worst_eta : e.worst_epsilon);
    double share = 0;
    for (const JudgedContact& c : inside.worst) {
      EXPECT_LE(c.share, inside.worst[0].share);
      share += c.share;
    }
    EXPECT_NEAR(share, 1, 1e-12);
    EXPECT_EQ(judge(p, s, 3).worst.size(), 3u);
    EXPECT_TRUE(judge(p, s, 0).worst.empty());
  }
}

TEST(ImpulseVerdict, RestitutionIsJudgedInPhysicalVariables) {
  // The problem in scaled variables s = r s_phys, u = r u_phys with r = (1.4, 1.1), and the same
  // without: W = D W D, b = D b with D = 1/r, mu = mu r_t / r_n.
  const ContactProblem plain = one_contact(2, -1, 0.8);
  ContactProblem scaled = local_form(plain);
  const Vector r = vec({1.4, 1.1});
  scaled.row_scale = r;
  for (int i = 0; i < 2; ++i) {
    scaled.u_free[i] *= r[i];
    scaled.W.coeffRef(i, i) *= 1;
  }
  scaled.mu[0] *= 1.1 / 1.4;
  // u = W s + b: r u_phys = W_s r s_phys + r b_phys, hence W_s = W_phys for a diagonal W.
  const Vector s = vec({0.7, -0.2});
  const ImpulseVerdict a = judge(plain, s), b = judge(scaled, s.cwiseProduct(r));
  ASSERT_EQ(a.worst.size(), 1u);
  ASSERT_EQ(b.worst.size(), 1u);
  EXPECT_NEAR(b.worst[0].mu, 0.5, 1e-15);
  for (int k = 0; k < 2; ++k) {
    EXPECT_NEAR(b.worst[0].s[k], s[k], 1e-15);
    EXPECT_NEAR(b.worst[0].u[k], a.worst[0].u[k], 1e-15);
  }
  EXPECT_NEAR(b.penetration_velocity, a.penetration_velocity, 1e-15);
  // sᵀ W s in physical variables has W_phys = r W r (core/criterion/contact_error.cc), so energies
  // differ from those of the plain problem; the kinds do not.
  ASSERT_EQ(a.worst[0].faults.size(), b.worst[0].faults.size());
  for (std::size_t k = 0; k < a.worst[0].faults.size(); ++k) {
    EXPECT_EQ(a.worst[0].faults[k].kind, b.worst[0].faults[k].kind);
  }
}

// W s + b cancels to 1e-16 of its parts: 0 in double precision, and 8.0e-3 with the exact sums
// u = (-5.55e-17, -2.22e-16) (rational arithmetic).
TEST(ImpulseVerdict, JudgesInHigherPrecisionWhereRoundingDecides) {
  Eigen::Matrix2d W;
  W << 0.1, -0.6, -0.6, 3.6000000000036;
  const ContactProblem p = delassus_problem(
      2, W, Eigen::Vector2d(-1.1102230246251565e-16, -3.6002312242544576e-12), Vector::Ones(1));
  const ImpulseVerdict verdict = judge(p, Eigen::Vector2d(6, 1));
  EXPECT_LE(verdict.error.guarded(), 1e-8);
  EXPECT_NEAR(verdict.guarded(), 8.0e-3, 1e-4);
  EXPECT_TRUE(sentence(verdict, 1e-8).starts_with("not within"));
  EXPECT_TRUE(says(sentence(verdict, 1e-8), "higher precision"));
}

TEST(ImpulseVerdict, RefusesWhatIsNoImpulse) {
  ContactProblem p = one_contact(1, -1, 0);
  const auto refusal = [&](const Vector& s) -> std::string {
    return refusal_of<std::invalid_argument>([&] { judge(p, s); });
  };
  EXPECT_EQ(refusal(vec({1, 0, 0})), "s has size 3, expected 2 = 1 contacts x 2");
  EXPECT_EQ(refusal(vec({1, kNaN})), "s[1] = nan is not finite");
  EXPECT_EQ(refusal(vec({kInfinity, 0})), "s[0] = inf is not finite");
  EXPECT_EQ(refusal(vec({1e200, 0})), "the energy of these impulses is beyond double precision");
  p.u_free *= 1e-165;
  EXPECT_EQ(refusal(vec({1e-165, 1e-165})),
            "the energy of these impulses is below double precision");
  p.u_free = vec({1e-165, 0});  // it opens without an impulse
  EXPECT_EQ(judge(p, vec({0, 0})).guarded(), 0);
}

TEST(ImpulseVerdict, NoContactsAreNoError) {
  ContactProblem p;
  const ImpulseVerdict v = judge(p, Vector());
  EXPECT_EQ(v.guarded(), 0);
  EXPECT_EQ(v.siconos_map, 0);
  EXPECT_TRUE(v.worst.empty());
}

}  // namespace
}  // namespace bipot
