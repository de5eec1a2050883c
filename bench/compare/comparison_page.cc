#include "bench/compare/comparison_page.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "bench/compare/comparison_several.h"
#include "bench/compare/comparison_success.h"
#include "bench/compare/page_answers.h"
#include "bench/compare/page_draft.h"
#include "bench/compare/page_figures.h"
#include "bench/compare/page_notes.h"
#include "bench/compare/page_problems.h"
#include "bench/compare/page_several.h"
#include "bench/compare/page_table.h"
#include "bench/compare/page_warm.h"
#include "bench/report/chart.h"
#include "bench/report/json_output.h"
#include "bench/report/page_style.h"
#include "core/files/atomic_file.h"

namespace bipot {
namespace {

// Beside the common sheet: tables that are sorted, filtered and read as cards on small screens,
// problems that open and close.
constexpr const char* kRules = R"(
.scroll+.grid{margin-top:1em}
th button{font:inherit;font-weight:bold;background:none;border:0;padding:0;color:inherit;
 cursor:pointer;text-align:inherit}
th[aria-sort=ascending] button::after{content:" \25B2"}
th[aria-sort=descending] button::after{content:" \25BC"}
.filters{display:flex;flex-wrap:wrap;gap:8px 16px;margin:.6em 0}
.filters label{display:flex;flex-direction:column;font-size:.8rem;color:#444}
select,input{font:inherit;padding:.25em;max-width:100%;border:1px solid #999;background:#fff;
 color:inherit}
nav{display:flex;flex-wrap:wrap;gap:.2em 1.2em;margin:1em 0}
details{border-bottom:1px solid #ddd;padding:.35em 0}
summary{overflow-wrap:anywhere}
details[open]>summary{margin-bottom:.4em}
button#open-all{font:inherit;font-size:.87rem}
@media(max-width:620px){table.cards thead{display:none}
 table.cards tr{display:block;border-bottom:1px solid #bbb;padding:.4em 0}
 table.cards td{display:flex;gap:.8em;position:static;border:0;padding:.1em .6em;text-align:left}
 table.cards td:first-child{font-weight:600;font-size:1rem}
 table.cards td[data-label]::before{content:attr(data-label);flex:0 0 5.5em;color:#555}
 #rows td:first-child,#rows th:first-child{min-width:7.5em;max-width:7.5em;
  overflow-wrap:anywhere}}
@media print{.filters,nav,#open-all{display:none}
 figcaption,.small{font-size:8pt}table{font-size:7.5pt}th,td{padding:.15em .3em}#rows{font-size:6pt}
 @page wide{size:landscape;margin:10mm}.wide{page:wide}.grid{grid-template-columns:1fr 1fr}}
)";

void add_contents(PageDraft& page, const PageContent& of,
                  const std::vector<ReportSection>& sections) {
  page.add(
      "<nav><a href=\"#answer\">Fastest, by problem</a><a href=\"#tolerance\">What a tolerance "
      "means</a><a href=\"#several\">Several answers</a><a href=\"#solvers\">Who solves "
      "what</a>");
  if (of.has_auto()) page.add("<a href=\"#auto\">auto</a>");
  if (!of.comparison.warm_rows.empty()) page.add("<a href=\"#warm\">Warm starts</a>");
  if (!of.success.empty()) page.add("<a href=\"#success\">Success</a>");
  if (of.comparison.problems.size() > 1) page.add("<a href=\"#profiles\">Profiles</a>");
  if (!of.growth.empty()) page.add("<a href=\"#growth\">Growth with size</a>");
  for (const ReportSection& section : sections) {
    page.add(fmt::format("<a href=\"#{}\">{}</a>", escape_markup(section.id),
                         escape_markup(section.title)));
  }
  page.add(
      "<a href=\"#problems\">Problems</a><a href=\"#all\">All rows</a><a "
      "href=\"#measures\">What the measures mean</a><a href=\"#made\">How this was "
      "made</a></nav>\n");
}

}  // namespace

std::string to_html(const Comparison& comparison, const ReportContext& context,
                    const std::vector<ReportSection>& sections) {
  const PageContent of(comparison, context);
  PageDraft page;
  page.add(page_head("Contact solvers compared", kRules));
  add_answer(page, of);
  add_contents(page, of, sections);
  add_answer_by_problem(page, of);
  add_tolerance_meaning(page, of);
  add_several(page, of);
  add_solver_summary(page, of);
  add_regret(page, of);
  add_warm_starts(page, of);
  add_success(page, of);
  add_profiles(page, of);
  add_growth(page, of);
  for (const ReportSection& section : sections) {
    page.heading(section.id, section.title);
    page.add(section.html);
  }
  add_problems(page, of);
  add_table(page, of);
  add_measures(page);
  add_provenance(page, of);
  page.add("<script>");
  page.add(table_script());
  page.add("</script>\n");
  page.add(page_end());
  return page.with_drawings();
}

void write_report(const std::filesystem::path& folder, const Comparison& comparison,
                  const ReportContext& context, const std::vector<ReportSection>& sections) {
  write_text_file(folder / "comparison.csv", to_csv(comparison));
  write_text_file(folder / "success.csv", success_csv(success_curves(comparison)));
  write_text_file(folder / "several.csv", several_csv(comparison));
  write_json(to_json(comparison, context), (folder / "comparison.json").string());
  write_text_file(folder / "report.html", to_html(comparison, context, sections));
}

}  // namespace bipot
