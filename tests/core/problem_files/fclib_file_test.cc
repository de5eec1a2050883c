#include "core/problem_files/fclib_file.h"

#include "core/base/file_error.h"
#include "core/criterion/contact_error.h"
#include "core/files/hdf5_file.h"
#include "core/problem/delassus.h"
#include "core/problem/equality_rows.h"
#include "core/problem_files/problem_file.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

#ifdef BIPOT_TESTS_WITH_FCLIB
extern "C" {  // the header does not say so itself
#include <fclib.h>
}
#endif

namespace bipot {
namespace {

using Mode = Hdf5File::Mode;
using Eigen::MatrixXd;

const ProblemInfo kInfo = {"box of disks", "step 12 of a test", "W is singular"};

MatrixXd dense_delassus(const ContactProblem& p) {
  const int m = p.num_rows();
  MatrixXd W(m, m);
  const DelassusOperator apply(p);
  Vector column;
  for (int k = 0; k < m; ++k) {
    apply.apply(Vector::Unit(m, k), column);
    W.col(k) = column;
  }
  return W;
}

/// The message of the refusal, or a text that no test expects.
std::string refusal(const fs::path& path) {
  return refusal_of<FileError>([&] { read_problem(path, true); });
}

/// A sparse matrix as FCLIB stores it; `nz` says by rows, columns or triplets.
void write_matrix(Hdf5File& file, const std::string& group, int rows, int columns, int nz,
                  const std::vector<int>& p, const std::vector<int>& i,
                  const std::vector<double>& x) {
  file.write(group + "/m", rows);
  file.write(group + "/n", columns);
  file.write(group + "/nz", nz);
  file.write(group + "/p", p);
  file.write(group + "/i", i);
  file.write(group + "/x", x);
}

struct RoundTrip : testing::TestWithParam<int> {
  const TemporaryFolder folder;
  const fs::path path = folder / "p.hdf5";

