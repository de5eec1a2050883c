#include "bench/compare/page_notes.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/report/page_style.h"

namespace bipot {

void add_measures(PageDraft& page) {
  page.heading("measures", "What the measures mean");
  page.add(R"(<dl>
<dt>tolerance</dt><dd>What the solver was asked for: every solver stops when the guarded error falls below it.</dd>
<dt>guarded</dt><dd>How far the contact law is violated, as energy over energy; recomputed after the solve from the impulses alone. The larger of ε (the gap in the law plus the energy of penetration) and η (the natural map measured in energy).</dd>
<dt>natural map</dt><dd>The relative residual that other codes print, with one scaling for each contact.</dd>
<dt>raw (42)</dt><dd>The plain error in the law without guards; undefined where nothing slides, and blind to penetration.</dd>
<dt>velocity error</dt><dd>Kinetic energy norm of the difference to the reference velocities, over that of the velocity change that contacts make. 1 is as wrong as no contact forces at all.</dd>
<dt>force error</dt><dd>Resultant contact force on a body, largest difference over all bodies, over the largest resultant. Given where the problem knows its bodies.</dd>
<dt>contact force error</dt><dd>Worst single contact force over the largest one; given only where contact forces are unique (a packing usually holds itself in many ways) and the problem is small enough to check.</dd>
<dt>penetration</dt><dd>Overlap that the remaining approach velocity adds in one step, as a fraction of the smallest radius. Given where step and radius are known.</dd>
<dt>energy error</dt><dd>Relative error of the energy that the contacts take out of the free motion.</dd>
<dt>time</dt><dd>CPU time of set-up, iteration and final check on one core; the least of the repeats. A short solve is repeated until its repeats took long enough to be measured. All solvers ran once on a problem of one contact before the first measurement, so that none pays for the start of a library. Waiting for a core that other programs use does not count.</dd>
<dt>wall time</dt><dd>The same without the final check, by the clock on the wall.</dd>
<dt>not tried</dt><dd>The solver was out of time on a smaller problem of the same series at this tolerance or a looser one, or on this problem at a looser one. It counts as not solved.</dd>
<dt>not run again</dt><dd>Said in the words of a row: the solver's path does not depend on the tolerance, and it was out of time at a looser one already; the row shows where it stood then.</dd>
<dt>Pareto</dt><dd>No other row of the problem is both faster and more accurate.</dd>
<dt>reference</dt><dd>Solved to 1e-12, beyond 1000 contacts to 1e-11, or as far as it goes, by auto, newton, ipm and apgd in turn until one gets there and a second one stands below 1e-9; the lowest guarded error is kept; errors below the reference's own accuracy mean nothing.</dd>
<dt>several answers</dt><dd>What was found on the way, attempts and rows, joins the reference where it is exact to 1e-9 and distinct; rows that end near 1e-6 or better far from all of them are first solved on from where they are. True errors are distances to the nearest in velocity.</dd>
</dl>
)");
}

void add_provenance(PageDraft& page, const PageContent& of) {
  page.heading("made", "How this was made");
  page.add("<dl>");
  page.add(page_term("command", "<code>" + escape_markup(of.report.command) + "</code>"));
  page.add(page_terms(of.report.build));
  page.add(page_term(
      "limits",
      fmt::format(
          "{:g} s a solve, {:g} s an attempt at a reference, CPU time; at least {} repeat{} and "
          "{:g} s of them",
          of.report.options.time_limit, of.report.options.reference_time_limit,
          of.report.options.repeat, of.report.options.repeat == 1 ? "" : "s",
          of.report.options.min_time)));
  page.add(page_term("date", of.report.date));
  std::string made;
  std::vector<std::string> commits;
  for (const ComparisonRow& row : of.comparison.rows) {
    if (std::find(commits.begin(), commits.end(), row.commit) == commits.end()) {
      commits.push_back(row.commit);
      made += (made.empty() ? "" : ", ") + escape_markup(row.commit);
    }
  }
  if (commits.size() > 1) page.add(page_term("rows of commits", made));
  page.add(
      "</dl>\n<p class=\"small\">The numbers behind all figures stand beside this page: "
      "comparison.csv (a line a row), history.csv (errors along the solves), success.csv (problems "
      "solved against tolerance), several.csv (problems with several answers) and comparison.json (rows, problems, success, profiles, growth, "
      "regret).</p>\n");
}

}  // namespace bipot
