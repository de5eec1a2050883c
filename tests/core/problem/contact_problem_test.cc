#include "core/problem/contact_problem.h"

#include <gtest/gtest.h>

#include "core/base/types.h"
#include "tests/support/manufactured.h"
#include "tests/support/refusal.h"

namespace bipot {
namespace {

ContactProblem sound() { return manufactured_problem(2, 4, 5, 1).problem; }

ContactProblem local_only() {
  ContactProblem p = sound();
  p.A = p.H = SparseMatrix();
  p.v_free = Vector();
  return p;
}

/// Each case breaks one thing; the message must hold every one of `parts`.
void expect_refused(const ContactProblem& p, std::initializer_list<const char*> parts) {
  const std::string message = validate(p);
  for (const char* part : parts) {
    EXPECT_TRUE(says(message, part)) << '\'' << message << "' lacks " << part;
  }
}

TEST(Validate, AcceptsSoundProblems) {
  EXPECT_EQ(validate(sound()), "");
  EXPECT_EQ(validate(local_only()), "");
  ContactProblem without_w = sound();
  without_w.W = SparseRows();
  EXPECT_EQ(validate(without_w), "");
  EXPECT_EQ(validate(ContactProblem{}), "");  // no contacts
  ContactProblem scaled = sound();
  scaled.row_scale = Vector::Constant(10, 1.2);
  EXPECT_EQ(validate(scaled), "");
}

TEST(Validate, AcceptsAnUnsymmetricOperator) {
  ContactProblem p = local_only();
  p.W.coeffRef(0, 1) *= 1.001;
  EXPECT_EQ(validate(p), "");
}

TEST(Validate, RefusesOneWrongSizeAtATime) {
  ContactProblem p = sound();
  p.dim = 4;
  expect_refused(p, {"dim = 4"});
  p = sound();
  p.dim = 0;
  expect_refused(p, {"dim = 0"});
  p = sound();
  p.u_free.conservativeResize(9);
  expect_refused(p, {"u_free", "9", "10"});
  p = sound();
  p.mu.conservativeResize(4);
  expect_refused(p, {"u_free", "10", "8"});
  p = sound();
  p.v_free.conservativeResize(11);
  expect_refused(p, {"v_free", "11", "12"});
  p = sound();
  p.H.conservativeResize(12, 8);
  expect_refused(p, {"H (columns)", "8", "10"});
  p = sound();
  p.H.conservativeResize(9, 10);
  p.v_free.conservativeResize(9);
  expect_refused(p, {"A (rows)", "12", "9"});
  p = sound();
  p.A.conservativeResize(12, 11);
  expect_refused(p, {"A (columns)", "11", "12"});
  p = sound();
  p.W.conservativeResize(9, 10);
  expect_refused(p, {"W (rows)", "9", "10"});
  p = sound();
  p.W.conservativeResize(10, 9);
  expect_refused(p, {"W (columns)", "9", "10"});
  p = sound();
  p.row_scale = Vector::Ones(3);
  expect_refused(p, {"row_scale", "3", "10"});
  p = local_only();
  p.W = SparseRows();
  expect_refused(p, {"neither W nor (A, H)"});
}

TEST(Validate, RefusesOneNonFiniteValueAtATime) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    ContactProblem p = sound();
    p.u_free[3] = bad;
    expect_refused(p, {"u_free[3]", "not finite"});
    p = sound();
    p.v_free[7] = bad;
    expect_refused(p, {"v_free[7]", "not finite"});
    p = sound();
    p.mu[2] = bad;
    expect_refused(p, {"mu[2]", "not finite"});
    p = sound();
    p.A.coeffRef(5, 5) = bad;
    expect_refused(p, {"A(5, 5)", "not finite"});
    p = sound();
    SparseMatrix::InnerIterator(p.H, 4).valueRef() = bad;
    expect_refused(p, {"H(", ", 4)", "not finite"});
    p = sound();
    p.W.coeffRef(2, 3) = bad;
    expect_refused(p, {"W(2, 3)", "not finite"});
    p = sound();
    p.row_scale = Vector::Ones(10);
    p.row_scale[9] = bad;
    expect_refused(p, {"row_scale[9]", "not finite"});
  }
}

TEST(Validate, RefusesAMassWhoseMobilityIsNotFinite) {
  ContactProblem p = sound();
  p.W = SparseRows();
  for (int i = 0; i < p.A.rows(); ++i) p.A.coeffRef(i, i) = 1e-310;
  expect_refused(p, {"W_nn of contact 0", "beyond the largest number", "1e-310"});
}

TEST(Validate, RefusesValuesOutOfRange) {
  ContactProblem p = sound();
  p.mu[1] = -0.25;
  expect_refused(p, {"mu[1] = -0.25", "negative"});
  for (const double bad : {0.0, -2.0}) {
    p = sound();
    p.A.coeffRef(4, 4) = bad;
    expect_refused(p, {"A(4, 4)", "not positive"});
    p = sound();
    p.row_scale = Vector::Ones(10);
    p.row_scale[6] = bad;
    expect_refused(p, {"row_scale[6]", "not positive"});
    p = local_only();
    p.W.coeffRef(4, 4) = bad;
    expect_refused(p, {"W_nn of contact 2", "not positive"});
  }
}

TEST(Validate, RefusesAnUnsymmetricMassMatrix) {
  ContactProblem p = sound();
  p.A.coeffRef(1, 2) = 0.1;
  expect_refused(p, {"A is not symmetric"});
  p.A.coeffRef(2, 1) = 0.1;
  EXPECT_EQ(validate(p), "");
  // Judged against the two diagonal entries, not the largest one: kg and kg m² stand side by side.
  p.A.coeffRef(5, 5) = 1e12;
  p.A.coeffRef(2, 1) = 0.2;
  expect_refused(p, {"A is not symmetric"});
}

TEST(Validate, RefusesAContactWithoutAFreeBody) {
  ContactProblem p = sound();
  p.W = SparseRows();
  for (SparseMatrix::InnerIterator it(p.H, 6); it; ++it) it.valueRef() = 0;
  expect_refused(p, {"contact 3", "no free body"});
}

TEST(Validate, RefusesTangentsThatAreScaledDifferently) {
  // Coulomb's law is homogeneous in the tangential part as a whole only.
  ContactProblem p = manufactured_problem(3, 4, 5, 1).problem;
  p.row_scale = Vector::Ones(15);
  p.row_scale[8] = 1.1;
  expect_refused(p, {"row_scale", "contact 2"});
  p.row_scale[7] = 1.1;
  EXPECT_EQ(validate(p), "");
}

TEST(Validate, RefusesAnUncompressedOperator) {
  // The sweeps walk through its arrays.
  ContactProblem p = sound();
  p.W.uncompress();
  expect_refused(p, {"W", "compressed"});
}

}  // namespace
}  // namespace bipot