  ProblemFile read_back(const ContactProblem& p, const Vector& s, const Vector& u,
                        const std::vector<Vector>& guesses = {}) const {
    write_fclib(path, p, kInfo, guesses);
    write_fclib_solution(path, s, u);
    return read_problem(path);
  }
};

TEST_P(RoundTrip, LocalProblemsComeBackBitForBit) {
  const Manufactured m = manufactured_problem(GetParam(), 9, 14, 3);
  const ContactProblem p = local_form(m.problem);
  const ProblemFile file = read_back(p, m.s, m.u);
  EXPECT_FALSE(file.global);
  EXPECT_EQ(file.problem.dim, p.dim);
  EXPECT_EQ(MatrixXd(file.problem.W), MatrixXd(p.W));
  EXPECT_EQ(file.problem.u_free, p.u_free);
  EXPECT_EQ(file.problem.mu, p.mu);
  EXPECT_EQ(file.problem.row_scale.size(), 0);
  EXPECT_EQ(*file.r, m.s);
  EXPECT_EQ(*file.u, m.u);
  EXPECT_FALSE(file.v.has_value());
  EXPECT_EQ(file.info.title, kInfo.title);
  EXPECT_EQ(file.info.description, kInfo.description);
  EXPECT_EQ(file.info.math_info, kInfo.math_info);
}

TEST_P(RoundTrip, GlobalProblemsComeBackToRounding) {
  Manufactured m = manufactured_problem(GetParam(), 9, 14, 3);
  ContactProblem& p = m.problem;
  p.v_free = Vector::LinSpaced(p.num_dofs(), -1, 2);  // f = A v_free, w = u_free - Hᵀ v_free
  const ProblemFile file = read_back(p, m.s, m.u);
  EXPECT_TRUE(file.global);
  EXPECT_EQ(file.problem.dim, p.dim);
  EXPECT_EQ(MatrixXd(file.problem.A), MatrixXd(p.A));
  EXPECT_EQ(MatrixXd(file.problem.H), MatrixXd(p.H));
  EXPECT_FALSE(file.problem.has_delassus());  // A is diagonal
  EXPECT_LT((file.problem.v_free - p.v_free).norm(), 1e-15 * p.v_free.norm());
  EXPECT_LT((file.problem.u_free - p.u_free).norm(), 1e-14 * p.u_free.norm());
  EXPECT_EQ(file.problem.mu, p.mu);
  EXPECT_EQ(*file.r, m.s);
  EXPECT_EQ(*file.u, m.u);
  ASSERT_TRUE(file.v.has_value());
  EXPECT_LT((*file.v - body_velocities(p, m.s)).norm(), 1e-14 * file.v->norm());
  EXPECT_LT(contact_error(file.problem, *file.r).guarded(), 1e-12);
}

TEST(EqualityRowsFile, LenientRowsComeBack) {
  const TemporaryFolder folder;
  ContactProblem p{.dim = 1, .v_free = Eigen::Vector2d(-1, -2), .mu = Vector::Zero(2)};
  p.A = p.H = Eigen::MatrixXd::Identity(2, 2).sparseView();
  p.u_free = p.v_free;
  // They contradict each other and block contact 0.
  const Eigen::MatrixXd G = (Eigen::MatrixXd(2, 2) << 1, 0, 1, 0).finished();
  p = with_equality_rows(p, G.sparseView(), Eigen::Vector2d(3, 4), true);
  write_fclib(folder / "p.hdf5", p, {});
  EXPECT_EQ(read_fclib(folder / "p.hdf5").problem.u_free, p.u_free);
}

TEST_P(RoundTrip, EqualityRowsComeBackWithVelocitiesAndMultipliers) {
  const ManufacturedJoints m = manufactured_joints(GetParam(), 9, 14, 3);
  const EqualityRows& rows = *m.problem.equality;
  const ProblemFile file = read_back(m.problem, m.s, m.u, {m.s});
  ASSERT_TRUE(file.problem.equality);
  EXPECT_EQ(MatrixXd(file.problem.equality->G), MatrixXd(rows.G));
  EXPECT_EQ(file.problem.equality->b, rows.b);
  EXPECT_EQ(MatrixXd(file.problem.equality->given.H), MatrixXd(rows.given.H));
  EXPECT_LT((file.problem.u_free - m.problem.u_free).norm(), 1e-13 * m.u.norm());
  EXPECT_LT(contact_error(file.problem, *file.r).guarded(), 1e-11);
  EXPECT_EQ(*file.r, m.s);
  EXPECT_EQ(file.guesses.at(0), m.s);
  EXPECT_LT((*file.v - m.v).norm(), 1e-12 * m.v.norm());
  // In the file's signs: Gᵀ v + b = 0, M v = H r + G λ + f.
  const Hdf5File raw(path, Mode::kRead);
  const auto vector = [&](const std::string& name) {
    const std::vector<double> x = raw.read_doubles(name);
    return Vector(Eigen::Map<const Vector>(x.data(), static_cast<Eigen::Index>(x.size())));
  };
  const int n = rows.given.num_dofs();
  const Vector v = vector("/solution/v").head(n), l = vector("/solution/l");
  EXPECT_LT((rows.G * v + vector("/fclib_global/vectors/b")).norm(), 1e-12 * m.v.norm());
  EXPECT_LT((l - m.multipliers).norm(), 1e-10 * l.norm());
  const Vector impulse = rows.given.A * v - rows.given.H * m.s - rows.G.transpose() * l;
  EXPECT_LT((impulse - vector("/fclib_global/vectors/f").head(n)).norm(), 1e-10 * m.v.norm());
  EXPECT_EQ(raw.read_int("/fclib_global/G/n"), l.size());
}

TEST_P(RoundTrip, TheRowScaleOfRestitutionIsKept) {
  ContactProblem p = manufactured_problem(GetParam(), 9, 14, 3).problem;
  p.row_scale = Vector::LinSpaced(p.num_rows(), 1, 1.4);
  for (int row = 2; p.dim == 3 && row < p.num_rows(); row += 3) {
    p.row_scale[row] = p.row_scale[row - 1];  // one scale for both tangents
  }
  for (const ContactProblem& form : {p, local_form(p)}) {
    write_fclib(path, form, kInfo);
    EXPECT_EQ(read_problem(path).problem.row_scale, p.row_scale);
  }
}

INSTANTIATE_TEST_SUITE_P(Dimensions, RoundTrip, testing::Values(1, 2, 3));

struct FclibFile : testing::Test {
  const TemporaryFolder folder;
};

TEST_F(FclibFile, AFilterThatIsMissingIsNamed) {
  const fs::path path = source_folder() / "data/fuzz/hdf5/unknown_filter.hdf5";
  const std::string message = refusal_of<FileError>([&] { read_problem(path); });
  EXPECT_TRUE(says(message, "/fclib_local/W/x: is packed by the filter 511 'own'")) << message;
}

TEST_F(FclibFile, ADatasetThatClaimsMoreThanTheFileHoldsIsRefusedBeforeAllocation) {
  // Found by tests/fuzz/hdf5_fuzz.cc: a header whose extent is 8e14 values in a file of 16 kB.
  const fs::path path = source_folder() / "data/fuzz/hdf5/claims_many_values.hdf5";
  const std::string said = refusal_of<FileError>([&] { read_fclib(path); });
  EXPECT_TRUE(says(said, "more than a file of 15896 bytes can hold"));
  EXPECT_TRUE(says(said, "/fclib_"));
}

TEST_F(FclibFile, FrictionlessProblemsAreSoundFor2dReaders) {
  // Without the group /bipot the file is the two-dimensional problem that others see.
  const Manufactured m = manufactured_problem(1, 9, 14, 5);
  for (const bool global : {false, true}) {
    const auto path = folder / (global ? "global.hdf5" : "local.hdf5");
    write_fclib(path, global ? m.problem : local_form(m.problem), kInfo);
    write_fclib_solution(path, m.s, m.u);
    Hdf5File(path, Mode::kAppend).remove("/bipot");
    const ProblemFile seen = read_problem(path);
    EXPECT_EQ(seen.problem.dim, 2);
    EXPECT_LT(contact_error(seen.problem, *seen.r).guarded(), 1e-12);
    const MatrixXd W = dense_delassus(seen.problem);
    const MatrixXd w_1 = dense_delassus(m.problem);
    for (int c = 0; c < 14; ++c) {
      EXPECT_NEAR(W(2 * c + 1, 2 * c + 1), w_1(c, c), 1e-14 * w_1(c, c));  // W_tt = W_nn
      EXPECT_LT((W.row(2 * c + 1).cwiseAbs().sum() - W(2 * c + 1, 2 * c + 1)), 1e-14);
      for (int k = 0; k < 14; ++k) EXPECT_NEAR(W(2 * c, 2 * k), w_1(c, k), 1e-13);
    }
  }
}

TEST_F(FclibFile, ASolutionReplacesTheOneBefore) {
  const Manufactured m = manufactured_problem(2, 5, 6, 1);
  write_fclib(folder / "p.hdf5", local_form(m.problem), kInfo);
  EXPECT_FALSE(read_problem(folder / "p.hdf5").r.has_value());
  write_fclib_solution(folder / "p.hdf5", m.u, m.s);
  write_fclib_solution(folder / "p.hdf5", m.s, m.u);
  EXPECT_EQ(*read_problem(folder / "p.hdf5").r, m.s);
  EXPECT_THROW(write_fclib_solution(folder / "p.hdf5", m.s.head(3), m.u), FileError);
  EXPECT_THROW(write_fclib_solution(folder / "p.hdf5", m.s, m.u, m.u), FileError);
  Vector bad = m.s;
  bad[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(write_fclib_solution(folder / "p.hdf5", bad, m.u), FileError);
  EXPECT_EQ(*read_problem(folder / "p.hdf5").r, m.s);  // a refused one changes nothing
  EXPECT_THROW(write_fclib_solution(folder / "none.hdf5", m.s, m.u), FileError);
}

// One matrix, 4 x 4 with W(0, 1) = 1 but W(1, 0) = 3 so that a transposed reading shows; every
// storage, entries out of order, an explicit zero, a duplicate (4 + 1 = 5), arrays too long.
class Storage : public testing::Test {
 protected:
  void write(int nz, std::vector<int> p, std::vector<int> i, std::vector<double> x) {
    Hdf5File file(path(), Mode::kCreate);
    file.write("/fclib_local/spacedim", 2);
    write_matrix(file, "/fclib_local/W", 4, 4, nz, p, i, x);
    file.write("/fclib_local/W/nzmax", static_cast<int>(x.size()));
    file.write("/fclib_local/vectors/q", std::vector<double>{-1, 0, -1, 0});
    file.write("/fclib_local/vectors/mu", std::vector<double>{0.5, 0.5});
  }
  fs::path path() const { return folder_ / "w.hdf5"; }
  void expect_matrix() const {
    MatrixXd W(4, 4);
    W << 5, 1, 0, 0, 3, 6, 0, 0, 0, 0, 7, 2, 0, 0, 0, 8;
    const ProblemFile file = read_problem(path(), true);
    EXPECT_EQ(MatrixXd(file.problem.W), W);
    EXPECT_EQ(file.problem.W.nonZeros(), 7);  // no explicit zero is kept
    EXPECT_EQ(file.info.title, "");           // info is optional
  }

  TemporaryFolder folder_;
};

TEST_F(Storage, Rows) {
  write(-2, {0, 3, 5, 7, 9}, {1, 0, 0, 1, 0, 3, 2, 3, 0, 99}, {1, 4, 1, 6, 3, 2, 7, 8, 0, -1});
  expect_matrix();
}
TEST_F(Storage, Columns) {
  write(-1, {0, 3, 6, 7, 9}, {1, 0, 0, 1, 0, 3, 2, 3, 2}, {3, 4, 1, 6, 1, 0, 7, 8, 2});
  expect_matrix();
}
TEST_F(Storage, TripletsHaveTheirRowsInI) {
  write(9, {0, 1, 0, 1, 0, 3, 2, 3, 0, 99}, {0, 1, 1, 0, 0, 2, 2, 3, 3, 99},
        {4, 6, 3, 1, 1, 2, 7, 8, 0, -1});
  expect_matrix();
}

TEST_F(Storage, BrokenOnesAreRefusedWithTheReason) {
  const std::vector<int> p = {0, 3, 5, 7, 8}, i = {1, 0, 0, 1, 0, 3, 2, 3};
  const std::vector<double> x = {1, 4, 1, 6, 3, 2, 7, 8};
  const auto expect = [&](const char* reason) {
    const std::string message = refusal(path());
    EXPECT_TRUE(says(message, "w.hdf5"));
    EXPECT_TRUE(says(message, reason));
  };
  write(-2, {0, 3, 5, 7}, i, x);
  expect("/W: p has 4 elements, 5 are needed");
  write(-2, {0, 3, 2, 7, 8}, i, x);
  expect("/W: p[2] = 2 is less than p[1] = 3");
  write(-2, {1, 3, 5, 7, 8}, i, x);
  expect("/W: p[0] = 1");
  write(-2, {0, 3, 5, 7, 9}, i, x);
  expect("/W: i has 8 elements, 9 are needed");
  write(-2, p, {1, 0, 0, 1, 0, 3, 2, 4}, x);
  expect("/W: entry 7 at (3, 4)");
  write(-2, p, {1, 0, 0, -1, 0, 3, 2, 3}, x);
  expect("/W: entry 3 at (1, -1)");
  write(-3, p, i, x);
  expect("/W: nz = -3");
  write(20, p, i, x);
  expect("/W: p has 5 elements, 20 are needed");
  write(-2, p, i, {1, std::numeric_limits<double>::quiet_NaN(), 1, 6, 3, 2, 7, 8});
  expect("/W: entry 1 at (0, 0) = nan is not finite");
  write(-2, p, i, {1, -4, -1, 6, 3, 2, 7, 8});
  expect("W_nn of contact 0 = -5 is not positive");
}

TEST_F(Storage, OtherDefectsAreRefusedWithTheReason) {
  const std::vector<int> p = {0, 3, 5, 7, 8}, i = {1, 0, 0, 1, 0, 3, 2, 3};
  const std::vector<double> x = {1, 4, 1, 6, 3, 2, 7, 8};
  const auto expect = [&](auto&& spoil, const char* reason) {
    write(-2, p, i, x);
    {
      Hdf5File file(path(), Mode::kAppend);
      spoil(file);
    }
    const std::string message = refusal(path());
    EXPECT_TRUE(says(message, "w.hdf5"));
    EXPECT_TRUE(says(message, reason));
  };
  const std::vector<double> none, one = {1}, three = {1, 2, 3}, negative = {0.5, -0.5};
  const std::vector<double> infinite = {1, std::numeric_limits<double>::infinity(), 1, 1};
  expect([](Hdf5File& f) { f.remove("/fclib_local/W"); }, "/fclib_local/W: missing");
  expect([](Hdf5File& f) { f.remove("/fclib_local/W/i"); }, "/fclib_local/W/i: missing");
  expect([](Hdf5File& f) { f.remove("/fclib_local/vectors/q"); }, "/vectors/q: missing");
  expect([](Hdf5File& f) { f.remove("/fclib_local"); }, "neither /fclib_local nor /fclib_global");
  expect([](Hdf5File& f) { f.create_group("/fclib_global"); }, "both");
  expect([](Hdf5File& f) { f.write("/fclib_local/spacedim", 5); }, "neither 2 nor 3");
  expect([](Hdf5File& f) { f.write("/fclib_local/spacedim", 3); }, "is 4 x 4, expected 6 x 6");
  expect([&](Hdf5File& f) { f.write("/fclib_local/vectors/mu", three); }, "expected 6 x 6");
  expect([&](Hdf5File& f) { f.write("/fclib_local/vectors/q", three); }, "size of q is 3");
  expect([&](Hdf5File& f) { f.write("/fclib_local/vectors/q", infinite); },
         "/vectors/q: element 1 = inf is not finite");
  expect([&](Hdf5File& f) { f.write("/fclib_local/vectors/mu", negative); }, "mu[1] = -0.5");
  expect([](Hdf5File& f) { f.write("/fclib_local/W/n", 2000000000); }, "expected 4 x 4");
  expect([](Hdf5File& f) { f.write("/fclib_local/W/nz", "sparse"); }, "/W/nz: not integers");
  expect([&](Hdf5File& f) { f.write("/bipot/row_scale", three); }, "row_scale has size 3");
  expect([](Hdf5File& f) { f.write("/bipot/dim", 1); }, "there is friction");
  expect([&](Hdf5File& f) { f.write("/solution/r", one); }, "/solution/r: has 1 elements");
  expect([&](Hdf5File& f) { f.write("/solution/r", infinite); },
         "/solution/r: element 1 = inf is not finite");
  expect([](Hdf5File& f) { f.create_group("/solution"); }, "/solution/r: missing");
  expect(
      [](Hdf5File& f) {
        f.write("/fclib_local/V/m", 4);
        f.write("/fclib_local/V/n", 1);
      },
      "/fclib_local/V/nz: missing");
  expect([&](Hdf5File& f) { f.write("/fclib_local/vectors/s", one); }, "/fclib_local/V: missing");
  // Constraint groups of size nought constrain nothing.
  write(-2, p, i, x);
  {
    Hdf5File file(path(), Mode::kAppend);
    file.write("/fclib_local/V/m", 4);
    file.write("/fclib_local/V/n", 0);
    file.write("/fclib_local/vectors/s", none);
  }
  EXPECT_EQ(read_problem(path(), true).problem.num_contacts(), 2);
}

TEST_F(FclibFile, GlobalProblemsAreRefusedWithTheReason) {
  const auto path = folder / "g.hdf5";
  const auto expect = [&](auto&& spoil, const char* reason) {
    write_fclib(path, manufactured_problem(2, 4, 4, 1).problem, kInfo);
    {
      Hdf5File file(path, Mode::kAppend);
      spoil(file);
    }
    EXPECT_TRUE(says(refusal(path), reason));
  };
  const std::vector<double> one = {1};
  expect([&](Hdf5File& f) { f.write("/fclib_global/vectors/f", one); }, "/M: is 12 x 12");
  expect([&](Hdf5File& f) { f.write("/fclib_global/vectors/w", one); }, "size of w is 1");
  expect([&](Hdf5File& f) { f.write("/fclib_global/vectors/b", one); }, "/G: missing");
  expect([](Hdf5File& f) { f.write("/fclib_global/H/n", 7); }, "/H: is 12 x 7, expected 12 x 8");
  expect([](Hdf5File& f) { f.write("/fclib_global/M/x", std::vector<double>(12, -1.0)); },
         "A(0, 0) = -1 is not positive");
}

// With G A⁻¹ Gᵀ, Hᵀ A⁻¹ Gᵀ and G v_free - b the local form of a problem with joints is known. The
// rows stand there twice, so that R is singular.
TEST_F(FclibFile, EqualityRowsOfALocalProblemAreEliminated) {
  for (const int dim : {2, 3}) {
    const ManufacturedJoints m = manufactured_joints(dim, 9, 14, 3);
    const EqualityRows& rows = *m.problem.equality;
    const ContactProblem& given = rows.given;
    MatrixXd G(2 * rows.G.rows(), rows.G.cols());
    G << MatrixXd(rows.G), MatrixXd(rows.G);
    const Vector inverse = given.A.diagonal().cwiseInverse();
    const MatrixXd V = MatrixXd(given.H).transpose() * inverse.asDiagonal() * G.transpose();
    const MatrixXd R = G * inverse.asDiagonal() * G.transpose();
    Vector s = G * given.v_free;
    s.head(rows.b.size()) -= rows.b;
    s.tail(rows.b.size()) -= rows.b;
    ContactProblem local{.dim = dim,
                         .W = assemble_delassus(given.A, given.H, dim),
                         .u_free = given.u_free,
                         .mu = given.mu};
    const auto write = [&](const Vector& values) {
      write_fclib(folder / "l.hdf5", local, kInfo);
      Hdf5File file(folder / "l.hdf5", Mode::kAppend);
      for (const auto& [name, matrix] : {std::pair{"V", V}, std::pair{"R", R}}) {
        std::vector<int> i, p;
        std::vector<double> x;
        for (int row = 0; row < matrix.rows(); ++row) {
          for (int column = 0; column < matrix.cols(); ++column) {
            i.push_back(row);
            p.push_back(column);
            x.push_back(matrix(row, column));
          }
        }
        write_matrix(file, std::string("/fclib_local/") + name, static_cast<int>(matrix.rows()),
                     static_cast<int>(matrix.cols()), static_cast<int>(x.size()), p, i, x);
      }
      file.write("/fclib_local/vectors/s", std::vector<double>(values.begin(), values.end()));
    };
    write(s);
    const ContactProblem p = read_problem(folder / "l.hdf5").problem;
    EXPECT_LT(contact_error(p, m.s).guarded(), 1e-11);
    Vector u;
    DelassusOperator(p).velocity(m.s, u);
    EXPECT_LT((u - m.u).norm(), 1e-12 * m.u.norm());
    s[0] += 1;
    write(s);
    EXPECT_TRUE(says(refusal(folder / "l.hdf5"), "contradicts other rows"));
  }
}

TEST_F(FclibFile, AGeneralMassMatrixIsSolvedWithAndItsDelassusOperatorAssembled) {
  // M = [2 1; 1 2], H = I, f = (1, 2), w = 0: v_free = M⁻¹ f = (0, 1), W = M⁻¹ = [2 -1; -1 2] / 3.
  {
    Hdf5File file(folder / "g.hdf5", Mode::kCreate);
    write_matrix(file, "/fclib_global/M", 2, 2, -2, {0, 2, 4}, {0, 1, 0, 1}, {2, 1, 1, 2});
    write_matrix(file, "/fclib_global/H", 2, 2, -2, {0, 1, 2}, {0, 1}, {1, 1});
    file.write("/fclib_global/spacedim", 2);
    file.write("/fclib_global/vectors/f", std::vector<double>{1, 2});
    file.write("/fclib_global/vectors/w", std::vector<double>{0, 0});
    file.write("/fclib_global/vectors/mu", std::vector<double>{0.3});
  }
  const ContactProblem p = read_problem(folder / "g.hdf5").problem;
  MatrixXd W(2, 2);
  W << 2, -1, -1, 2;
  EXPECT_LT((MatrixXd(p.W) - W / 3).norm(), 1e-15);
  EXPECT_LT((p.v_free - Vector::Unit(2, 1)).norm(), 1e-15);
  EXPECT_LT((p.u_free - Vector::Unit(2, 1)).norm(), 1e-15);
}

// Hilbert's matrix of order 8 has a condition of 1.5e10: M⁻¹ (M v) is not v, yet the problem comes
// back.
TEST_F(FclibFile, AnIllConditionedMassMatrixKeepsTheVelocitiesOfContacts) {
  ContactProblem p{.dim = 2, .mu = Vector::Constant(1, 0.5)};
  MatrixXd hilbert(8, 8);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) hilbert(i, j) = 1.0 / (i + j + 1);
  }
  p.A = hilbert.sparseView();
  p.H = MatrixXd::Identity(8, 2).sparseView();
  p.v_free = Vector{{-1, 0.1, 0, 0, 0, 0, 0, 0}};
  p.u_free = Vector{{-1, 0.1}};
  write_fclib(folder / "p.hdf5", p, kInfo);
  EXPECT_LT((read_problem(folder / "p.hdf5").problem.u_free - p.u_free).norm(), 1e-15);
}

TEST_F(FclibFile, UnsoundProblemsAreNotWritten) {
  ContactProblem p = manufactured_problem(2, 4, 4, 1).problem;
  p.mu[2] = -1;
  EXPECT_THROW(write_fclib(folder / "p.hdf5", p, kInfo), FileError);
  EXPECT_THROW(write_fclib(folder / "p.hdf5", ContactProblem(), kInfo), FileError);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST_F(FclibFile, GuessesComeBackAsTheyWere) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 9, 14, 3);
    const std::vector<Vector> guesses{0.5 * m.s, Vector::Zero(m.s.size())};
    for (const ContactProblem& p : {m.problem, local_form(m.problem)}) {
      write_fclib(folder / "p.hdf5", p, kInfo, guesses);
      write_fclib_solution(folder / "p.hdf5", m.s, m.u);  // leaves them alone
      const ProblemFile file = read_problem(folder / "p.hdf5");
      ASSERT_EQ(file.guesses.size(), 2u);
      EXPECT_EQ(file.guesses[0], guesses[0]);
      EXPECT_EQ(file.guesses[1], guesses[1]);
      // FCLIB wants the velocities of a guess, too.
      Vector u;
      DelassusOperator(p).velocity(guesses[0], u);
      const std::vector<double> stored =
          Hdf5File(folder / "p.hdf5", Mode::kRead).read_doubles("/guesses/1/u");
      const int d = std::max(dim, 2);
      ASSERT_EQ(stored.size(), static_cast<std::size_t>(14 * d));
      for (int c = 0; c < 14; ++c) EXPECT_NEAR(stored[c * d], u[c * dim], 1e-12);
    }
  }
  const ContactProblem p = manufactured_problem(2, 4, 4, 1).problem;
  write_fclib(folder / "none.hdf5", p, kInfo);
  EXPECT_TRUE(read_problem(folder / "none.hdf5").guesses.empty());
  EXPECT_THROW(write_fclib(folder / "bad.hdf5", p, kInfo, {Vector::Zero(3)}), FileError);
  write_fclib(folder / "short.hdf5", p, kInfo, {Vector::Zero(8)});
  Hdf5File(folder / "short.hdf5", Mode::kAppend).write("/guesses/1/r", std::vector<double>{1, 2});
  EXPECT_THROW(read_fclib(folder / "short.hdf5"), FileError);
}

