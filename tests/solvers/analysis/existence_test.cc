#include "solvers/analysis/existence.h"

#include "solvers/analysis/certificate_check.h"
#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Frictionless contacts of one mass on a line: H = the given signs, A = 1.
ContactProblem on_a_line(const std::vector<double>& directions, const Vector& u_free) {
  ContactProblem p{.dim = 1};
  const int m = static_cast<int>(directions.size());
  p.A.resize(1, 1);
  p.A.insert(0, 0) = 1;
  p.H.resize(1, m);
  for (int c = 0; c < m; ++c) p.H.insert(0, c) = directions[to_size(c)];
  p.A.makeCompressed();
  p.H.makeCompressed();
  p.mu = Vector::Zero(m);
  p.u_free = u_free;
  p.v_free = Vector::Zero(1);
  return p;
}

Vector pair(double a, double b) {
  Vector x(2);
  x << a, b;
  return x;
}

/// A unit disk (m = 1, I = 1/2) in a wedge of two walls whose normals are (±sin a, cos a); w as
/// given.
ContactProblem disk_in_a_wedge(double a, double mu, const Vector& w) {
  ContactProblem p{.dim = 2};
  p.A.resize(3, 3);
  p.H.resize(3, 4);
  for (int k = 0; k < 3; ++k) p.A.insert(k, k) = k == 2 ? 0.5 : 1.0;
  for (int c = 0; c < 2; ++c) {
    const double nx = (c == 0 ? 1 : -1) * std::cos(a), ny = std::sin(a);
    p.H.insert(0, 2 * c) = nx;
    p.H.insert(1, 2 * c) = ny;
    p.H.insert(0, 2 * c + 1) = -ny;  // t = e3 x n
    p.H.insert(1, 2 * c + 1) = nx;
    p.H.insert(2, 2 * c + 1) = -1;
  }
  p.A.makeCompressed();
  p.H.makeCompressed();
  p.mu = Vector::Constant(2, mu);
  p.u_free = w;
  p.v_free = Vector::Zero(3);
  return p;
}

Vector four(double a, double b, double c, double d) {
  Vector x(4);
  x << a, b, c, d;
  return x;
}

TEST(Existence, AMassOnAFloorHasASolution) {
  // H = [1]: r = 0 is the only self-stress. v = 1 opens the contact, every term of a = H v is
  // positive, so that the margin is 1 but for the data's part.
  const ExistenceCertificate c = certify_existence(on_a_line({1}, Vector::Constant(1, -3.0)));
  EXPECT_EQ(c.verdict, Existence::kExists) << to_text(c);
  EXPECT_GT(c.margin, 0.0);
  EXPECT_LE(c.margin, 1.0);
}

TEST(Existence, WallsDrivenTogetherHaveNone) {
  // One mass between two walls that approach at 1 and 2 m/s: u = (v - 1, -v - 2), whose sum is -3.
  // r = (1, 1): H r = 0 exactly, r·w = -3, and -r·w / r·|w| = 1.
  const ContactProblem p = on_a_line({1, -1}, pair(-1, -2));
  const ExistenceCertificate c = certify_existence(p);
  EXPECT_EQ(c.verdict, Existence::kNone) << to_text(c);
  EXPECT_EQ(c.margin, 0.0);
  ASSERT_EQ(c.stress.size(), 2);
  EXPECT_EQ(c.stress[0], c.stress[1]);
  EXPECT_FALSE(is_success(solve("auto", p).status));
}

TEST(Existence, WallsDrivenApartHaveOne) {
  const ExistenceCertificate c = certify_existence(on_a_line({1, -1}, pair(2, -1)));
  EXPECT_EQ(c.verdict, Existence::kExists) << to_text(c);
  EXPECT_GT(c.weight, 0.0);  // without the data's part nothing opens both
}

TEST(Existence, AJammedMassWithFixedWallsHasOneUpToRounding) {
  // Gravity pushes a mass that touches both walls: w = (-1, 1) = Hᵀ v with v = -1. r = (1, 1) does
  // no work: v = 1 stops it exactly, any further approach has no solution.
  const ExistenceCertificate c = certify_existence(on_a_line({1, -1}, pair(-1, 1)));
  EXPECT_EQ(c.verdict, Existence::kExistsNearby) << to_text(c);
  EXPECT_LE(c.margin, 1e-15);
  EXPECT_EQ(certify_existence(on_a_line({1, -1}, pair(-1.001, 1))).verdict, Existence::kNone);
  EXPECT_EQ(certify_existence(on_a_line({1, -1}, pair(-0.999, 1))).verdict, Existence::kExists);
}

TEST(Existence, AWedgeThatHoldsByFrictionAloneHasNoneWhenItsWallsClose) {
  // The line through both points of contact is a line of forces inside both cones where
  // mu >= tan a: a self-stress of friction. Normals alone have none, since both point up.
  const double a = 0.2;
  const Vector closing = four(-1, 0, -1, 0);
  const ExistenceCertificate held =
      certify_existence(disk_in_a_wedge(a, 1.1 * std::tan(a), closing));
  // Both stick: then v = 0 but the walls move. Both slip outwards: with mu > tan a the impulses
  // point into the wedge, and so would the motion. One open: the other one's impulse does not open
  // it. So by cases.
  EXPECT_EQ(held.verdict, Existence::kNone) << to_text(held);
  EXPECT_GT(held.cases, 1);
  EXPECT_LT(held.margin, 1e-6);
  // Below that friction the disk is squeezed out: a solution for any walls.
  const ExistenceCertificate free =
      certify_existence(disk_in_a_wedge(a, 0.9 * std::tan(a), closing));
  EXPECT_EQ(free.verdict, Existence::kExists) << to_text(free);
  // Held in walls that stand: w = Hᵀ v of a fall.
  ContactProblem standing = disk_in_a_wedge(a, 1.1 * std::tan(a), closing);
  Vector fall(3);
  fall << 0, -1, 0;
  standing.u_free = standing.H.transpose() * fall;
  const ExistenceCertificate stands = certify_existence(standing);
  EXPECT_TRUE(stands.verdict == Existence::kExistsNearby || stands.verdict == Existence::kExists)
      << to_text(stands);
}

