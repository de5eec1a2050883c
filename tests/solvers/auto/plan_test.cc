#include "solvers/auto/plan.h"

#include <iterator>

#include "solvers/auto/auto_plan.h"
#include "tests/support/converged.h"
#include "tests/support/small_problems.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

std::string fault_of(const std::string& text) {
  return refusal_of<std::invalid_argument>([&] { parse_plan(text, "plan.toml"); });
}

/// A class with these lines and one stage.
std::string with_lines(const std::string& lines) {
  return "[[class]]\nname = \"all\"\n" + lines + "\nstages = [{solver = \"pgs\"}]\n";
}
std::string with_stage(const std::string& stage) {
  return "[[class]]\nname = \"all\"\nstages = [\n" + stage + "\n]\n";
}

TEST(Plan, FaultsAreToldByLine) {
  const struct {
    std::string text, line, reason;
  } kFaults[] = {
      {"[[class]\n", "1", ""},
      {"a = 1\n", "1", "unknown key 'a'"},
      {"[why]\nx = \"y\"\n", "1", "expected a [[class]]"},
      {with_lines("contact = [0, 1]"), "3", "did you mean 'contacts'?"},
      {with_lines("contacts = [3, 2]"), "3", "the first number must be smaller"},
      {with_lines("contacts = 3"), "3", "expected two numbers"},
      {with_lines("tol = [\"a\", 1]"), "3", "expected a number"},
      {with_lines("when = \"warn\""), "3", "did you mean 'warm'?"},
      {with_lines("solved = [3, 2]"), "3", "expected a number, at least 3"},
      {with_stage("{most = 3}"), "4", "needs a solver or a list"},
      {with_stage("{solver = \"pgz\"}"), "4", "did you mean 'pgs'?"},
      {with_stage("{solver = \"auto\"}"), "4", "cannot be auto"},
      {with_stage("{solver = \"pgs\", with = \"omegs=1\"}"), "4", "did you mean 'omega'?"},
      {with_stage("{solver = \"pgs\", with = \"omega=9\"}"), "4", "omega"},
      {with_stage("{solver = \"pgs\", from = \"first\"}"), "4", "expected own, caller"},
      {with_stage("{solver = \"pgs\", from = \"a best\"}"), "4", "expected own, caller"},
      {with_stage("{solver = \"pgs\", from = []}"), "4", "expected own, caller"},
      {with_stage("{solver = \"pgs\", from = [\"best\", 1]}"), "4", "expected a text"},
      {with_stage("{solver = \"pgs\", then = \"few\"}"), "4", "unknown list 'few'"},
      {with_stage("{solver = \"pgs\", most = -1}"), "4", "at least 0"},
      {with_stage("{solver = \"pgs\", most = [1]}"), "4", "[factor, power]"},
      {with_stage("{solver = \"pgs\", whole = \"yes\"}"), "4", "expected first or only"},
      {with_stage("{list = \"few\"}"), "4", "unknown list 'few'"},
      {with_stage("{list = \"shipped\", repeat = 1.5}"), "4", "expected an integer"},
      {"[list.shipped]\nstages = []\n" + with_stage("{solver = \"pgs\"}"), "1", "of the program"},
  };
  for (const auto& [text, line, reason] : kFaults) {
    const std::string fault = fault_of(text);
    EXPECT_EQ(fault.rfind("plan.toml:" + line + ": ", 0), 0u) << text << fault;
    EXPECT_TRUE(says(fault, reason)) << text << fault;
  }
  EXPECT_TRUE(says(fault_of("[list.a]\nstages = [{list = \"a\"}]\n" + with_stage("{list = \"a\"}")),
                   "without end"));
  EXPECT_EQ(fault_of(with_stage("{solver = \"newton\"}")),
            "nothing was thrown");  // whatever the build
}

