#include "bench/experiments/claim_report.h"

#include <nlohmann/json.hpp>

#include "bench/experiments/paper_item.h"
#include "core/base/file_error.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

Claim number(const std::string& name, double value, const std::string& unit = "") {
  return {.name = name, .measured = value, .unit = unit, .quantity = "meaning of " + name};
}

ClaimReport one_entry(Findings result) {
  ClaimReport::Item entry{.name = "table9",
                          .title = "Table 9: of nothing",
                          .command = "bipot paper --only table9",
                          .status = ClaimReport::Item::Status::kDone,
                          .quick = true,
                          .wall_seconds = 1.5};
  entry.build.commit = "0123abc";
  entry.date = "2002-05-02 12:00 UTC";
  complete(result, entry.command);
  entry.result = std::move(result);
  return {"bipot paper", {entry}, "Made again", "Beside the paper."};
}

TEST(ClaimReport, PlaceholdersBecomeNumbersWithUnits) {
  Findings result{
      .claims = {number("load", 0.123456, "N"), number("contacts", 12345), number("none", NAN)}};
  result.ours = {"The base carries {load} over {contacts} contacts; raw is {none}."};
  complete(result, "bipot paper");
  EXPECT_EQ(result.ours[0],
            "The base carries 0.1235\u00a0N over 12\u202f345 contacts; raw is undefined.");
  EXPECT_EQ(result.claims[0].command, "bipot paper");
}

TEST(ClaimReport, ABarWiderThanHalfTheLimitDecidesNothing) {
  Findings result;
  const Expectation flat = Expectation::between(-5.7, 5.7, 5.7);
  EXPECT_EQ(result.test("a", 0.97, "°", "slope", "below", flat, 2, "seeds").holds, true);
  const Claim& wide = result.test("b", 0.97, "°", "slope", "below", flat, 8, "seeds");
  EXPECT_FALSE(wide.holds.has_value());
  EXPECT_TRUE(says(wide.reason, "wider than half"));
  EXPECT_EQ(result.test("c", 30, "°", "slope", "below", flat, 8, "seeds").holds, false);
}

TEST(ClaimReport, MistakesInAnItemAreRefused) {
  const auto refused = [](Findings result) {
    EXPECT_THROW(complete(result, "c"), std::invalid_argument);
  };
  Findings unknown, open, twice, both;
  unknown.ours = {"no {such} number"};
  refused(unknown);
  open.claims = {number("a", 1)};
  open.ours = {"{a} and {a"};
  refused(open);
  twice.claims = {number("a", 1), number("a", 2)};
  refused(twice);
  both.figures = {{.name = "f"}};  // neither chart nor file
  refused(both);
  both.figures = {{.name = "f", .chart = Chart{}, .file = "f.svg"}};
  refused(both);
}

TEST(ClaimReport, NumbersAreWrittenForReading) {
  EXPECT_EQ(to_text(1.5e-9, "", 4), "1.5e-9");
  EXPECT_EQ(to_text(-2.5, "%", 4), "−2.5\u00a0%");
  EXPECT_EQ(to_text(1000, "", 2), "1000");
  EXPECT_EQ(to_text(1234567, "", 2), "1\u202f234\u202f567");
  EXPECT_EQ(to_text(0, "", 4), "0");
  EXPECT_EQ(to_text(0.26795, "", 3), "0.268");
  EXPECT_EQ(to_text(-INFINITY, "", 3), "−∞");
}

TEST(ClaimReport, ResultsAreReadBackAsTheyWere) {
  Findings result{.paper = "a \"quoted\" sentence",
                  .claims = {number("x", 0.1, "s"), number("nan", NAN)}};
  result.claims[0].holds = false;
  result.claims[0].digits = 7;
  result.claims[0].bar = 0.25;
  result.claims[0].source = "theory";
  Chart chart{.title = "t",
              .x = {"N", Chart::Axis::Kind::kLog, 1.0, {}},
              .y = {"s", Chart::Axis::Kind::kLogSeconds},
              .series = {{"a", 3, {{1, 2, true, "note"}, {2, NAN}, {3, 4, false, "", false}}}}};
  chart.series[0].kind = Chart::Series::Kind::kSteps;
  chart.series[0].points[0].y_low = 1;
  chart.x_lines = {{3, "three"}};
  chart.key = Chart::Key::kRight;
  chart.width = 300;
  chart.y_lines = {{5, ""}};
  result.figures = {{.name = "f", .caption = "c", .chart = chart},
                    {.name = "g", .file = "g.svg", .wide = true, .after = 0}};
  result.tables = {{"t", "caption", "", {"a", "b"}, {{"1", "2"}}}};
  const ClaimReport report = one_entry(result);
  const TemporaryFolder folder;
  const std::string text = json_text(to_json(report));
  EXPECT_TRUE(Json::parse(text)["items"][0]["numbers"][1]["value"].is_null());
  std::ofstream(folder / "results.json") << text;
  ClaimReport again = report;
  again.items = read_items(folder / "results.json");
  EXPECT_EQ(json_text(to_json(again)), text);
  EXPECT_EQ(to_html(to_document(again)), to_html(to_document(report)));
  std::ofstream(folder / "other.json") << "{\"items\": [1]}";
  EXPECT_THROW(read_items(folder / "other.json"), FileError);
  EXPECT_TRUE(read_items(folder / "missing.json").empty());
}

TEST(ClaimPage, MarksChecksAndEscapesMarkup) {
  Findings result{.paper = "P(f/<f>) & so on",
                  .ours = {"see `bipot list <x>`"},
                  .claims = {number("good", 1), number("bad", 2), number("open", 3)}};
  result.claims[0].holds = true;
  result.claims[1].holds = false;
  result.claims[1].command = "bipot run <scene>";
  const ClaimReport report = one_entry(result);
  EXPECT_EQ(report.items[0].checks(), 2);
  EXPECT_EQ(report.items[0].held(), 1);
  const std::string page = to_html(to_document(report));
  EXPECT_TRUE(says(page, "P(f/&lt;f&gt;) &amp; so on"));
  EXPECT_TRUE(says(page, "<code>bipot list &lt;x&gt;</code>"));
  EXPECT_TRUE(says(page, "bipot run &lt;scene&gt;"));
  EXPECT_TRUE(says(page, "✓ holds"));
  EXPECT_TRUE(says(page, "✗ does not hold"));
  EXPECT_TRUE(says(page, "✗ 1 of 2 hold"));
  EXPECT_TRUE(says(page, "0123abc"));
  EXPECT_FALSE(says(page, "<script"));
  EXPECT_FALSE(says(page, "src=\"http"));
}

TEST(ClaimPage, AFailedItemSaysWhy) {
  ClaimReport report = one_entry({});
  report.items[0].status = ClaimReport::Item::Status::kFailed;
  report.items[0].message = "step 3: <stalled>";
  EXPECT_TRUE(says(to_html(to_document(report)), "This item is failed: step 3: &lt;stalled&gt;"));
  EXPECT_FALSE(to_json(report)["all_items_done"].get<bool>());
  EXPECT_TRUE(says(to_html(to_document(report)), "class=\"bad\""));
  report.items[0].status = ClaimReport::Item::Status::kNotRun;
  EXPECT_FALSE(says(to_html(to_document(report)), "class=\"bad\""));
}

TEST(PaperItems, HaveNamesOfTheirOwn) {
  std::set<std::string_view> names;
  for (const PaperItem& item : paper_items()) EXPECT_TRUE(names.insert(item.name).second);
  EXPECT_TRUE(names.contains("table1"));
}

}  // namespace
}  // namespace bipot
