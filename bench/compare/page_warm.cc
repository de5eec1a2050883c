#include "bench/compare/page_warm.h"

#include <fmt/format.h>

#include "bench/compare/warm_gain.h"
#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {

void add_warm_starts(PageDraft& page, const PageContent& of) {
  const std::vector<WarmGain> gains = warm_gains(of.comparison);
  if (gains.empty()) return;
  page.heading("warm", "What a warm start gains");
  page.add(
      "<p>The same problems from the impulses of the step before (a start that the file or the "
      "scene gives) instead of s = 0. Ratios are medians over the problems that both starts "
      "solved; all other parts of the page are about cold starts.</p>\n<div "
      "class=\"scroll\"><table><thead><tr><th>solver</th><th class=\"n\">tolerance</th><th "
      "class=\"n\">problems</th><th class=\"n\">solved cold</th><th class=\"n\">solved "
      "warm</th><th class=\"n\">time, warm over cold</th><th class=\"n\">iterations, warm over "
      "cold</th></tr></thead><tbody>\n");
  for (const WarmGain& gain : gains) {
    page.add(fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
        escape_markup(gain.solver), tolerance_label(gain.tol), gain.problems, gain.solved_cold,
        gain.solved_warm, ratio_label(gain.time_ratio), ratio_label(gain.iterations_ratio)));
  }
  page.add("</tbody></table></div>\n");
}

}  // namespace bipot