TEST(Plan, TheFirstClassWhoseConditionsHoldServes) {
  const AutoPlan plan = parse_plan(
      "[[class]]\nname = \"a\"\ncontacts = [10, 20]\ntol = [1e-4, 1]\nwhen = \"warm disks\"\n"
      "solved = [3, 4]\nstages = [{solver = \"pgs\"}]\n"
      "[[class]]\nname = \"b\"\nstages = [{solver = \"apgd\"}]\n",
      "plan.toml");
  const ProblemTraits inside{
      .contacts = 20, .dim = 2, .tol = 1e-4, .marks = kWarm | kDisks | kInPlane};
  const auto name = [&](const ProblemTraits& problem) { return plan.class_of(problem)->name; };
  EXPECT_EQ(name(inside), "a");
  ProblemTraits other = inside;
  other.contacts = 10;
  EXPECT_EQ(name(other), "b");
  other = inside;
  other.tol = 1;
  EXPECT_EQ(name(other), "b");
  other = inside;
  other.marks = kDisks;
  EXPECT_EQ(name(other), "b");
  EXPECT_EQ(plan.classes[0].conditions.to_text(),
            "N > 10, N <= 20, tol >= 1e-4, tol < 1, warm disks");
  EXPECT_EQ(plan.classes[0].solved, 3);
  EXPECT_EQ(plan.classes[0].measured, 4);
  EXPECT_EQ(marks_of_words(mark_words(inside.marks)), inside.marks);
}

TEST(Plan, WhereAClassHasNoStageTheShippedPlanServes) {
  const ContactProblem p = shipped_file("2d_pour12_170.hdf5");
  const TemporaryFolder folder;
  const std::string path = (folder / "own.toml").string();
  const SolverOptions options{.tol = 1e-4, .parameters = {{"plan", path}}};
  for (const char* stage : {"", "{solver = \"pgs\", contacts = [10000, inf]}"}) {
    std::ofstream(path) << with_stage(stage);
    converged(solve("auto", p, options), stage);
  }
  // The attempt on the whole was all that there is.
  std::ofstream(path) << with_stage("{solver = \"pgs\", most = 3, whole = \"only\"}");
  const SolveResult result = ended(SolveStatus::kIterationLimit, solve("auto", p, options));
  EXPECT_TRUE(says(result.message, "none was run"));
}

TEST(Plan, BudgetsGrowWithContactsAndRepetitions) {
  const AutoPlan plan = parse_plan(
      "[list.round]\nstages = [{solver = \"apgd\", from = \"0.5 best\", least = 7, most = [2, 0.5]}]\n"
      "[[class]]\nname = \"all\"\nstages = [\n"
      "  {list = \"round\", repeat = 3, growth = 4},\n"
      "  {solver = \"pgs\", most = [1, 0, 30], contacts = [200, inf]},\n"
      "  {solver = \"pgs\", most = [1, 0, 30], error = 0.1, whole = \"only\"},\n"
      "  {solver = \"pgs\"}]\n",
      "plan.toml");
  const std::vector<AutoStage> stages =
      plan_stages(plan, {.contacts = 100, .dim = 2, .tol = 1e-3, .marks = kCold});
  ASSERT_EQ(stages.size(), 5u);
  // 2 sqrt(100) = 20, then 4 and 16 times as many; at least 7, 28, 112.
  for (const int k : {0, 1, 2}) {
    EXPECT_EQ(stages[to_size(k)].max_iterations, 20 << (2 * k));
    EXPECT_EQ(stages[to_size(k)].min_iterations, 7 << (2 * k));
    EXPECT_EQ(stages[to_size(k)].start, AutoPlan::Row::Start::kBest);
    EXPECT_EQ(stages[to_size(k)].of_start, 0.5);
  }
  EXPECT_EQ(stages[3].max_iterations, 30);
  EXPECT_EQ(stages[3].largest_error, 0.1);
  EXPECT_TRUE(stages[3].before_cutting && stages[3].on_whole_only);
  EXPECT_EQ(stages[4].max_iterations, AutoStage::kUnlimited);
  EXPECT_EQ(stages[4].min_iterations, AutoStage::kUnlimited);
}

TEST(Plan, AStageFromSeveralStartsRunsOnceFromEachWithAListAfterIt) {
  const AutoPlan plan = parse_plan(
      "[list.after]\nstages = [{solver = \"apgd\", from = \"last\"}]\n"
      "[[class]]\nname = \"all\"\nstages = [\n"
      "  {solver = \"pgs\", from = [\"0.5 caller\", \"best\"], then = \"after\", when = \"cold\"}]\n",
      "plan.toml");
  ProblemTraits problem{.contacts = 100, .dim = 2, .tol = 1e-3, .marks = kCold};
  const std::vector<AutoStage> stages = plan_stages(plan, problem);
  using Start = AutoPlan::Row::Start;
  const struct {
    const char* solver;
    Start start;
    double factor;
  } kExpected[] = {{"pgs", Start::kCaller, 0.5},
                   {"apgd", Start::kLast, 1},
                   {"pgs", Start::kBest, 1},
                   {"apgd", Start::kLast, 1}};
  ASSERT_EQ(stages.size(), std::size(kExpected));
  for (std::size_t k = 0; k < stages.size(); ++k) {
    EXPECT_EQ(stages[k].solver->name, kExpected[k].solver);
    EXPECT_EQ(stages[k].start, kExpected[k].start);
    EXPECT_EQ(stages[k].of_start, kExpected[k].factor);
  }
  problem.marks = kWarm;
  EXPECT_TRUE(plan_stages(plan, problem).empty());
}

