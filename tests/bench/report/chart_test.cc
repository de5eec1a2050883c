#include "bench/report/chart.h"

#include "bench/report/program.h"
#include "bench/report/text_lines.h"
#include "core/base/file_error.h"
#include "core/base/types.h"
#include "tests/support/markup_defect.h"
#include "tests/support/source_folder.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

std::size_t count(std::string_view text, std::string_view what) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += what.size()) ++n;
  return n;
}

std::set<std::string> ids(std::string_view svg) {
  std::set<std::string> found;
  for (std::size_t at = 0; (at = svg.find(" id=", at)) != svg.npos; ++at) {
    const std::size_t end = svg.find(svg[at + 4], at + 5);
    found.emplace(svg.substr(at + 5, end - at - 5));
  }
  return found;
}

Chart falling() {
  return Chart{.title = "Error against time",
               .x = {"time", Chart::Axis::Kind::kLogSeconds},
               .y = {"force error [−]", Chart::Axis::Kind::kLog},
               .series = {{"apgd", 0, {{1e-4, 1e-1, false, "loose"}, {1e-2, 1e-5, true, "tight"}}},
                          {"ipm", 1, {{3e-3, 1e-2}, {6e-3, 1e-9}}}}};
}

TEST(Chart, IsWellFormedAndNamesEachSeriesOnce) {
  const std::string svg = to_svg(falling());
  EXPECT_EQ(markup_defect(svg), "");
  EXPECT_EQ(svg.substr(0, 4), "<svg");
  for (const char* text :
       {"<text>apgd</text>", "<text>ipm</text>", "<text>force error [−]</text>"}) {
    EXPECT_EQ(count(svg, text), 1u) << text;
  }
  EXPECT_NE(svg.find("aria-label=\"Error against time\""), svg.npos);
  EXPECT_NE(svg.find("<title>loose</title>"), svg.npos);
  EXPECT_NE(svg.find("<title>tight</title>"), svg.npos);
  // Nothing from elsewhere, no scripts.
  for (const char* foreign : {"http", "script", "onmouse", "xlink"}) {
    EXPECT_EQ(svg.find(foreign), svg.npos) << foreign;
  }
}

TEST(Chart, XmlCheckFindsDefects) {
  EXPECT_EQ(markup_defect("<a b='1'><c/>x &lt; y</a>"), "");
  for (const char* bad : {"<a><b></a></b>", "<a>", "<a b=1/>", "<a>&</a>", "<a b='<'/>",
                          "<a b='1' b='2'/>", "<a>1 < 2</a>"}) {
    EXPECT_NE(markup_defect(bad), "") << bad;
  }
}

TEST(Chart, LabelsSecondsAndPowersOfTen) {
  // Times from 1e-7 to 100 s: every second or every decade, but in units that people say.
  Chart chart = falling();
  chart.series[0].points[0].x = 2e-7;
  chart.series[0].points[1].x = 5;
  const std::string svg = to_svg(chart);
  EXPECT_NE(svg.find(">1 ms<"), svg.npos);
  EXPECT_NE(svg.find(" µs<"), svg.npos);
  EXPECT_EQ(svg.find(" us<"), svg.npos);
  EXPECT_NE(svg.find(">−4</tspan>"), svg.npos);  // 10 with a raised minus four
}

TEST(Chart, ShowsTextsAsTheyAre) {
  Chart chart = falling();
  const std::vector<std::string> names = {"siconos:nsgs",      "μ = 0.3, ε",      "a_b^c{d}",
                                          "`touch /tmp/x`",    "it's 'quoted'",   "\"double\"",
                                          "$(id) @home ~{a}b", "back\\slash \\n", "#1 & <2>"};
  chart.series.clear();
  for (const std::string& name : names) {
    chart.series.push_back({name, 3, {{1e-3, 1e-3, false, "note of " + name}}});
  }
  chart.title = chart.x.label = chart.y.label = "x_1 'and' \"y\" {μ} \\ `z` <&>";
  chart.y_lines = {{1e-4, "line_1 'a'"}};
  const std::string svg = to_svg(chart);
  EXPECT_EQ(markup_defect(svg), "");
  // Entities in the text, > and " at will.
  const auto shown = [&svg](std::string text) {
    const auto replace = [&text](const std::string& from, const std::string& to) {
      for (std::size_t at = 0; (at = text.find(from, at)) != text.npos; at += to.size()) {
        text.replace(at, from.size(), to);
      }
    };
    replace("&", "&amp;");
    replace("<", "&lt;");
    std::string strict = text;
    if (svg.find(">" + text + "<") != svg.npos) return true;
    replace(">", "&gt;");
    return svg.find(">" + text + "<") != svg.npos;
  };
  for (const std::string& name : names) EXPECT_TRUE(shown(name)) << name;
  EXPECT_TRUE(shown(chart.x.label));
  EXPECT_TRUE(shown(chart.y_lines[0].label));
  for (const std::string& name : names) {
    EXPECT_NE(svg.find("<title>" + escape_markup("note of " + name) + "</title>"), svg.npos);
  }
}

