// `bipot judge`, run as a user runs it.

#include "core/problem_files/problem_file.h"
#include "solvers/solve.h"
#include "tests/bench/command/command_fixture.h"

namespace bipot {
namespace {

using nlohmann::json;

const std::string kProblem = shipped_problem("2d_triangular_lattice");

Vector solution_of(const ContactProblem& p) { return solve("ipm", p, {.tol = 1e-9}).s; }

class JudgeCommand : public Command {
 protected:
  static int judge(const std::string& arguments) { return code_of("judge " + arguments); }

  /// The impulses of `s`, a line a contact, tangent first, forces of steps of 0.5 s, pulling
  /// positive.
  std::string foreign_file(const ContactProblem& p, const Vector& s) const {
    std::ofstream out("foreign.csv");
    out.precision(17);
    out << "t,n\n";
    for (int c = 0; c < p.num_contacts(); ++c) {
      out << 2 * s[2 * c + 1] << ',' << -2 * s[2 * c] << '\n';
    }
    return "foreign.csv";
  }
};

TEST_F(JudgeCommand, AgreesWithTheSolverThatWroteTheSolution) {
  const json said =
      json_of("solve " + kProblem + " --solver ipm --tol 1e-10 --json - --solution solved.hdf5");
  const json j = json_of("judge solved.hdf5 --json -");
  EXPECT_EQ(j["command"], "judge");
  EXPECT_EQ(j["status"], "within");
  for (const char* key :
       {"epsilon", "eta", "natural_map", "contacts", "take_off", "stick", "slip"}) {
    EXPECT_EQ(j[key], said[key]) << key;
  }
  EXPECT_LT(j["cone"].get<double>(), 1e-15);
  // The problem file and the impulses may be two files.
  EXPECT_EQ(judge(kProblem + " --impulses solved.hdf5 -q"), 0);
  EXPECT_EQ(judge(kProblem + " --impulses solved.hdf5 -q --tol 1e-16"), 1);
}

TEST_F(JudgeCommand, UndoesTheLayoutOfAnotherCode) {
  const ContactProblem p = read_problem(kProblem).problem;
  const std::string foreign = foreign_file(p, solution_of(p));
  const std::string flags = " --components tn --negate n --factor 0.5 --tol 1e-6";
  EXPECT_EQ(judge(kProblem + " --impulses " + foreign + flags + " -q"), 0);
  const std::string order = " --components tn --tol 1e-6 -q";
  EXPECT_EQ(judge(kProblem + " --impulses " + foreign + order), 1);
  // Its names say another order than normal first.
  EXPECT_EQ(judge(kProblem + " --impulses " + foreign + " --tol 1e-6 -q"), 2);
}

TEST_F(JudgeCommand, NamesTheContactThatWasSabotaged) {
  const ContactProblem p = read_problem(kProblem).problem;
  Vector s = solution_of(p);
  const int contact = p.num_contacts() / 2;
  s[2 * contact] = -0.1;
  s[2 * contact + 1] = 0;
  std::ofstream out("s.txt");
  out.precision(17);
  for (const double x : s) out << x << '\n';
  out.close();
  const json j = json_of("judge " + kProblem + " --impulses s.txt --json -", 1);
  EXPECT_EQ(j["status"], "not within");
  EXPECT_EQ(j["cone_contact"], contact);
  EXPECT_DOUBLE_EQ(j["cone_violation"].get<double>(), 0.1);
  bool named = false;
  for (const json& c : j["worst"]) {
    named = named || (c["contact"] == contact &&
                      c["message"].get<std::string>().find("pulls") != std::string::npos);
  }
  EXPECT_TRUE(named) << j;
  expect_said("judge " + kProblem + " --impulses s.txt --worst 2", 1,
              {"not within the tolerance 1e-8", "open "}, &bipot);
}

TEST_F(JudgeCommand, BadInputHasItsExitCode) {
  const auto with = [&](const std::string& name, const std::string& content) {
    return kProblem + " --impulses " + write(name, content);
  };
  EXPECT_EQ(judge("missing.hdf5"), 4);
  EXPECT_EQ(judge(kProblem + " --impulses missing.npy"), 4);
  EXPECT_EQ(judge(with("short.txt", "1 2 3")), 2);
  EXPECT_EQ(judge(with("words.txt", "1 two 3")), 2);
  EXPECT_EQ(judge(kProblem + " --components tt"), 2);
  EXPECT_EQ(judge(kProblem + " --order rows"), 2);
  EXPECT_EQ(judge(kProblem + " --tol -1"), 2);
  // A problem without /solution, and no --impulses; the refusal reaches the JSON as well.
  const json unsolved = json_of("judge " + kProblem + " --json -", 2);
  EXPECT_TRUE(says(unsolved["message"], "no /solution to judge"));
  // Not a number among the impulses.
  std::string text;
  const int rows = read_problem(kProblem).problem.num_rows();
  for (int i = 0; i < rows; ++i) text += i == 3 ? "nan\n" : "0\n";
  EXPECT_EQ(judge(with("nan.txt", text)), 2);
  text.replace(text.find("nan"), 3, "1e300");
  expect_said("judge " + with("huge.txt", text), 2, {"huge.txt: the energy of these impulses"});
}

}  // namespace
}  // namespace bipot
