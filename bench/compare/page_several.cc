#include "bench/compare/page_several.h"

#include <fmt/format.h>

#include "bench/compare/comparison_several.h"
#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {

void add_several(PageDraft& page, const PageContent& of) {
  const std::vector<SeveralShare> shares = several_shares(of.comparison);
  if (shares.empty()) return;
  page.heading("several", "Several answers");
  page.add(
      "<p>Coulomb's law does not always decide. Two impulses prove it where both are verified to a "
      "guarded error of 1e-9 or better and their velocities are farther apart than a hundred times "
      "what these errors explain. Such a problem is marked †, errors of its rows are distances to "
      "the nearest answer that is known, and digits below the spread say nothing about the body "
      "that one looks at: energies and means over many steps or runs survive, one body's force at "
      "one instant does not. Nobody has looked for all answers: shares are lower bounds.</p>\n<div "
      "class=\"scroll\"><table><thead><tr><th>contacts</th><th class=\"n\">problems</th><th "
      "class=\"n\">several</th><th class=\"n\">velocity, median</th><th class=\"n\">most</th><th "
      "class=\"n\">force, median</th><th class=\"n\">most</th><th class=\"n\">energy, "
      "most</th></tr></thead><tbody>\n");
  for (const SeveralShare& s : shares) {
    page.add(fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{} ({:.0f} %)</td><td "
        "class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
        escape_markup(std::string(s.size)), s.problems, s.several, 100 * s.share(),
        error_label(s.median_velocity), error_label(s.largest_velocity),
        error_label(s.median_force), error_label(s.largest_force), error_label(s.largest_energy)));
  }
  page.add(
      "</tbody></table></div>\n<p class=\"small\">Problems: those with a reference below "
      "1e-9.</p>\n");
  if (shares.back().several == 0) return;
  page.add(
      "<div class=\"scroll\"><table><thead><tr><th>problem</th><th class=\"n\">contacts</th><th "
      "class=\"n\">answers known</th><th class=\"n\">velocities apart</th><th class=\"n\">force on "
      "a body</th><th class=\"n\">dissipated energy</th></tr></thead><tbody>\n");
  for (const ProblemSummary& p : of.comparison.problems) {
    if (!p.several_velocities()) continue;
    page.add(fmt::format(
        "<tr><td><a href=\"#{}\">{}</a></td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
        of.id_of(p), escape_markup(p.name), p.contacts, p.answers, error_label(p.spread.velocity),
        error_label(p.spread.force), error_label(p.spread.energy)));
  }
  page.add(
      "</tbody></table></div>\n<p class=\"small\">Velocities: in the energy norm, over the change "
      "that contacts make. Force on a body: largest difference of a resultant, over the largest "
      "resultant. Energy: of what contacts dissipate. <code>bipot solve FILE --several N</code> "
      "looks for more.</p>\n");
}

}  // namespace bipot
