#include <nlohmann/json.hpp>

#include "bench/compare/leaderboard_report.h"
#include "core/base/file_error.h"
#include "solvers/solve.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

std::vector<ProblemSource> two_problems() {
  const fs::path folder = source_folder() / "data/problems";
  return expand_targets({(folder / "2d_sliding_cylinder.hdf5").string(),
                         (folder / "2d_triangular_lattice.hdf5").string()});
}

void write_numbers(const fs::path& file, const Vector& s) {
  fs::create_directories(file.parent_path());
  std::ofstream out(file);
  out.precision(17);
  for (const double x : s) out << x << '\n';
}

const Leaderboard::Entry& entry(const Leaderboard& board, const std::string& who,
                                const std::string& problem) {
  for (const Leaderboard::Entry& e : board.entries) {
    if (e.who == who && e.problem == problem) return e;
  }
  throw std::out_of_range(who + problem);
}

TEST(Leaderboard, NamesFamiliesWithoutSizes) {
  EXPECT_EQ(family_of("2d_pour14_200"), "2d_pour");
  EXPECT_EQ(family_of("2d_pile_300_mu03"), "2d_pile");
  EXPECT_EQ(family_of("3d_sphere_pyramid_4"), "3d_sphere_pyramid");
  EXPECT_EQ(family_of("2d_dam_break_s240"), "2d_dam_break");
  EXPECT_EQ(family_of("2d_two_bodies"), "2d_two_bodies");
  EXPECT_EQ(family_of("2d_sliding_cylinder"), "2d_sliding_cylinder");
  EXPECT_EQ(family_of("problem17"), "problem17");
}

// An exact impulse, one that is 1 % too large, a missing and a broken one.
TEST(Leaderboard, JudgesWhatIsThereAndSaysWhatIsNot) {
  const TemporaryFolder folder;
  for (const ProblemSource& source : two_problems()) {
    const Vector s = solve("ipm", source.load().problem, {.tol = 1e-11}).s;
    const std::string name = source.name + ".csv";
    write_numbers(folder / "exact" / name, s);
    if (name[3] == 's') write_numbers(folder / "rough" / name, 1.01 * s);
    write_numbers(folder / "short" / name, s.head(1));
  }
  std::ofstream(folder / "exact" / "times.csv") << "problem,seconds\n2d_sliding_cylinder,0.25\n";
  const Leaderboard board =
      make_leaderboard({folder / "exact", folder / "rough/", folder / "short"}, two_problems(),
                       {.solvers = {"pgs"}});
  EXPECT_EQ(board.who, (std::vector<std::string>{"exact", "rough", "short", "bipot pgs"}));
  EXPECT_EQ(board.entries.size(), 8u);
  const std::string slide = "2d_sliding_cylinder", rest = "2d_triangular_lattice";
  EXPECT_TRUE(entry(board, "exact", slide).solves(1e-9));
  EXPECT_EQ(entry(board, "exact", slide).seconds, 0.25);
  EXPECT_TRUE(std::isnan(entry(board, "exact", rest).seconds));
  EXPECT_GT(entry(board, "rough", slide).guarded, 1e-4);
  EXPECT_EQ(entry(board, "rough", rest).defect, "no impulse");
  EXPECT_FALSE(entry(board, "rough", rest).solves(1));
  EXPECT_FALSE(entry(board, "short", rest).defect.empty());
  EXPECT_TRUE(entry(board, "bipot pgs", rest).solves(1e-6));
  const std::string text = to_text(leaderboard_document(board, Provenance{}));
  EXPECT_TRUE(says(text, "Solved, of 2 problems"));
  EXPECT_TRUE(says(text, "2d_triangular_lattice"));  // a family
  EXPECT_TRUE(says(text, "were asked for 1e-6.")) << text;
  // One of two impulses of "rough" and one of two times of "exact" are missing: infinite medians.
  const Json table = to_json(leaderboard_document(board, Provenance{}))["solved"];
  EXPECT_EQ(table[1]["error"], kInfinity);
  EXPECT_LT(table[0]["error"], 1e-9);
  EXPECT_EQ(table[0]["seconds"], kInfinity);
}