TEST(Chart, LiftsWhatALogarithmicAxisCannotShow) {
  // The least positive value is 3e-5: zero and negative ones stand on the decade below it.
  Chart chart = falling();
  chart.series = {{"a", 0, {{1, 0}, {10, 3e-5}, {100, -1}, {1000, 1e-2}}},
                  {"b", 1, {{0, 1e-2}, {kNaN, 1}, {10, kNaN}}}};
  chart.x.kind = Chart::Axis::Kind::kLog;
  // Without notes of its own, a point would name the values that it has.
  const auto noted = [](Chart of) {
    for (Chart::Series& series : of.series) {
      for (Chart::Point& point : series.points) point.note = "a point";
    }
    return of;
  };
  const std::string svg = to_svg(noted(chart));
  EXPECT_EQ(markup_defect(svg), "");
  Chart by_hand = chart;
  by_hand.series = {{"a", 0, {{1, 1e-5}, {10, 3e-5}, {100, 1e-5}, {1000, 1e-2}}},
                    {"b", 1, {{1, 1e-2}}}};
  EXPECT_EQ(to_svg(noted(by_hand)), svg);
}

TEST(Chart, WithoutFiniteValuesIsAnEmptyFrame) {
  for (auto kind : {Chart::Axis::Kind::kLinear, Chart::Axis::Kind::kLog}) {
    Chart chart;
    chart.x.kind = chart.y.kind = kind;
    EXPECT_TRUE(says(to_svg(chart), "no finite values"));
    chart.series = {{"empty", 0, {}}, {"nan", 1, {{kNaN, 1}, {1, kNaN}}}};
    const std::string svg = to_svg(chart);
    EXPECT_EQ(markup_defect(svg), "");
    EXPECT_NE(svg.find("no finite values"), svg.npos);
    EXPECT_NE(svg.find(">empty<"), svg.npos);
    chart.y_lines = {{2, ""}};
    EXPECT_EQ(markup_defect(to_svg(chart)), "");
  }
}

TEST(Chart, TakesASinglePointAndEveryKindOfSeries) {
  Chart chart = falling();
  chart.series = {{"one", 0, {{1e-3, 1e-3}}}};
  EXPECT_EQ(markup_defect(to_svg(chart)), "");
  chart.x.kind = chart.y.kind = Chart::Axis::Kind::kLinear;
  chart.series = {{"one", 0, {{0, 0}}}};
  EXPECT_EQ(markup_defect(to_svg(chart)), "");
  using Kind = Chart::Series::Kind;
  chart.series = {{"line", 1, {{0, 0}, {1, 1}}, Kind::kLine},
                  {"points", 2, {{0, 0, false, "", true, -0.2, 0.2}, {1, 2}}, Kind::kPoints},
                  {"steps", 3, {{0, 0, false, "", false}, {1, 1, true, "here"}}, Kind::kSteps}};
  chart.x_lines = {{0.5, "half"}};
  chart.y_lines = {{1.5, "one and a half"}, {-1, "below all data"}};
  chart.key = Chart::Key::kRight;
  const std::string svg = to_svg(chart);
  EXPECT_EQ(markup_defect(svg), "");
  for (const char* text : {">half<", ">one and a half<", ">below all data<", "<title>here<"}) {
    EXPECT_NE(svg.find(text), svg.npos) << text;
  }
  chart.y.low = 0;  // nothing is written outside the frame
  EXPECT_FALSE(says(to_svg(chart), ">below all data<"));
}

TEST(Chart, HasRoomForErrorBars) {
  // From 0.5 to 300 around 10: three decades and a half need the axis from 10^-1 to 10^3.
  Chart chart;
  chart.y.kind = Chart::Axis::Kind::kLog;
  chart.series = {{"", 0, {{0, 10}, {1, 10, false, "", true, 0.5, 300}}}};
  const std::string svg = to_svg(chart);
  for (const char* power : {">−1</tspan>", ">3</tspan>"}) EXPECT_EQ(count(svg, power), 1u) << power;
}

