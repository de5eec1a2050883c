// Detection, assembly, products with W and the criterion: the same bits for any number of threads.

#include "core/base/parallel.h"
#include "core/criterion/contact_error.h"
#include "core/criterion/extended_error.h"
#include "core/criterion/rounding_bound.h"
#include "core/motion/midpoint.h"
#include "core/motion/state.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"
#include "tests/support/bit_hash.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

Scene<2> packing() {
  FamilyOptions options{.e_n = 0.2, .e_t = 0.6, .tilt_degrees = 10};
  return make_family_scene("diluted", 100, options);
}

TEST(Threads, DetectAndAssembleTheSameBits) {
  const Scene<2> scene = packing();
  const State<2> state = initial_state(scene);
  const Midpoint<2> one = make_midpoint(scene, state);
  const ContactProblem p = assemble_step(scene, one).problem;
  ASSERT_GT(p.num_contacts(), 3 * kPieceItems);
  ASSERT_GT(state.bodies.size(), 4 * to_size(kPieceItems));  // sorted in four parts
  for (int threads = 2; threads <= 4; ++threads) {
    const Midpoint<2> many = make_midpoint(scene, state, threads);
    ASSERT_EQ(many.contacts.size(), one.contacts.size());
    for (std::size_t c = 0; c < one.contacts.size(); ++c) {
      ASSERT_EQ(many.contacts[c].i, one.contacts[c].i);
      ASSERT_EQ(many.contacts[c].j, one.contacts[c].j);
      ASSERT_EQ(many.contacts[c].n, one.contacts[c].n);
      ASSERT_EQ(many.contacts[c].gap, one.contacts[c].gap);
    }
    const ContactProblem q = assemble_step(scene, many, threads).problem;
    EXPECT_TRUE(same_bits(q.u_free, p.u_free));
    EXPECT_TRUE(same_bits(q.mu, p.mu));
    EXPECT_TRUE(same_bits(q.row_scale, p.row_scale));
    ASSERT_EQ(q.H.nonZeros(), p.H.nonZeros());
    EXPECT_EQ(SparseMatrix(q.H - p.H).norm(), 0);
  }
}

TEST(Threads, JudgeAndMultiplyTheSameBits) {
  const Scene<2> scene = packing();
  const ContactProblem p = assemble_step(scene, make_midpoint(scene, initial_state(scene))).problem;
  Vector s(p.num_rows());
  for (Eigen::Index k = 0; k < s.size(); ++k) {
    s[k] = 0.01 * (1 + std::sin(3.0 * static_cast<double>(k)));
  }
  Vector u, v;
  DelassusOperator(p).velocity(s, u);
  ContactErrorEvaluator one(p);
  const ContactError e = one(s);
  ASSERT_GT(e.epsilon, 0);
  for (int threads = 2; threads <= 4; ++threads) {
    DelassusOperator(p, DelassusOperator::Form::kAuto, threads).velocity(s, v);
    EXPECT_TRUE(same_bits(u, v));
    ContactErrorEvaluator many(p, threads);
    const ContactError f = many(s);
    EXPECT_EQ(f.epsilon, e.epsilon);
    EXPECT_EQ(f.eta, e.eta);
    EXPECT_EQ(f.raw42, e.raw42);
    EXPECT_EQ(f.natural_map, e.natural_map);
    EXPECT_EQ(f.energy, e.energy);
    EXPECT_EQ(f.worst_epsilon, e.worst_epsilon);
    EXPECT_EQ(f.worst_eta, e.worst_eta);
    EXPECT_TRUE(same_bits(many.velocity(), one.velocity()));
    EXPECT_EQ(extended_guarded_error(p, s, {}, threads), extended_guarded_error(p, s));
    EXPECT_EQ(quadruple_guarded_error(p, s, {}, threads), quadruple_guarded_error(p, s));
    EXPECT_EQ(rounded_sums(p, s, threads).natural.error, rounded_sums(p, s).natural.error);
    EXPECT_EQ(rounded_sums(p, s, threads).gap.error, rounded_sums(p, s).gap.error);
  }
}

}  // namespace
}  // namespace bipot
