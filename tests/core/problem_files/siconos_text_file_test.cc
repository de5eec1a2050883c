#include "core/problem_files/siconos_text_file.h"

#include "core/base/file_error.h"
#include "core/problem_files/problem_file.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

using Eigen::MatrixXd;

class SiconosText : public testing::Test {
 protected:
  ProblemFile read(const std::string& text) {
    std::ofstream(path()) << text;
    return read_problem(path(), true);
  }
  std::string refusal(const std::string& text) {
    return refusal_of<FileError>([&] { read(text); });
  }
  void expect_refusal(const std::string& text, const char* reason) {
    const std::string message = refusal(text);
    EXPECT_TRUE(says(message, path().string()));
    EXPECT_TRUE(says(message, reason));
  }
  fs::path path() const { return folder_ / "problem.dat"; }

  TemporaryFolder folder_;
};

// Unsymmetric on purpose: 5 1 0 0 | 3 6 0 0 | 0 0 7 2 | 0 0 0 8.
MatrixXd expected_matrix() {
  MatrixXd W(4, 4);
  W << 5, 1, 0, 0, 3, 6, 0, 0, 0, 0, 7, 2, 0, 0, 0, 8;
  return W;
}
const std::string kVectors = " -1.5e+00 2.5D-01  -3 0 \n 5.0e-01 0.25 \n";

TEST_F(SiconosText, DenseMatricesStandColumnByColumn) {
  const ProblemFile file = read(
      "\xEF\xBB\xBF"
      "2\n2\n0\n4\n4\n4\t4\n 5.0 3 0 0 \n 1 6e0 0 0\n 0 0 +7 0 \n 0 0 2 8 \n" +
      kVectors);
  EXPECT_FALSE(file.global);
  EXPECT_EQ(file.problem.dim, 2);
  EXPECT_EQ(MatrixXd(file.problem.W), expected_matrix());
  EXPECT_EQ(file.problem.W.nonZeros(), 7);
  EXPECT_EQ(file.problem.u_free, Eigen::Vector4d(-1.5, 0.25, -3, 0));
  EXPECT_EQ(file.problem.mu, Eigen::Vector2d(0.5, 0.25));
  EXPECT_EQ(file.info.title, "problem.dat");
}

TEST_F(SiconosText, BlocksStandColumnByColumn) {
  const std::string blocks = "2\n2\n2\n2\t4\t\n2\t4\t\n3\n2\n0\t1\t2\t\n0\t1\t\n";
  const ProblemFile file =
      read("2\n2\n1\n4\n4\n" + blocks + "0\n 5\n 3\n 1\n 6\n1\n 7\n 0\n 2\n 8\n" + kVectors);
  EXPECT_EQ(MatrixXd(file.problem.W), expected_matrix());
}

const std::string kCSparse = "CSparse Version 3.1.9, May 4, 2016.  Copyright (c) ...\n";

TEST_F(SiconosText, SparseMatricesByColumnsByRowsAndAsTriplets) {
  const std::string head = "2\n2\n2\n4\n4\n";
  const std::string size = "4-by-4, nzmax: 9 nnz: 7, 1-norm: 10\n";
  EXPECT_EQ(MatrixXd(read(head + "2\n" + kCSparse + size +
                          "    col 0 : locations 0 to 1\n      1 : 3\n      0 : 5\n"
                          "    col 1 : locations 2 to 3\n      0 : 1\n      1 : 6\n"
                          "    col 2 : locations 4 to 4\n      2 : 7\n"
                          "    col 3 : locations 5 to 6\n      2 : 2\n      3 : 8\n" +
                          kVectors)
                         .problem.W),
            expected_matrix());
  EXPECT_EQ(MatrixXd(read(head + "3\n" + kCSparse + "csr: " + size +
                          "    row 0 : locations 0 to 1\n      0 : 5\n      1 : 1\n"
                          "    row 1 : locations 2 to 3\n      0 : 3\n      1 : 6\n"
                          "    row 2 : locations 4 to 5\n      3 : 2\n      2 : 7\n"
                          "    row 3 : locations 6 to 6\n      3 : 8\n" +
                          kVectors)
                         .problem.W),
            expected_matrix());
  EXPECT_EQ(MatrixXd(read(head + "1\n" + kCSparse + "triplet: 4-by-4, nzmax: 9 nnz: 8\n" +
                          "    0 0 : 4\n    1 0 : 3\n    0 1 : 1\n    1 1 : 6\n    2 2 : 7\n"
                          "    2 3 : 2\n    3 3 : 8\n    0 0 : 1\n" +
                          kVectors)
                         .problem.W),
            expected_matrix());
}