TEST(Leaderboard, CallsContestantsByTheWholeNamesOfTheirFolders) {
  const TemporaryFolder folder;
  for (const char* name : {"team.v1", "team.v2", "problems"}) {
    write_numbers(folder / name / "2d_sliding_cylinder.csv", Vector{{1, 0.1}});
  }
  const Leaderboard board =
      make_leaderboard({folder / "team.v1", folder / "team.v2/."}, two_problems(), {});
  EXPECT_EQ(board.who, (std::vector<std::string>{"team.v1", "team.v2"}));
  EXPECT_THROW(make_leaderboard({folder / "problems"}, two_problems(), {}), std::invalid_argument);
}

TEST(Leaderboard, ReadsTimesWithEndsOfWindowsAndWithoutTheLastEnd) {
  const TemporaryFolder folder;
  write_numbers(folder / "one" / "2d_sliding_cylinder.csv", Vector{{1, 0.1}});
  for (const char* text : {"problem,seconds\r\n2d_sliding_cylinder,0.25\r\n",
                           "problem,seconds\n2d_sliding_cylinder,0.25"}) {
    std::ofstream(folder / "one" / "times.csv") << text;
    const Leaderboard board = make_leaderboard({folder / "one"}, two_problems(), {});
    EXPECT_EQ(entry(board, "one", "2d_sliding_cylinder").seconds, 0.25) << text;
  }
  std::ofstream(folder / "one" / "times.csv") << "problem, seconds\n2d_sliding_cylinder, 0.25\n";
  EXPECT_TRUE(says(refusal_of([&] { make_leaderboard({folder / "one"}, two_problems(), {}); }),
                   "expected the names problem,seconds"));
}

TEST(Leaderboard, EndsWithTheLastWholeProblemWhenInterrupted) {
  int asked = 0;
  const Leaderboard board =
      make_leaderboard({}, two_problems(),
                       {.solvers = {"pgs"},
                        .watch = {.interrupted = [&] { return asked > 0; },
                                  .progress = [&](long, long, const std::string&) { ++asked; }}});
  EXPECT_FALSE(board.complete);
  EXPECT_EQ(board.problems, std::vector<std::string>{"2d_sliding_cylinder"});
  ASSERT_EQ(board.entries.size(), 1u);
  EXPECT_TRUE(board.entries[0].solves(1e-6));
}

TEST(Leaderboard, RefusesFoldersThatAreNoContestants) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "empty");
  const auto refused = [&](const std::vector<fs::path>& folders) {
    return refusal_of([&] { make_leaderboard(folders, two_problems(), {}); });
  };
  EXPECT_TRUE(says(refused({folder / "nowhere"}), "no such folder"));
  EXPECT_TRUE(says(refused({folder / "empty"}), "no impulse of these problems"));
  write_numbers(folder / "one" / "2d_sliding_cylinder.csv", Vector{{1, 0.1}});
  EXPECT_TRUE(says(refused({folder / "one", folder / "one"}), "two contestants are called one"));
  std::ofstream(folder / "one" / "times.csv") << "problem,seconds\n2d_sliding_cylinder,soon\n";
  EXPECT_TRUE(says(refused({folder / "one"}), "'soon' is no time in seconds"));
  const auto times = [&](const std::string& problem) {
    std::ofstream(folder / "one" / "times.csv") << "problem,seconds\n" << problem << ",1\n";
    return refused({folder / "one"});
  };
  EXPECT_TRUE(says(times("2d_sliding_cilinder"), "none of the problems and has no impulse"));
  // Another problem that was solved, and one of these that was not.
  write_numbers(folder / "one" / "3d_other.csv", Vector{{1}});
  EXPECT_TRUE(says(times("3d_other"), "nothing was thrown"));
  EXPECT_TRUE(says(times("2d_triangular_lattice"), "nothing was thrown"));
}

}  // namespace
}  // namespace bipot
