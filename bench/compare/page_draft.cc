#include "bench/compare/page_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace bipot {

PageContent::PageContent(const Comparison& c, const ReportContext& r)
    : comparison(c),
      report(r),
      solvers(solvers_of(c)),
      tols(tolerances_of(c)),
      growth(bipot::growth(c)),
      success(success_curves(c)) {}

bool PageContent::has_auto() const {
  return solvers.size() > 1 && std::find(solvers.begin(), solvers.end(), "auto") != solvers.end();
}

std::string PageContent::id_of(const ProblemSummary& problem) const {
  return fmt::format("p{}", &problem - comparison.problems.data() + 1);
}

void PageDraft::heading(const std::string& id, const std::string& title) {
  add(fmt::format("<h2 id=\"{}\">{}</h2>\n", escape_markup(id), escape_markup(title)));
}

void PageDraft::figure(Chart chart, const std::string& caption, const std::string& command,
                       const std::string& data) {
  add("<figure>");
  places_.push_back(html_.size());
  charts_.push_back(std::move(chart));
  add(fmt::format(
      "<figcaption>{}<br><span class=\"small\">Made by <code>{}</code>; data: {}.</span>"
      "</figcaption></figure>\n",
      caption, escape_markup(command), data));
}

std::string PageDraft::with_drawings() const {
  const std::vector<std::string> drawings = to_svg(charts_);
  std::string page;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    page.append(html_, begin, places_[i] - begin);
    page += drawings[i];
    begin = places_[i];
  }
  return page.append(html_, begin);
}

}  // namespace bipot