TEST_F(SiconosText, AnEmptyColumnHasNoLocations) {
  // M = I as triplets, H of two columns; f = (1, 2), w = (3, 4): u_free = Hᵀ f + w.
  const ProblemFile file = read(
      "2\n1\n2\n2\n2\n1\n" + kCSparse + "triplet: 2-by-2, nzmax: 2 nnz: 2\n 0 0 : 1\n 1 1 : 1\n" +
      "2\n2\n2\n2\n" + kCSparse + "2-by-2, nzmax: 1 nnz: 1, 1-norm: 2\n" +
      "    col 0 : locations 0 to 0\n      1 : 2\n    col 1 : locations 1 to 0\n" +
      "1 2\n3 4\n0.5\n");
  EXPECT_TRUE(file.global);
  EXPECT_EQ(file.problem.u_free, Eigen::Vector2d(7, 4));
}

TEST_F(SiconosText, GlobalProblemsAreToldFromLocalOnes) {
  // The smallest there is: n = m = 2. M = diag(2, 4), H = I, f = (2, 8), w = (-9, 0.5).
  const std::string M = "0\n2\n2\n2\t2\n2 0\n0 4\n", H = "0\n2\n2\n2\t2\n1 0\n0 1\n";
  for (const char* flag : {"", "0\n"}) {
    const ProblemFile file = read("2\n1\n" + M + H + "2 8\n-9 0.5\n0.3\n" + flag);
    EXPECT_TRUE(file.global);
    EXPECT_EQ(file.problem.v_free, Eigen::Vector2d(1, 2));
    EXPECT_EQ(file.problem.u_free, Eigen::Vector2d(-8, 2.5));
    EXPECT_FALSE(file.problem.has_delassus());
    EXPECT_FALSE(read("2\n1\n" + M + "2 8\n0.3\n" + flag).global);
  }
}

TEST_F(SiconosText, JointsOfAMechanicalProblemAreEliminated) {
  // R = 2, V = (1/2, 0, 0), s = 1, W = 1, q = (-1, 1/2, 0): λ = -(s_n/2 + 1)/2, W_nn = 1 - 1/8, q_n =
  // -1 - 1/4. The joint stands before the contact.
  const std::string text =
      "1\n4\n4\n4\n2\n2\n1 4\n1 4\n3\n4\n0 2 4\n0 1 0 1\n0\n2\n1\n0.5 0 0\n2\n0.5 0 0\n3\n"
      "1 0 0 0 1 0 0 0 1\n1 -1 0.5 0\n";
  const ProblemFile file = read(text + "2\n4\n0.2\n");
  EXPECT_FALSE(file.global);
  EXPECT_EQ(file.problem.dim, 3);
  EXPECT_LE((file.problem.u_free - Eigen::Vector3d(-1.25, 0.5, 0)).norm(), 1e-15);
  EXPECT_NEAR(file.problem.W.coeff(0, 0), 0.875, 1e-15);
  EXPECT_EQ(file.problem.W.coeff(1, 1), 1);
  EXPECT_EQ(file.problem.mu[0], 0.2);
  expect_refusal(text + "2\n3\n", "sub-problem 1 is of type 3 and size 3");
}

TEST_F(SiconosText, AProblemWithoutContactsIsRead) {
  const ProblemFile file = read("2\n0\n0\n2\n2\n2\t2\n2 0\n0 4\n0\n2\n0\n2\t0\n1 2\n");
  EXPECT_EQ(file.problem.num_contacts(), 0);
  EXPECT_EQ(file.problem.v_free, Eigen::Vector2d(0.5, 0.5));
}