#ifdef BIPOT_TESTS_WITH_FCLIB
TEST_F(FclibFile, LibfclibReadsWhatIsWritten) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 9, 14, 3);
    const int d = std::max(dim, 2);
    const std::string local = (folder / "local.hdf5").string();
    write_fclib(local, local_form(m.problem), kInfo);
    write_fclib_solution(local, m.s, m.u);
    fclib_local* l = fclib_read_local(local.c_str());
    ASSERT_NE(l, nullptr);
    EXPECT_EQ(l->spacedim, d);
    EXPECT_EQ(l->W->m, d * 14);
    EXPECT_EQ(l->W->nz, -2);
    EXPECT_STREQ(l->info->title, kInfo.title.c_str());
    EXPECT_STREQ(l->info->description, kInfo.description.c_str());
    for (int c = 0; c < 14; ++c) {
      EXPECT_EQ(l->mu[c], m.problem.mu[c]);
      EXPECT_EQ(l->q[c * d], m.problem.u_free[c * dim]);
    }
    fclib_solution* solution = fclib_read_solution(local.c_str());
    ASSERT_NE(solution, nullptr);
    for (int c = 0; c < 14; ++c) EXPECT_EQ(solution->r[c * d], m.s[c * dim]);
    fclib_delete_solutions(solution, 1);
    fclib_delete_local(l);

    const std::string global = (folder / "global.hdf5").string();
    write_fclib(global, m.problem, kInfo, {m.s, 2 * m.s});
    write_fclib_solution(global, m.s, m.u);
    fclib_global* g = fclib_read_global(global.c_str());
    ASSERT_NE(g, nullptr);
    EXPECT_EQ(g->spacedim, d);
    EXPECT_EQ(g->H->n, d * 14);
    EXPECT_EQ(g->H->nz, -1);
    EXPECT_EQ(g->M->m, m.problem.num_dofs() + (dim == 1 ? 14 : 0));
    solution = fclib_read_solution(global.c_str());
    ASSERT_NE(solution, nullptr);
    const Vector v = body_velocities(m.problem, m.s);
    for (int k = 0; k < v.size(); ++k) EXPECT_NEAR(solution->v[k], v[k], 1e-12);
    for (int c = 0; c < 14; ++c) EXPECT_EQ(solution->u[c * d], m.u[c * dim]);
    fclib_delete_solutions(solution, 1);
    int number_of_guesses = 0;
    fclib_solution* guesses = fclib_read_guesses(global.c_str(), &number_of_guesses);
    ASSERT_EQ(number_of_guesses, 2);
    for (int c = 0; c < 14; ++c) EXPECT_EQ(guesses[1].r[c * d], 2 * m.s[c * dim]);
    fclib_delete_solutions(guesses, 2);
    fclib_delete_global(g);
  }
}
#endif

