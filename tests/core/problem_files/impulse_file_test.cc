#include "core/problem_files/impulse_file.h"

#include "core/base/file_error.h"
#include "core/problem_files/fclib_file.h"
#include "tests/support/manufactured.h"
#include "tests/support/random_vector.h"
#include "tests/support/small_problems.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

ContactProblem problem(int dim, int contacts) {
  ContactProblem p{
      .dim = dim, .u_free = Vector::Zero(dim * contacts), .mu = Vector::Constant(contacts, 0.5)};
  return p;
}

class ImpulseFile : public testing::Test {
 protected:
  Vector read(const std::string& text, const ContactProblem& p, const ImpulseLayout& layout = {}) {
    std::ofstream(path()) << text;
    return read_impulses(path(), p, layout);
  }
  std::string refusal(const std::string& text, const ContactProblem& p,
                      const ImpulseLayout& layout = {}) {
    return refusal_of<std::exception>([&] { read(text, p, layout); });
  }
  fs::path path() const { return folder_ / "impulses.txt"; }

  TemporaryFolder folder_;
};

const ContactProblem kThree = problem(2, 3);
const Vector kImpulses = vec({1, -2, 3, -4, 5, -6});

TEST_F(ImpulseFile, TextIsReadInAllItsForms) {
  for (const char* text :
       {"1 -2 3 -4 5 -6", "1\n-2\n3\n-4\n5\n-6\n", "1,-2\n3,-4\n5,-6\n", "1; -2\n3; -4\n5; -6",
        "s_n,s_t\n1,-2\n3,-4\n5,-6\n",  // names
        "\xEF\xBB\xBF"
        "1,-2\n3,-4\n5,-6\n",                                    // the mark of a spreadsheet
        "# a comment\n\n1 -2 # another\r\n3 -4\r\n+5 -6e0\r\n",  // and another system's line ends
        "contact,n,t\n0,1,-2\n1,3,-4\n2,5,-6\n",                 // contacts counted from 0
        ",n,t\n1,1,-2\n2,3,-4\n3,5,-6\n",                        // and from 1
        "6\n1 -2 3 -4 5 -6\n",                                   // Siconos: the size before
        "size = 6; \ndata= [1.0e0,\t -2,\t 3,\t -4,\t 5,\t -6,\t ]"}) {
    EXPECT_EQ(read(text, kThree), kImpulses) << text;
  }
}

TEST_F(ImpulseFile, LayoutsOfOtherCodesAreUndone) {
  using Order = ImpulseLayout::Order;
  EXPECT_EQ(read("1 3 5 -2 -4 -6", kThree, {.order = Order::kComponent}), kImpulses);
  EXPECT_EQ(read("-2 1 -4 3 -6 5", kThree, {.components = "tn"}), kImpulses);
  EXPECT_EQ(read("-1 -2 -3 -4 -5 -6", kThree, {.negated = "n"}), kImpulses);
  EXPECT_EQ(read("-1 2 -3 4 -5 6", kThree, {.negated = "nt"}), kImpulses);
  EXPECT_EQ(read("10 -20 30 -40 50 -60", kThree, {.factor = 0.1}), kImpulses);
  // Forces, tangents first and the other way round, component after component.
  EXPECT_EQ(read("4 8 12 2 6 10", kThree,
                 {.order = Order::kComponent, .components = "tn", .negated = "t", .factor = 0.5}),
            kImpulses);
  EXPECT_EQ(read("2 3 1 5 6 4", problem(3, 2), {.components = "tsn"}), vec({1, 2, 3, 4, 5, 6}));
  // A table of d rows with a column a contact speaks for itself.
  EXPECT_EQ(read("1 3 5\n-2 -4 -6\n", kThree), kImpulses);
  // A list that is wrapped alike cannot be told from it.
  EXPECT_TRUE(says(refusal("1 -2\n3 -4\n5 -6\n", kThree, {.order = Order::kComponent}),
                   "rows of 2 numbers are in the other order"));
  EXPECT_EQ(read("1 -2 3 -4 5 -6", kThree, {.order = Order::kContact}), kImpulses);
  // Unless it is square.
  EXPECT_EQ(read("1 3\n-2 -4\n", problem(2, 2), {.order = Order::kComponent}), vec({1, -2, 3, -4}));
  EXPECT_EQ(read("1 -2\n3 -4\n", problem(2, 2)), vec({1, -2, 3, -4}));
}