TEST(Existence, DoesNotDependOnTheForm) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    for (int dim = 1; dim <= 3; ++dim) {
      const ContactProblem p = manufactured_problem(dim, 3, 9, seed, 0.4).problem;
      const ExistenceCertificate global = certify_existence(p);
      const ExistenceCertificate local = certify_existence(local_form(p));
      EXPECT_EQ(global.verdict, local.verdict) << "d = " << dim << ", seed " << seed << ": "
                                               << to_text(global) << " / " << to_text(local);
    }
  }
}

TEST(Existence, NeverRefutesAPlantedSolutionAndSettlesMostProblems) {
  int exists = 0, all = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    for (int dim = 1; dim <= 3; ++dim) {
      // From loose to jammed: 1 to 8 contacts a body.
      const int bodies = 1 + static_cast<int>(seed % 4);
      const int contacts = bodies * (1 + static_cast<int>(seed % 8));
      const ContactProblem p = manufactured_problem(dim, bodies, contacts, seed, 0.5).problem;
      const ExistenceCertificate c = certify_existence(p);
      EXPECT_NE(c.verdict, Existence::kNone) << "d = " << dim << ", seed " << seed;
      exists += c.verdict == Existence::kExists || c.verdict == Existence::kExistsNearby;
      ++all;
    }
  }
  EXPECT_GT(exists, all / 2);
}

TEST(Existence, LemkeAgreesWithTheVerdictOnRandomProblems) {
  // In the plane Lemke's method ends on a solution wherever one must exist, and cannot where none
  // does.
  int none = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    ContactProblem p = manufactured_problem(1, 2, 7, seed, 0).problem;
    p.u_free = random_vector(p.u_free.size(), seed);
    const ExistenceCertificate c = certify_existence(p);
    const bool solved = is_success(solve("lemke", p, {.tol = 1e-9}).status);
    if (c.verdict == Existence::kNone) {
      ++none;
      EXPECT_FALSE(solved) << "seed " << seed << ": " << to_text(c);
    } else if (c.verdict == Existence::kExists) {
      EXPECT_TRUE(solved) << "seed " << seed << ": " << to_text(c);
    }
  }
  EXPECT_GT(none, 10);
}

TEST(Existence, AsymmetricAndIndefiniteDataAreUndecided) {
  ContactProblem p = local_form(manufactured_problem(2, 3, 6, 3, 0.3).problem);
  ContactProblem skew = p;
  skew.W.coeffRef(0, 1) += 1e-3 * skew.W.coeff(0, 0);
  EXPECT_EQ(certify_existence(skew).verdict, Existence::kUndecided);
  ContactProblem indefinite = p;
  indefinite.W.coeffRef(1, 1) = -1;
  EXPECT_EQ(certify_existence(indefinite).verdict, Existence::kUndecided);
}

TEST(Existence, ASearchEndsWhenItIsToldTo) {
  const ContactProblem p = manufactured_problem(3, 20, 60, 1, 0.5).problem;
  EXPECT_TRUE(says(certify_existence(p, 0).reason, "out of time, stopped after"));
  int questions = 0;
  const ExistenceCertificate c = certify_existence(p, kInfinity, [&] { return ++questions > 20; });
  EXPECT_EQ(c.verdict, Existence::kUndecided);
  EXPECT_TRUE(says(c.reason, "interrupted, stopped after"));
  EXPECT_LT(questions, 40);
}

TEST(CertificateCheck, RefusesWhatDoesNotHold) {
  const ContactProblem p = on_a_line({1, -1}, pair(-1, -2));
  // v = 5 opens the first contact and drives into the second.
  EXPECT_LT(opening_margin(p, Vector::Constant(1, 5.0), 0), 0);
  EXPECT_LT(opening_margin(p, Vector::Constant(1, kNaN), 0), 0);
  EXPECT_LT(opening_margin(p, Vector::Constant(1, 1.0), -1), 0);
  // r = (1, 0) is no self-stress: what is left, 1, stops any slow motion: speed 1 / |w| in energy.
  const Obstruction one = obstruction(p, pair(1, 0));
  EXPECT_NEAR(one.strength, 1, 1e-12);
  EXPECT_NEAR(one.speed, 1 / std::sqrt(5.0), 1e-12);
  EXPECT_FALSE(obstruction(p, pair(1, -1)).strength > 0);
  // A self-stress that works with the data obstructs nothing.
  EXPECT_FALSE(obstruction(on_a_line({1, -1}, pair(2, -1)), pair(1, 1)).strength > 0);
}

TEST(CertificateCheck, SeesWhatDoublePrecisionCannot) {
  // The terms 1, x and -1 leave x of a sum of absolutes 2. x = 2^-63 is within the rounding of 64
  // bits and 12 operations, 2^-59.4 of that sum: not taken for positive. x = 2^-55 is.
  const ContactProblem p =
      unit_masses(1, Eigen::Vector3d::Ones(), Vector::Zero(3), Vector::Zero(1));
  Vector y(3);
  y << 1, 0x1p-63, -1;
  EXPECT_LE(opening_margin(p, y, 0), 0);
  y << 1, 0x1p-55, -1;
  EXPECT_GT(opening_margin(p, y, 0), 0);
}

}  // namespace
}  // namespace bipot