/// The collection of problems by others is not part of the repository.
fs::path collection() {
  if (const char* named = std::getenv("BIPOT_PROBLEMS"); named != nullptr) return named;
  return source_folder().parent_path() / "shared" / "problems";
}

TEST_F(FclibFile, TheCollectionOfProblemsByOthersIsReadAndItsReferencesHold) {
  if (!fs::is_directory(collection())) {
    GTEST_SKIP() << "not run: " << collection()
                 << " is no folder; BIPOT_PROBLEMS can name the folder of the collection";
  }
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(collection())) {
    if (entry.path().extension() == ".hdf5") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  EXPECT_EQ(paths.size(), 31u);
  int references = 0;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename());
    const ProblemFile file = read_problem(path);
    EXPECT_EQ(file.global, path.filename().string().find("_global_") != std::string::npos);
    EXPECT_EQ(file.problem.dim, path.filename().string()[0] - '0');
    EXPECT_FALSE(file.info.title.empty());
    if (!file.r) continue;
    ++references;
    EXPECT_LE(contact_error(file.problem, *file.r).natural_map, 1e-8);
    Vector u;
    DelassusOperator(file.problem).velocity(*file.r, u);
    EXPECT_LE((u - *file.u).norm(), 1e-9 * std::max(file.u->norm(), file.problem.u_free.norm()));
    if (file.v) {
      EXPECT_LE((body_velocities(file.problem, *file.r) - *file.v).norm(), 1e-10 * file.v->norm());
    }
  }
  EXPECT_EQ(references, 30);
}

}  // namespace
}  // namespace bipot