TEST_F(ImpulseFile, TheSizeThatIsSaidIsThatOfTheNumbers) {
  EXPECT_EQ(read(" \nsize = 6; data= [1 -2 3 -4 5 -6]", kThree), kImpulses);
  EXPECT_TRUE(
      says(refusal("size = 7; data= [1 -2 3 -4 5 -6]", kThree), "6 numbers, where size is 7"));
}

TEST_F(ImpulseFile, NamesOfColumnsMustSayTheOrder) {
  for (const char* names : {"t,n", "contact,s_t,s_n", "Tangential,Normal", "f,rn"}) {
    const std::string table = std::string(names) + "\n-2,1\n-4,3\n-6,5\n";
    EXPECT_TRUE(says(refusal(table, kThree), "give the order of the components")) << names;
    EXPECT_EQ(read(table, kThree, {.components = "tn"}), kImpulses);
  }
  EXPECT_TRUE(says(refusal("n,t\n1,-2\n3,-4\n5,-6\n", kThree, {.components = "tn"}), "'n'"));
  EXPECT_TRUE(says(refusal("n,t2,t1\n1,2,3\n4,5,6\n", problem(3, 2)), "column 2"));
  for (const char* names :
       {"n,t1,t2", "normal,tangent1,tangent2", "Normal,Tangential_1,Tangential_2"}) {
    const std::string table = std::string(names) + "\n1,2,3\n4,5,6\n";
    EXPECT_EQ(read(table, problem(3, 2)), vec({1, 2, 3, 4, 5, 6})) << names;
  }
  EXPECT_TRUE(says(refusal("n,t,s\n1,2,3\n4,5,6\n", problem(3, 2), {.components = "n"}),
                   "expected the letters"));
  // Other names say nothing.
  EXPECT_EQ(read("impulse,other\n1,-2\n3,-4\n5,-6\n", kThree), kImpulses);
}

TEST_F(ImpulseFile, FrictionlessProblemsTakeNormalsOrInertTangents) {
  EXPECT_EQ(read("1 2 3", problem(1, 3)), vec({1, 2, 3}));
  EXPECT_EQ(read("s\n1\n2\n3\n", problem(1, 3)), vec({1, 2, 3}));  // any name
  EXPECT_EQ(read("1 0 2 0 3 0", problem(1, 3)), vec({1, 2, 3}));
  EXPECT_TRUE(says(refusal("1 0 2 7 3 0", problem(1, 3)), "tangential impulse 7, expected 0"));
  // Numbers of the contacts beside the normals.
  EXPECT_EQ(read("contact,n\n0,5\n1,0\n2,7\n", problem(1, 3)), vec({5, 0, 7}));
  EXPECT_EQ(read("1 5\n2 6\n3 7\n", problem(1, 3)), vec({5, 6, 7}));
  // Inert tangents, or three zeros.
  EXPECT_TRUE(says(refusal("1 0\n2 0\n3 0\n", problem(1, 3)), "name two columns"));
  EXPECT_EQ(read("n,t\n1 0\n2 0\n3 0\n", problem(1, 3)), vec({1, 2, 3}));
  EXPECT_EQ(read("contact,n\n1 0\n2 0\n3 0\n", problem(1, 3)), vec({0, 0, 0}));
  EXPECT_EQ(read("1\n7\n", problem(1, 1)), vec({7}));  // the size before
  EXPECT_TRUE(says(refusal("1\n0\n", problem(1, 1)), "name two columns"));
  EXPECT_EQ(read("0 0\n", problem(1, 1)), vec({0}));
  EXPECT_TRUE(says(refusal("n,t\n1 0.5\n2 0\n3 0\n", problem(1, 3)), "tangential impulse 0.5"));
  // FCLIB's form of one contact.
  const ContactProblem one = one_contact_problem(1, 2, 3, 0, -2, {});
  write_fclib(path(), one, {});
  write_fclib_solution(path(), vec({1}), vec({0}));
  EXPECT_EQ(read_impulses(path(), one), vec({1}));
  // The order of one row is no order.
  EXPECT_EQ(read("1 2 3", problem(1, 3), {.order = ImpulseLayout::Order::kContact}),
            vec({1, 2, 3}));
  EXPECT_EQ(read("1 2", problem(2, 1), {.order = ImpulseLayout::Order::kComponent}), vec({1, 2}));
  EXPECT_EQ(read("", problem(2, 0)).size(), 0);
}

