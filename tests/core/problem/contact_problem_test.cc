#include "core/problem/contact_problem.h"

#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

ContactProblem sound() { return manufactured_problem(2, 4, 5, 1).problem; }

ContactProblem local_only() {
  ContactProblem p = sound();
  p.A = p.H = SparseMatrix();
  p.v_free = Vector();
  return p;
}

/// What `spoil` breaks in a problem is told by a message that holds every one of `parts`.
void expect_refused(const std::function<void(ContactProblem&)>& spoil,
                    std::initializer_list<const char*> parts, ContactProblem p = sound()) {
  spoil(p);
  for (const char* part : parts) EXPECT_TRUE(says(validate(p), part));
}

/// One scale of the ten rows of sound().
void set_row_scale(ContactProblem& p, int row, double value) {
  p.row_scale = Vector::Ones(10);
  p.row_scale[row] = value;
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
  expect_refused([](auto& p) { p.dim = 4; }, {"dim = 4"});
  expect_refused([](auto& p) { p.dim = 0; }, {"dim = 0"});
  expect_refused([](auto& p) { p.u_free.conservativeResize(9); }, {"u_free", "9", "10"});
  expect_refused([](auto& p) { p.mu.conservativeResize(4); }, {"u_free", "10", "8"});
  expect_refused([](auto& p) { p.v_free.conservativeResize(11); }, {"v_free", "11", "12"});
  expect_refused([](auto& p) { p.H.conservativeResize(12, 8); }, {"H (columns)", "8", "10"});
  expect_refused(
      [](auto& p) {
        p.H.conservativeResize(9, 10);
        p.v_free.conservativeResize(9);
      },
      {"A (rows)", "12", "9"});
  expect_refused([](auto& p) { p.A.conservativeResize(12, 11); }, {"A (columns)", "11", "12"});
  expect_refused([](auto& p) { p.W.conservativeResize(9, 10); }, {"W (rows)", "9", "10"});
  expect_refused([](auto& p) { p.W.conservativeResize(10, 9); }, {"W (columns)", "9", "10"});
  expect_refused([](auto& p) { p.row_scale = Vector::Ones(3); }, {"row_scale", "3", "10"});
  expect_refused([](auto& p) { p.W = SparseRows(); }, {"neither W nor (A, H)"}, local_only());
}

TEST(Validate, RefusesOneNonFiniteValueAtATime) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    expect_refused([&](auto& p) { p.u_free[3] = bad; }, {"u_free[3]", "not finite"});
    expect_refused([&](auto& p) { p.v_free[7] = bad; }, {"v_free[7]", "not finite"});
    expect_refused([&](auto& p) { p.mu[2] = bad; }, {"mu[2]", "not finite"});
    expect_refused([&](auto& p) { p.A.coeffRef(5, 5) = bad; }, {"A(5, 5)", "not finite"});
    expect_refused([&](auto& p) { SparseMatrix::InnerIterator(p.H, 4).valueRef() = bad; },
                   {"H(", ", 4)", "not finite"});
    expect_refused([&](auto& p) { p.W.coeffRef(2, 3) = bad; }, {"W(2, 3)", "not finite"});
    expect_refused([&](auto& p) { set_row_scale(p, 9, bad); }, {"row_scale[9]", "not finite"});
  }
}

TEST(Validate, RefusesAMassWhoseMobilityIsNotFinite) {
  expect_refused(
      [](auto& p) {
        p.W = SparseRows();
        for (int i = 0; i < p.A.rows(); ++i) p.A.coeffRef(i, i) = 1e-310;
      },
      {"W_nn of contact 0", "beyond the largest number", "1e-310"});
}

TEST(Validate, RefusesValuesOutOfRange) {
  expect_refused([](auto& p) { p.mu[1] = -0.25; }, {"mu[1] = -0.25", "negative"});
  for (const double bad : {0.0, -2.0}) {
    expect_refused([&](auto& p) { p.A.coeffRef(4, 4) = bad; }, {"A(4, 4)", "not positive"});
    expect_refused([&](auto& p) { set_row_scale(p, 6, bad); }, {"row_scale[6]", "not positive"});
    expect_refused([&](auto& p) { p.W.coeffRef(4, 4) = bad; },
                   {"W_nn of contact 2", "not positive"}, local_only());
  }
}

TEST(Validate, RefusesAnUnsymmetricMassMatrix) {
  ContactProblem p = sound();
  p.A.coeffRef(1, 2) = 0.1;
  EXPECT_TRUE(says(validate(p), "A is not symmetric"));
  p.A.coeffRef(2, 1) = 0.1;
  EXPECT_EQ(validate(p), "");
  // Judged against the two diagonal entries, not the largest one: kg and kg m² stand side by side.
  p.A.coeffRef(5, 5) = 1e12;
  p.A.coeffRef(2, 1) = 0.2;
  EXPECT_TRUE(says(validate(p), "A is not symmetric"));
}

TEST(Validate, RefusesAContactWithoutAFreeBody) {
  expect_refused(
      [](auto& p) {
        p.W = SparseRows();
        for (SparseMatrix::InnerIterator it(p.H, 6); it; ++it) it.valueRef() = 0;
      },
      {"contact 3", "no free body"});
}

TEST(Validate, RefusesTangentsThatAreScaledDifferently) {
  // Coulomb's law is homogeneous in the tangential part as a whole only.
  ContactProblem p = manufactured_problem(3, 4, 5, 1).problem;
  p.row_scale = Vector::Ones(15);
  p.row_scale[8] = 1.1;
  expect_refused([](auto&) {}, {"row_scale", "contact 2"}, p);
  p.row_scale[7] = 1.1;
  EXPECT_EQ(validate(p), "");
}

TEST(Validate, RefusesAnUncompressedOperator) {
  // The sweeps walk through its arrays.
  expect_refused([](auto& p) { p.W.uncompress(); }, {"W", "compressed"});
}

}  // namespace
}  // namespace bipot
