#include "bench/page/run_page.h"

#include <nlohmann/json.hpp>

#include "core/base/file_error.h"
#include "solvers/simulation/scene_run.h"
#include "tests/support/scene_text.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

const std::string kScene = "title = \"A disk & <a floor>\"" + floor_text(30) + R"(
disks = [{radius = 0.1, density = 1000, position = [0, 0.15]}]
[output]
every = 10
picture = false
)";

void run_into(const fs::path& folder, const std::string& title = "") {
  Scene<2> scene = scene_of(kScene);
  if (!title.empty()) scene.title = title;
  State<2> state = initial_state(scene);
  run_scene(scene, state, {.folder = {.folder = folder, .scene_text = kScene, .program = "test"}});
}

nlohmann::json about(const std::string& page) {
  const std::string mark = "id=\"about\">";
  const std::size_t begin = page.find(mark) + mark.size();
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

TEST(RunPage, HoldsEveryStepOfAShortRun) {
  const TemporaryFolder folder;
  run_into(folder.path());
  const RunPage written = write_run_page(folder.path());
  EXPECT_EQ(written.frames, 31u);
  const std::string page = file_text(written.path);
  EXPECT_EQ(page.size(), written.bytes);
  EXPECT_FALSE(says(page, "{{"));
  EXPECT_TRUE(says(page, "<title>A disk &amp; &lt;a floor&gt;</title>"));
  EXPECT_TRUE(says(page, "<h1>A disk &amp; &lt;a floor&gt;</h1>"));
  EXPECT_FALSE(says(page, "src="));                                  // nothing is loaded
  EXPECT_EQ(page.find("://"), page.find("://github.com/leeoniya"));  // a comment of uPlot
  EXPECT_EQ(page.rfind("://"), page.find("://"));
  EXPECT_TRUE(says(page, "Permission is hereby granted"));  // its licence
  const auto facts = about(page);
  EXPECT_EQ(facts["frames"].size(), 31u);
  EXPECT_EQ(facts["scene"], kScene);
  EXPECT_TRUE(facts["summary"].is_null());  // which the command writes
  EXPECT_EQ(facts["curves"][0]["file"], "ledger");
  EXPECT_EQ(facts["curves"][0]["rows"], 30);
  EXPECT_TRUE(facts["marks"].empty());
}

/// What is filled into a page may look like a mark of it.
TEST(RunPage, ATitleThatLooksLikeAMarkStaysOne) {
  const TemporaryFolder folder;
  run_into(folder / "marks", "{{style}} {{title}} {{about}}");
  run_into(folder / "plain");
  const std::string page = file_text(write_run_page(folder / "marks").path);
  EXPECT_TRUE(says(page, "<h1>{{style}} {{title}} {{about}}</h1>"));
  const auto style_of = [](const std::string& text) {
    const std::size_t begin = text.find("<style>");
    return text.substr(begin, text.find("</style>") - begin);
  };
  EXPECT_EQ(style_of(page), style_of(file_text(write_run_page(folder / "plain").path)));
}

TEST(RunPage, AnOlderRunHasTheFramesOfItsFiles) {
  const TemporaryFolder folder;
  run_into(folder.path());
  fs::remove(folder / "film.bin");
  EXPECT_EQ(write_run_page(folder.path()).frames, 4u);  // 0, 10, 20, 30
}

TEST(RunPage, MarksStepsThatAreUnsolvedOrHaveSeveralAnswers) {
  const TemporaryFolder folder;
  run_into(folder.path());
  std::ofstream(folder / "ledger.csv")
      << "step,time [s],converged,parts\n1,0.01,1,1\n2,0.02,0,1\n3,0.03,1,4\n";
  for (const int sets : {1, 2}) {  // as `solve --several` writes
    const auto found = folder / ("step_" + std::to_string(sets));
    fs::create_directory(found);
    std::ofstream(found / "summary.json")
        << R"({"sets": )" << sets << R"(, "step": )" << sets << R"(, "time": 0.02})";
  }
  write_run_page(folder.path());
  const auto marks = about(file_text(folder / "index.html"))["marks"];
  ASSERT_EQ(marks.size(), 2u);  // parts are no fault
  EXPECT_EQ(marks[0], nlohmann::json::parse(R"(["unsolved", 2.0, 0.02])"));
  EXPECT_EQ(marks[1], nlohmann::json::parse(R"(["several", 2, 0.02])"));
}

TEST(RunPage, ShowsFewerFramesWhereAllAreTooMuchAndSaysSo) {
  const TemporaryFolder folder;
  run_into(folder.path());
  const std::size_t all = write_run_page(folder.path()).bytes;
  // Half of what is left beside the frames: fewer of them.
  const RunPage small = write_run_page(folder.path(), all / 1000);
  EXPECT_LT(small.frames, 31u);
  EXPECT_GE(small.frames, 2u);
  const auto facts = about(file_text(small.path));
  EXPECT_EQ(facts["frames"].size(), small.frames);
  EXPECT_EQ(facts["frames"].back()[0], 30);  // the last one stays
  EXPECT_EQ(facts["notes"][0],
            std::to_string(small.frames) + " of 31 frames are shown: a page has at most 20 MB.");
}

TEST(RunPage, AnUpdateHasWhatCameAfterAStep) {
  const TemporaryFolder folder;
  run_into(folder.path());
  const auto update = nlohmann::json::parse(page_update(folder.path(), 27, true));
  ASSERT_EQ(update["frames"].size(), 3u);
  EXPECT_EQ(update["frames"][0][0], 28);
  EXPECT_EQ(update["steps"].size(), 31u);
  EXPECT_EQ(update["bodies"], 1);
  EXPECT_EQ(update["curves"][0]["all_rows"], 30);
  EXPECT_EQ(update["ended"], true);
  EXPECT_EQ(nlohmann::json::parse(page_update(folder.path(), 30, false))["frames"].size(), 0u);
  EXPECT_TRUE(says(live_run_page(folder.path()), "connect-src 'self'"));
}

TEST(RunPage, AFolderWithoutARunIsRefused) {
  const TemporaryFolder folder;
  EXPECT_THROW(write_run_page(folder.path()), FileError);
}

TEST(RunPage, AScenesKeyLeavesTheFilmOut) {
  const TemporaryFolder folder;
  std::string text = kScene + "page = false\n";
  const Scene<2> scene = scene_of(text);
  EXPECT_FALSE(scene.output.page);
  State<2> state = initial_state(scene);
  run_scene(scene, state, {.folder = {.folder = folder.path(), .scene_text = text, .program = ""}});
  EXPECT_FALSE(fs::exists(folder / "film.bin"));
}

}  // namespace
}  // namespace bipot