TEST_F(ImpulseFile, MomentsOfRollingKeepTheirPlaces) {
  for (const int rows : {3, 6}) {
    const Manufactured m = manufactured_rolling(rows, 5, 8, 3);
    const auto file = folder_ / "solved.hdf5";
    write_fclib(file, m.problem, {});
    write_fclib_solution(file, m.s, m.u);
    EXPECT_EQ(read_impulses(file, m.problem), m.s) << rows;
  }
  const Vector s = vec({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  const char* names = "t,n,s,m_t,m_s,m_n\n2,-1,3,4,5,6\n8,-7,9,10,11,12\n";
  EXPECT_EQ(read(names, problem(6, 2), {.components = "tns", .negated = "n"}), s);
  EXPECT_EQ(read("1 7\n2 8\n3 9\n4 10\n5 11\n6 12\n", problem(6, 2)), s);
}

TEST_F(ImpulseFile, TheSolutionOfAnFclibFileIsReadBack) {
  for (int dim = 1; dim <= 3; ++dim) {
    const Manufactured m = manufactured_problem(dim, 5, 8, 3);
    const auto file = folder_ / "solved.hdf5";
    write_fclib(file, m.problem, {});
    EXPECT_THROW(read_impulses(file, m.problem), FileError);  // no /solution yet
    write_fclib_solution(file, m.s, m.u);
    EXPECT_EQ(read_impulses(file, m.problem), m.s);
  }
}

TEST_F(ImpulseFile, RefusalsSayWhatIsWrong) {
  EXPECT_TRUE(says(refusal("1 2 3", kThree), "s has size 3, expected 6 = 3 contacts x 2"));
  EXPECT_TRUE(says(refusal("1 2\n3 four\n5 6", kThree), "line 2: 'four' is not a number"));
  EXPECT_TRUE(says(refusal("size = 6; data= 1, 2", kThree), "no [...]"));
  EXPECT_TRUE(says(refusal("1 2 3 4 5 6", kThree, {.components = "nn"}), "components 'nn'"));
  EXPECT_TRUE(says(refusal("1 2 3 4 5 6", kThree, {.negated = "s"}), "letters of 'nt'"));
  EXPECT_TRUE(says(refusal(std::string("\0\1", 2), kThree), "neither a text file"));
  EXPECT_TRUE(says(refusal("1 2 3 nan 5 6", kThree), "impulses.txt: s[3] = nan is not finite"));
  EXPECT_TRUE(says(refusal("# none", kThree), "no numbers, expected 6 = 3 contacts x 2"));
  std::ofstream(folder_ / "scene.toml") << "[time]\n";
  EXPECT_TRUE(says(refusal_of<FileError>([&] { read_impulses(folder_ / "scene.toml", kThree); }),
                   "scene.toml: a scene, not impulses: expected .npy, .csv, FCLIB HDF5 or Siconos "
                   "text with 6 = 3 contacts x 2 numbers"));
  EXPECT_THROW(read_impulses(folder_ / "nothing", kThree), FileError);
  EXPECT_THROW(read_impulses(folder_.path(), kThree), FileError);
}

}  // namespace
}  // namespace bipot