TEST(Chart, ShowsMarkersOnItsFrame) {
  // The four corners of the ranges, with notes and without, on both kinds of axes.
  for (auto kind : {Chart::Axis::Kind::kLinear, Chart::Axis::Kind::kLog}) {
    for (const char* note : {"", "note"}) {
      Chart chart{
          .x = {"x", kind, 1.0, 100.0},
          .y = {"y", kind, {}, {}},
          .series = {
              {"",
               0,
               {{1, 1, false, note}, {1, 10, false, note}, {100, 1, false, note}, {100, 10}}}}};
      EXPECT_EQ(count(to_svg(chart), "-gpPt6' transform"), 4u) << note;
    }
  }
  Chart single;  // its decade begins where it stands
  single.x = {"x", Chart::Axis::Kind::kLog, {}, {}};
  single.series = {{"", 0, {{100, 0, false, "note"}}}};
  EXPECT_EQ(count(to_svg(single), "-gpPt6' transform"), 1u);
}

TEST(Chart, IsTheSameToTheByteAndItsIdsAreItsOwn) {
  Chart other = falling();
  other.series[0].points[0].y = 0.2;
  const std::string a = to_svg(falling()), b = to_svg(other);
  EXPECT_EQ(to_svg(falling()), a);
  EXPECT_GE(ids(a).size(), 3u);
  for (const std::string& id : ids(a)) EXPECT_EQ(ids(b).count(id), 0u) << id;
  // Every reference has its aim.
  for (std::size_t at = 0; (at = a.find("href='#", at)) != a.npos; ++at) {
    EXPECT_EQ(ids(a).count(a.substr(at + 7, a.find('\'', at + 7) - at - 7)), 1u);
  }
  // One run of gnuplot or many: the same drawings; a second copy has ids of its own.
  const std::vector<std::string> together = to_svg(std::vector<Chart>{falling(), other, falling()});
  ASSERT_EQ(together.size(), 3u);
  EXPECT_EQ(together[0], a);
  EXPECT_EQ(together[1], b);
  for (const std::string& id : ids(together[2])) EXPECT_EQ(ids(a).count(id), 0u) << id;
}

TEST(ChartStyles, DifferInGreyAlso) {
  // Marker (a link) and dashes of the 20 first styles, read from the drawing: no pair twice.
  std::set<std::string> looks;
  for (int style = 0; style < 20; ++style) {
    Chart chart = falling();
    chart.series = {{"s", style, {{1, 1}, {2, 2}}}};
    const std::string svg = to_svg(chart);
    // The key's sample: its line, then its marker.
    const std::size_t marker = svg.rfind("gpPt");
    ASSERT_NE(marker, svg.npos);
    const std::size_t line = svg.rfind("<path", marker);
    const std::size_t dash = svg.find("stroke-dasharray='", line);
    const std::string dashes =
        dash < marker ? svg.substr(dash, svg.find('\'', dash + 18) - dash) : "solid";
    looks.insert(dashes + svg.substr(marker, svg.find('\'', marker) - marker));
  }
  EXPECT_EQ(looks.size(), 20u);
}

TEST(ChartFiles, AreMadeAgainByTheirScript) {
  const TemporaryFolder folder;
  Chart chart = falling();
  chart.title = "A title that is longer than the drawing is wide, so that it needs two lines of it";
  chart.series[0].name = "it's, \"so\"";
  write_chart_files(folder.path(), "figure", chart);
  const std::string svg = file_text(folder / "figure.svg");
  EXPECT_EQ(markup_defect(svg), "");
  for (const char* text : {"it's, \"so\"", ">A title that is longer than the drawing"}) {
    EXPECT_TRUE(says(svg, text)) << text;
  }
  const std::string csv = file_text(folder / "figure.csv");
  EXPECT_TRUE(csv.starts_with("series,x,y,note\n\"it's, \"\"so\"\"\",0.0001,0.1,\"loose\"\n"))
      << csv;
  fs::remove(folder / "figure.svg");
  ASSERT_EQ(std::system(("cd '" + folder.path().string() + "' && gnuplot figure.gp").c_str()), 0);
  EXPECT_EQ(file_text(folder / "figure.svg"), svg);
  EXPECT_THROW(write_chart_files(folder / "nowhere", "figure", chart), FileError);
}

TEST(Gnuplot, MissingOrRefusingIsAFileError) {
  EXPECT_NO_THROW(require_plotting_tool());
  EXPECT_TRUE(
      says(refusal_of<FileError>([&] { run_gnuplot("plot no_such_function(x)\n"); }), "undefined"));
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  EXPECT_TRUE(says(refusal_of<FileError>([&] { require_plotting_tool(); }), "gnuplot-nox"));
  setenv("PATH", path.c_str(), 1);
}

}  // namespace
}  // namespace bipot
