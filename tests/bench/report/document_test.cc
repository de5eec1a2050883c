#include "bench/report/document.h"

#include <nlohmann/json.hpp>

#include "bench/report/labels.h"
#include "bench/report/text_lines.h"
#include "core/base/types.h"
#include "tests/support/markup_defect.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Two solvers; a title row between them; a column for data alone and one for readers alone.
Table solver_table() {
  Table table{.columns = {{"solver", "solver"},
                          {"tol", "tolerance", tolerance_label},
                          {"seconds", "", nullptr},
                          {"", "time", seconds_label, "CPU", "the least of all"}},
              .key = "solvers",
              .note = "See [below](#made)."};
  table.add({"a<b", 1e-6, 0.1 + 0.2, Table::Cell(0.3).tipped("0.3 s \"all\"").as("good")});
  table.add({"others"});
  table.add({"c,\"d\"", kNaN, {}, Table::Cell("never").as("bad")}, "bad", "second");
  return table;
}

Document small_document() {
  Document d{.title = "Solvers & more",
             .made = provenance("compare", "bipot compare <x>"),
             .contents = true};
  d.say("What `a < b` says, **loudly**: see [the end](#made), not [x](http://y).");
  d.heading("First", "first");
  d.add(solver_table());
  Document inside;
  inside.say("hidden");
  d.fold("more of **it**", inside, "folded");
  d.heading("How this was made", "made");
  d.add(to_terms(d.made));
  return d;
}

