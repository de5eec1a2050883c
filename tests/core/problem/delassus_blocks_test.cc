#include "core/problem/delassus_blocks.h"

#include "core/problem/delassus.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(DelassusBlocks, MultiplyAsTheMatrixDoes) {
  for (const int dim : {1, 2, 3, 6}) {
    // Single entries: the rows of a contact differ in their columns.
    SparseRows W(4 * dim, 4 * dim);
    for (int row = 0; row < 4 * dim; ++row) {
      for (int column = 0; column < 4 * dim; ++column) {
        if ((3 * row + 5 * column) % 7 < 3) W.insert(row, column) = 1 + row - 0.5 * column;
      }
    }
    W.makeCompressed();
    const Vector s = random_vector(4 * dim, 1), expected = W * s;
    const DelassusBlocks blocks(W, dim);
    Vector u;
    blocks.apply(s, u);
    EXPECT_LT((u - expected).norm(), 1e-14 * expected.norm()) << dim;
  }
}

TEST(DelassusBlocks, ServeAContactAlone) {
  const ContactProblem p = cubic_lattice(2);
  const SparseRows W = assemble_delassus(p.A, p.H, 3);
  const DelassusBlocks blocks(W, 3);
  const Vector s = random_vector(p.num_rows(), 2), expected = W * s;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<3> u = blocks.product<3>(c, s.data());
    EXPECT_LT((u - expected.segment<3>(3 * c)).norm(), 1e-14 * expected.norm()) << c;
  }
}

}  // namespace
}  // namespace bipot