TEST_F(SiconosText, DefectsAreRefusedWithLineAndReason) {
  expect_refusal("", "line 1: the file ends where contact dimension should stand");
  expect_refusal("5\n1\n", "contact dimension 5 is neither 2 nor 3");
  expect_refusal("\x1F\x8B\x08", "gunzip it first");
  expect_refusal("two\n", "'two' is not an integer");
  // Another kind of problem: n, storage, n, n; and storage, n, n, blocks with joints.
  expect_refusal("4\n0\n4\n4\n4\t4\n", "linear complementarity problem (LCP) of 4 rows");
  expect_refusal("3\n1\n3\n3\n", "linear complementarity problem (LCP) of 3 rows");
  // A mechanical problem with a relay; with its matrix dense.
  expect_refusal("1\n1\n1\n1\n1\n1\n1\n1\n2\n1\n0 1\n0\n0\n2\n0.5\n9\n",
                 "sub-problem 0 is of type 9 and size 1; taken are equality rows (joints, type 2)");
  expect_refusal("0\n1\n1\n1\t1\n2\n0\n2\n", "needs its matrix in blocks (storage 1)");
  expect_refusal("2\n-1\n", "number of contacts = -1 is too small");
  expect_refusal("2\n1\n7\n2\n2\n", "line 5: matrix storage 7");
  expect_refusal("2\n1\n0\n2\n2\n2\t2\n1 0\n0 x\n", "line 8: matrix entry: 'x' is not a number");
  expect_refusal("2\n1\n0\n2\n2\n3\t3\n1 0\n0 1\n", "3 x 3, its header says 2 x 2");
  expect_refusal("2\n1\n0\n2\n2\n2\t2\n1 0\n0 1\n1 2\n", "2 numbers after the matrix");
  expect_refusal("2\n1\n0\n2\n2\n2\t2\n1 0\n0 1\n1 nan\n0.5\n", "line 9: q = nan is not finite");
  expect_refusal("2\n1\n0\n2\n2\n2\t2\n1 0\n0 1\n1 1e999\n0.5\n", "line 9: q = inf");
  expect_refusal("2\n1\n0\n3\n3\n3\t3\n1 0 0\n0 1 0\n 0 0 1\n1 1\n0.5\n", "rows of W is 3");
  expect_refusal("2\n900000000\n0\n2\n2\n2\t2\n1 0\n0 1\n", "more than the file can hold");
  expect_refusal("2\n1\n1\n2\n900000000\n0\n1 1\n0.5\n", "columns of a matrix: more than the file");
  expect_refusal("2\n1\n1\n2\n2\n1\n1\n1\n2\n2\n2\n1\n0\t1\n1\n0 1 0 0 1\n1 1\n0.5\n",
                 "block 0 is in column 1 of 1");
  expect_refusal("2\n1\n1\n2\n2\n1\n1\n1\n3\n2\n2\n1\n0\t1\n0\n0 1 0 0 1\n1 1\n0.5\n",
                 "block extents do not increase to 2");
  expect_refusal("2\n1\n2\n2\n2\n1\n" + kCSparse + "triplet: 2-by-2, nzmax: 2 nnz: 2\n 0 0 : 1\n" +
                     " 2 1 : 1\n1 1\n0.5\n",
                 "entry (2, 1) of a 2 x 2 matrix");
  expect_refusal("2\n1\n2\n2\n2\n2\n" + kCSparse + "3-by-3, nzmax: 2 nnz: 2, 1-norm: 2\n",
                 "should begin with '2-by-2,'");
  expect_refusal("2\n1\n2\n2\n2\n4\n" + kCSparse, "half-stored symmetric");
  expect_refusal("2\n1\n2\n2\n2\n2\n" + kCSparse + "2-by-2, nzmax: 2 nnz: 9, 1-norm: 2\n" +
                     "    col 0 : locations 0 to 0\n      0 : 1\n" +
                     "    col 1 : locations 1 to 1\n      1 : 1\n1 1\n0.5\n",
                 "2 entries, the header says 9");
}

TEST_F(SiconosText, MissingFilesAndFoldersAreRefused) {
  EXPECT_THROW(read_problem(folder_ / "none.dat"), FileError);
  EXPECT_THROW(read_problem(folder_.path()), FileError);
}

TEST_F(SiconosText, UnderflowIsNought) {
  const ProblemFile file = read("2\n1\n0\n2\n2\n2\t2\n1 0\n0 1\n1e-400 -1\n0.5\n");
  EXPECT_EQ(file.problem.u_free, Eigen::Vector2d(0, -1));
}

}  // namespace
}  // namespace bipot
