// Every row of the table ends when it is told to, by its caller or by the clock, on a problem of
// 10 000 contacts; lemke and multistart on the largest one that they take, and solvers that are
// deaf in their calls on a small one.

#include "solvers/registry.h"
#include "solvers/solve.h"
#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/machine_slowness.h"
#include "tests/support/siconos_limits.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"
#include "tests/support/test_name.h"

namespace bipot {
namespace {

// 0.2 s from the word to the answer, on a machine of the speed for which they were asked.
double usual_patience() { return 0.2 * BIPOT_TEST_SLOWNESS * machine_slowness(); }  // [s]

/// The time of this process: the wall's, or the CPU's where other processes took part of that.
class Timer {
 public:
  double seconds() const {
    const double cpu = static_cast<double>(std::clock() - cpu_) / CLOCKS_PER_SEC;
    const double wall = std::chrono::duration<double>(Clock::now() - wall_).count();
    return std::min(cpu, wall);
  }
  void restart() { *this = Timer(); }

 private:
  using Clock = std::chrono::steady_clock;
  std::clock_t cpu_ = std::clock();
  Clock::time_point wall_ = Clock::now();
};

/// A caller who says stop after `patience` seconds or kQuestions questions, and who keeps the
/// longest time that a solver let pass between two of its questions: a stop at any moment before is
/// noticed within that time.
class Caller {
 public:
  explicit Caller(double patience) : patience_(patience) {}
  bool stop() {
    notice();
    return ++questions_ >= kQuestions || since_start_.seconds() >= patience_;
  }
  /// At the end of the solve; the longest silence, the last one included.
  double longest_silence() {
    notice();
    return longest_;
  }

 private:
  void notice() {
    longest_ = std::max(longest_, since_question_.seconds());
    since_question_.restart();
  }
  static constexpr int kQuestions = 60;  // before the quickest solver is at round-off
  double patience_, longest_ = 0;
  int questions_ = 0;
  Timer since_start_, since_question_;
};

/// A solver that is as exact as doubles allow before the caller or the clock stops it ends there, as
/// does load_path, which has one iteration, and a deaf one whose call returned without progress.
bool has_ended(const SolveResult& r, const std::string& solver) {
  return r.status == SolveStatus::kStalled &&
         (r.message.find("as exact as doubles allow") != std::string::npos ||
          (solver == "load_path" && r.message.find("no path of the load") != std::string::npos) ||
          (kDeafInACall.contains(solver) &&
           r.message.find("Siconos makes no progress") != std::string::npos));
}

/// A solver of the table, or "ppa around" one; and whether the problem comes as W alone.
using Row = std::tuple<std::string, bool>;

std::vector<std::string> row_names() {
  std::vector<std::string> names = all_solver_names();
  for (const char* inner : {"apgd", "newton", "ipm"}) {
    if (find_solver(inner) != nullptr) names.push_back(std::string("ppa around ") + inner);
  }
  return names;
}

class EveryRow : public testing::TestWithParam<Row> {
 protected:
  void SetUp() override {
    const auto& [name, local] = GetParam();
    const std::string_view around = "ppa around ";
    const bool is_ppa = name.starts_with(around);
    entry_ = &require_solver(is_ppa ? "ppa" : name);
    if (is_ppa) options_.parameters["inner"] = name.substr(around.size());
    const bool deaf = kDeafInACall.contains(name);
    if (deaf) patience_ = 60;
    int side = deaf ? 6 : entry_->max_contacts < 10000 ? 10 : 58;
    problem_ = triangular_lattice(side, {.tilt = 0.1});
    for (; problem_.num_contacts() > entry_->max_contacts; --side) {
      problem_ = triangular_lattice(side - 1, {.tilt = 0.1});
    }
    ASSERT_GT(problem_.num_contacts(), 50);
    if (side == 58) {
      ASSERT_NEAR(problem_.num_contacts(), 10000, 200);
    }
    if (local) problem_ = local_form(problem_);
    // Not met by anyone. auto gives up tolerances far below the rounding.
    options_.tol = name == "auto" ? 5e-13 : 1e-15;
    // What happens once in a process (PETSc's start) is not measured here.
    SolverOptions warm_up = options_;
    warm_up.max_iterations = 1;
    solve(*entry_, triangular_lattice(3), warm_up);
  }

  const SolverEntry* entry_ = nullptr;
  double patience_ = usual_patience();  // [s]
  ContactProblem problem_;
  SolverOptions options_;
};

TEST_P(EveryRow, IsInterruptedAtOnce) {
  // A machine that does other things at the same time only adds to it: the best of a few counts.
  double silence = kInfinity;
  for (int attempt = 0; attempt < 6 && silence > patience_; ++attempt) {
    Caller caller(0.3 * BIPOT_TEST_SLOWNESS);
    options_.cancelled = [&caller] { return caller.stop(); };
    const SolveResult r = solve(*entry_, problem_, options_);
    silence = std::min(silence, caller.longest_silence());
    if (has_ended(r, std::get<0>(GetParam()))) continue;
    ASSERT_EQ(r.status, SolveStatus::kInterrupted) << to_string(r.status) << ": " << r.message;
    EXPECT_TRUE(says(r.message, "interrupted"));
  }
  RecordProperty("silence", std::to_string(silence));
  EXPECT_LE(silence, patience_);
}

TEST_P(EveryRow, KeepsToItsTime) {
  options_.time_limit = 0.05;
  double seconds = kInfinity;
  for (int attempt = 0; attempt < 6 && seconds > options_.time_limit + patience_; ++attempt) {
    const Timer timer;
    const SolveResult r = solve(*entry_, problem_, options_);
    seconds = std::min(seconds, timer.seconds());
    if (has_ended(r, std::get<0>(GetParam()))) continue;
    ASSERT_EQ(r.status, SolveStatus::kTimeLimit) << to_string(r.status) << ": " << r.message;
  }
  RecordProperty("seconds", std::to_string(seconds));
  EXPECT_LE(seconds, options_.time_limit + patience_);
}

/// Of a cubic lattice, whose last front is full: between two judgements the caller is asked more
/// often than solvers ask by themselves.
TEST(Interrupt, ComesThroughWithinAFactorisation) {
  const ContactProblem p = cubic_lattice(15, {.mu = 0.4, .tilt = 0.1});
  for (const char* solver : {"ipm", "pdas", "ptc", "admm"}) {
    int questions = 0;
    SolverOptions options{.tol = 1e-9};
    options.on_iteration = [&](const IterationRecord&) { questions = 0; };
    options.cancelled = [&] { return ++questions > 7; };
    const SolveResult r = ended(SolveStatus::kInterrupted, solve(solver, p, options), solver);
    EXPECT_TRUE(says(r.message, "interrupted")) << solver << ": " << r.message;
    EXPECT_LE(r.iterations, 1) << solver;
    EXPECT_TRUE(r.s.allFinite()) << solver;
  }
}

INSTANTIATE_TEST_SUITE_P(Table, EveryRow,
                         testing::Combine(testing::ValuesIn(row_names()), testing::Bool()),
                         [](const auto& row) {
                           return test_name(std::get<0>(row.param)) +
                                  (std::get<1>(row.param) ? "_LocalForm" : "_WithBodies");
                         });

}  // namespace
}  // namespace bipot
