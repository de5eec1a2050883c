#include "bench/command/progress_bar.h"

#include <thread>

#include "bench/command/run_progress.h"
#include "bench/report/text_lines.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

TEST(RemainingTime, FollowsTheTrendOfTheCost) {
  ProgressBar::RemainingTime even(1000), growing(1000), once(1000);
  for (long k = 1; k <= 500; ++k) {
    even.add(k, 0.1 * static_cast<double>(k));
    growing.add(k, 0.0005 * static_cast<double>(k * k));  // the cost of a step is 0.001 k
  }
  EXPECT_NEAR(even.seconds(), 50, 0.1);
  // 0.0005 (1000² - 500²) = 375; an even cost would say 125.
  EXPECT_NEAR(growing.seconds(), 375, 8);
  EXPECT_EQ(once.seconds(), 0);  // nothing is known
  once.add(10, 2);
  EXPECT_NEAR(once.seconds(), 198, 1e-9);
}

TEST(RemainingTime, StaysWithinTwiceTheRecentCost) {
  ProgressBar::RemainingTime steep(1000);
  steep.add(1, 0);
  steep.add(6, 0.1);
  steep.add(11, 10.1);
  EXPECT_NEAR(steep.seconds(), 2 * 10.1 / 11 * 989, 20);
}

TEST(ProgressLine, FitsTheTerminalAndControlsNothing) {
  const std::string note = "t = 0.41 s, 3 unsolved, error 1.0e-03\x1b[31m";
  for (const int columns : {20, 40, 80, 200}) {
    const std::string line = progress_line(400, 1000, 75, note, columns);
    EXPECT_LT(static_cast<int>(letters(line)), columns);
    EXPECT_EQ(line.find('\x1b'), std::string::npos);
  }
  EXPECT_TRUE(says(progress_line(400, 1000, 75, note, 40), "40 %  about 75 s  t = 0.41"));
  EXPECT_EQ(progress_line(0, 9, kNaN, "t = 0", 40), "[........] 0 %  t = 0");
}

TEST(RunProgress, TellsOfAStepThatTakesLong) {
  const TemporaryFolder folder;
  const auto times = [](const std::string& text) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = text.find("error 2.0e-03, tol", at) + 1) > 0;) ++found;
    return found;
  };
  const Stopwatch watch;
  testing::internal::CaptureStderr();
  {
    RunProgress progress(100, {.folder = folder.path(),
                               .step = 6,
                               .time = 0.25,
                               .tol = 1e-8,
                               .hint = "give up",
                               .patience = 0.05});
    progress.judged({.iteration = 7, .error = {.epsilon = 1e-9, .eta = 1e-9}});  // of a part
    progress.judged({.iteration = 0, .error = {.epsilon = 2e-3, .eta = 1e-3}});
    progress.judged({.iteration = 1, .error = {.epsilon = 0.5, .eta = 1e-3}});
    while (times(file_text(folder / "run.log")) < 2 && watch.seconds() < 60) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  const double seconds = watch.seconds();
  for (const std::string& told :
       {testing::internal::GetCapturedStderr(), file_text(folder / "run.log")}) {
    EXPECT_GE(times(told), 2u);
    const std::string begin = "step 7 at t = 0.25 s: ";
    const std::size_t at = told.rfind(begin);
    ASSERT_NE(at, std::string::npos);
    std::size_t digits = 0;
    EXPECT_LE(std::stod(told.substr(at + begin.size()), &digits), seconds + 0.5);
    EXPECT_TRUE(told.substr(at + begin.size() + digits)
                    .starts_with(" s so far, best error 2.0e-03, tolerance 1e-8\n"));
    EXPECT_EQ(told.find("give up"), told.rfind("give up"));
    EXPECT_GE(std::count(told.begin(), told.end(), '\n'), 3);
  }
}

TEST(HelpText, ReasonsAreShort) {
  EXPECT_EQ(short_reason("stages: pgs 9: stalled (1.0e-02); admm 5: given up (3.0e-03); ipm 7: "
                         "stalled (2.0e-03)"),
            "3 stages, the last ipm 7: stalled (2.0e-03)");
  EXPECT_EQ(short_reason("no start"), "no start");
  EXPECT_LE(letters(short_reason(std::string(1000, 'x'))), 242u);
}

}  // namespace
}  // namespace bipot