/// The list 'shipped', and a plan without a class for the problem, go on as the shipped plan does.
TEST(Plan, ThePlanOfTheProgramFollowsWhereItIsAskedFor) {
  const ProblemTraits problem{
      .contacts = 300, .dim = 2, .tol = 1e-3, .marks = kCold | kDisks | kVectors | kInPlane};
  const std::vector<AutoStage> shipped = plan_stages(shipped_plan(), problem);
  ASSERT_GT(shipped.size(), 10u);
  const AutoPlan own = parse_plan(
      "[[class]]\nname = \"a\"\ncontacts = [0, 400]\n"
      "stages = [{solver = \"pgs\", most = 3}, {list = \"shipped\"}]\n",
      "plan.toml");
  const std::vector<AutoStage> stages = plan_stages(own, problem);
  ASSERT_EQ(stages.size(), shipped.size() + 1);
  EXPECT_EQ(stages[0].max_iterations, 3);
  EXPECT_EQ(stages[1].solver, shipped[0].solver);
  ProblemTraits larger = problem;
  larger.contacts = 500;
  EXPECT_EQ(plan_stages(own, larger).size(), plan_stages(shipped_plan(), larger).size());
}

TEST(Plan, TheShippedPlanHasStagesForEveryProblemAndEndsWithoutALimit) {
  for (const unsigned form : {kInPlane | kBodies | kDisks, kInPlane | kWAlone | kNoDisks,
                              kInSpace | kBodies | kNoDisks, kInSpace | kWAlone | kNoDisks}) {
    for (const int contacts : {1, 20, 100, 1000, 3000, 5000, 20000}) {
      for (const double tol : {1e-1, 1e-3, 1e-8}) {
        for (const unsigned start : {kWarm, kCold}) {
          const std::vector<AutoStage> stages =
              plan_stages(shipped_plan(), {.contacts = contacts,
                                           .dim = (form & kInSpace) ? 3 : 2,
                                           .tol = tol,
                                           .marks = form | start | kNoVectors});
          ASSERT_GT(stages.size(), 5u);
          EXPECT_EQ(stages.back().max_iterations, AutoStage::kUnlimited);
          for (const AutoStage& stage : stages) EXPECT_FALSE(stage.reason.empty());
        }
      }
    }
  }
}

TEST(Plan, AFileServesASolveAndAFaultyOneIsInvalidInput) {
  const TemporaryFolder folder;
  const std::string path = (folder / "own.toml").string();
  std::ofstream(path) << with_stage("{solver = \"pgs\", most = 4000}");
  const ContactProblem p = shipped_file("2d_pour300_392.hdf5");
  SolverOptions options{.tol = 1e-2};
  options.parameters["plan"] = path;
  const SolveResult own = converged(solve("auto", p, options));
  EXPECT_FALSE(says(own.message, "assor")) << own.message;
  EXPECT_TRUE(says(own.message, "pgs"));
  SolverOptions read = options;
  read.plan = named_plan(options.parameters);
  EXPECT_TRUE(says(explain_auto(p, options), path + ": class 'all' (all others)"));
  std::ofstream(path) << with_stage("{solver = \"assor\"}");
  EXPECT_TRUE(says(explain_auto(p, read), "pgs"));                // is not read again
  EXPECT_TRUE(says(solve("auto", p, options).message, "assor"));  // a file that has changed
  std::ofstream(path) << with_stage("{solver = \"pgz\"}");
  SolveResult faulty = ended(SolveStatus::kInvalidInput, solve("auto", p, options));
  EXPECT_TRUE(says(faulty.message, "own.toml:4: "));
  options.parameters["plan"] = (folder / "none.toml").string();
  faulty = ended(SolveStatus::kInvalidInput, solve("auto", p, options));
  EXPECT_TRUE(says(faulty.message, "cannot be read"));
}

}  // namespace
}  // namespace bipot