TEST(TextLines, WordsForAShellAreQuotedWhereTheyMust) {
  EXPECT_EQ(shell_word("data/süß-2.toml:steps=30"), "data/süß-2.toml:steps=30");
  EXPECT_EQ(shell_word("my scene.toml"), "'my scene.toml'");
  EXPECT_EQ(shell_word("it's $1"), "'it'\\''s $1'");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(Document, PageIsWellFormedAndNeedsNoOtherFile) {
  Document d = small_document();
  Chart chart{.title = "t", .series = {{"s", 0, {{1, 1}, {2, 2}}}}};
  d.add(Figure{.chart = chart, .caption = "<one>", .command = "bipot <x>", .source = "x.csv"});
  d.add(Figure{.chart = chart, .file = "two.svg", .caption = "two", .wide = true});
  const std::string page = to_html(d);
  EXPECT_EQ(markup_defect(page), "");
  EXPECT_TRUE(page.starts_with("<!DOCTYPE html>"));
  for (
      const char* part :
      {"<title>Solvers &amp; more</title>", "<code>a &lt; b</code>", "<strong>loudly</strong>",
       "<a href=\"#made\">the end</a>", "[x](http://y)", "<nav><a href=\"#first\">First</a>",
       "<h2 id=\"made\">", "<th class=\"n\" title=\"the least of all\">time [CPU]</th>",
       "<td class=\"n good\" title=\"0.3 s &quot;all&quot;\" data-label=\"time [CPU]\">300 ms</td>",
       "<tr class=\"group\"><td colspan=\"3\">others</td>", "<tr class=\"bad\" id=\"second\">",
       "<details id=\"folded\"><summary>more of <strong>it</strong></summary>",
       "<dd><code>bipot compare &lt;x&gt;</code></dd>", "data: x.csv.",
       "<a href=\"two.svg\">Picture</a>", "<a href=\"two.csv\">data</a>"}) {
    EXPECT_TRUE(says(page, part)) << part;
  }
  for (const char* outside : {"href=\"http", "src=\"http", "@import", "url(//", "<script"}) {
    EXPECT_FALSE(says(page, outside)) << outside;
  }
  EXPECT_EQ(to_html(d), page);
}

TEST(Document, OriginsAreEscaped) {
  Document d{.made = provenance("compare", "bipot compare")};
  d.made.build = {"1.0", "0123abc", "g++ <12>", "-O3", "Release", "a & b", 2};
  d.add(to_terms(d.made));
  const std::string page = to_html(d);
  for (const char* part :
       {"bipot 1.0, commit 0123abc", "g++ &lt;12&gt;", "a &amp; b, 2 logical cores, 1 used"}) {
    EXPECT_TRUE(says(page, part)) << part;
  }
}

TEST(Document, SortableTablesBringTheirScriptAndFilters) {
  Document d = small_document();
  Table rows = solver_table();
  rows.rows.erase(rows.rows.begin() + 1);
  rows.sortable = true;
  rows.columns[0].filter = true;
  d.add(rows);
  const std::string page = to_html(d);
  EXPECT_EQ(markup_defect(page), "");
  EXPECT_TRUE(says(page, "<script>"));
  EXPECT_TRUE(says(page, "<option>a&lt;b</option>"));
  EXPECT_TRUE(says(page, "data-v=\"1e-06\">1e-6</td>"));
}

TEST(Document, TablesAreDataToTheLastBit) {
  EXPECT_EQ(to_csv(solver_table()),
            "solver,tol,seconds\n\"a<b\",1e-06,0.30000000000000004\n\"c,\"\"d\"\"\",nan,\n");
  const Json json = to_json(small_document());
  EXPECT_EQ(json["command"], "compare");
  EXPECT_EQ(json["command_line"], "bipot compare <x>");
  for (const char* key : {"version", "commit", "cpu", "date"}) {
    EXPECT_FALSE(json[key].get<std::string>().empty()) << key;
  }
  ASSERT_EQ(json["solvers"].size(), 2u);
  EXPECT_EQ(json["solvers"][0]["seconds"], 0.1 + 0.2);
  EXPECT_TRUE(json["solvers"][1]["seconds"].is_null());
  EXPECT_FALSE(json["solvers"][0].contains("time"));
}

TEST(Document, TextAlignsColumnsAndFitsTheTerminal) {
  EXPECT_EQ(to_text(solver_table()),
            "solver  tolerance  time [CPU]\n"
            "a<b          1e-6      300 ms\n"
            "others\n"
            "c,\"d\"           –       never\n"
            "See below.\n");
  Table wide{.columns = {{"", "name"}}};
  std::vector<Table::Cell> cells = {"row"};
  for (int k = 0; k < 30; ++k) {
    wide.columns.push_back({"", "column " + std::to_string(k), count_label});
    cells.push_back(k);
  }
  wide.add(cells);
  const std::string text = to_text(wide);
  for (std::size_t begin = 0, end; begin < text.size(); begin = end + 1) {
    end = text.find('\n', begin);
    EXPECT_LE(letters(text.substr(begin, end - begin)), 100u);
  }
  for (int k = 0; k < 30; ++k) EXPECT_TRUE(says(text, "column " + std::to_string(k)));
  cells[1] = 7;  // only this tells the rows apart
  wide.add(cells);
  EXPECT_TRUE(says(to_text(wide), "\n\nname  column 0  column 9"));
  EXPECT_TRUE(says(to_text(small_document()), "What `a < b` says, loudly: see the end, not"));
}

TEST(Document, MarksAreLettersInTextAndNotesOnPagesAreNot) {
  Table table{.columns = {{"", "error"}}, .note = "Note.", .page_note = " Rest the pointer."};
  table.add({Table::Cell("0.1").as("over")});
  EXPECT_EQ(to_text(table), "error\n0.1*\nNote.\n");
  Document page;
  page.add(table);
  EXPECT_TRUE(says(to_html(page), "Note. Rest the pointer."));
}

TEST(Labels, AnOverlapHasTheDigitsOfARun) {
  EXPECT_EQ(overlap_label(0.0504), "5.04 %");
  EXPECT_EQ(overlap_label(0.113), "11.3 %");
}

TEST(Labels, ExponentsHaveOneForm) {
  Table table{
      .columns = {
          {"", "a", tolerance_label}, {"", "b", error_label}, {"", "c", value_label}, {"", "d"}}};
  table.add({1e-6, 7.8e-4, 2.819e-9, 6e7});
  EXPECT_EQ(to_text(table), "   a       b         c  d\n1e-6  7.8e-4  2.819e-9  6e7\n");
}

TEST(TextLines, BreakAtSpacesAndCountLetters) {
  EXPECT_EQ(letters("μ ≤ ½"), 5u);
  EXPECT_EQ(wrapped_lines("ab cd ef\ng", 5), (std::vector<std::string>{"ab cd", "ef", "g"}));
  EXPECT_EQ(wrapped_lines("longer a", 3), (std::vector<std::string>{"longer", "a"}));
}

}  // namespace
}  // namespace bipot
