// The comparison as one self-contained HTML page.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/compare/comparison_charts.h"
#include "bench/compare/comparison_report.h"
#include "bench/report/chart.h"

namespace bipot {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1180px;padding:16px;font:15px/1.5 system-ui,sans-serif;color:#1b1b1b;
 background:#fff}
h1{font-size:1.5rem;line-height:1.2;margin:.4em 0}
h2{font-size:1.2rem;margin:2em 0 .4em;border-bottom:1px solid #ccc;padding-bottom:.2em}
h3{font-size:1rem;margin:1.6em 0 .3em}
p,li{max-width:46em}
code{font:.88em ui-monospace,monospace;background:#f3f3f3;padding:.1em .3em;overflow-wrap:anywhere}
.small{color:#555;font-size:.87rem}
.scroll{overflow-x:auto;border:1px solid #ddd}
table{border-collapse:separate;border-spacing:0;font-variant-numeric:tabular-nums;font-size:.87rem;width:100%}
th,td{padding:.3em .6em;text-align:left;border-bottom:1px solid #e6e6e6;vertical-align:top}
.scroll+.grid{margin-top:1em}
td.n,th.n{text-align:right;white-space:nowrap}
thead th{background:#f3f3f3}
th:first-child,td:first-child{position:sticky;left:0;background:#fff}
thead th:first-child{background:#f3f3f3}
tr.bad td{color:#8a1c00}
tr.bad td:first-child{box-shadow:inset 3px 0 #8a1c00}
th button{font:inherit;font-weight:bold;background:none;border:0;padding:0;color:inherit;
 cursor:pointer;text-align:inherit}
th[aria-sort=ascending] button::after{content:" \25B2"}
th[aria-sort=descending] button::after{content:" \25BC"}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr));gap:12px 28px}
figure{margin:0;break-inside:avoid;min-width:0}
figure svg{display:block;width:100%;max-width:560px;height:auto}
figcaption{font-size:.87rem;color:#333;max-width:560px}
.filters{display:flex;flex-wrap:wrap;gap:8px 16px;margin:.6em 0}
.filters label{display:flex;flex-direction:column;font-size:.8rem;color:#444}
select,input{font:inherit;padding:.25em;max-width:100%;border:1px solid #999;background:#fff;
 color:inherit}
nav{display:flex;flex-wrap:wrap;gap:.2em 1.2em;margin:1em 0}
details{border-bottom:1px solid #ddd;padding:.35em 0}
summary{cursor:pointer;overflow-wrap:anywhere}
details[open]>summary{margin-bottom:.4em}
button#open-all{font:inherit;font-size:.87rem}
dl{display:grid;grid-template-columns:minmax(7em,max-content) 1fr;gap:.3em 1em}
dt{font-weight:600}dd{margin:0;max-width:42em}
@media(max-width:600px){body{padding:10px}dl{display:block}dd{margin:0 0 .5em}
 table.cards thead{display:none}table.cards tr{display:block;border-bottom:1px solid #bbb;padding:.4em 0}
 table.cards td{display:flex;gap:.8em;position:static;border:0;padding:.1em .6em;text-align:left}
 table.cards td:first-child{font-weight:600;font-size:1rem}
 table.cards td[data-label]::before{content:attr(data-label);flex:0 0 5.5em;color:#555}
 #rows td:first-child,#rows th:first-child{min-width:7.5em;max-width:7.5em;overflow-wrap:anywhere}}
@media print{body{max-width:none;padding:0;font-size:10pt}.filters,nav,#open-all{display:none}
 .scroll{overflow:visible;border:0}th:first-child,td:first-child{position:static}
 figcaption,.small{font-size:8pt}table{font-size:7.5pt}th,td{padding:.15em .3em}#rows{font-size:6pt}@page wide{size:landscape;margin:10mm}
 .wide{page:wide}.grid{grid-template-columns:1fr 1fr}
 h2,h3,summary{break-after:avoid}tr{break-inside:avoid}}
)";

constexpr const char* kScript = R"(
(function(){
 const table=document.getElementById('rows'),body=table.tBodies[0];
 const rows=Array.from(body.rows),heads=Array.from(table.tHead.rows[0].cells);
 const value=(row,i)=>row.cells[i].dataset.v!==undefined?row.cells[i].dataset.v
  :row.cells[i].textContent;
 heads.forEach((head,i)=>head.querySelector('button').addEventListener('click',()=>{
  const up=head.getAttribute('aria-sort')!=='ascending';
  heads.forEach(h=>h.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort',up?'ascending':'descending');
  const numeric=head.classList.contains('n');
  rows.sort((a,b)=>{
   let x=value(a,i),y=value(b,i);
   if(!numeric)return up?x.localeCompare(y):y.localeCompare(x);
   x=parseFloat(x);y=parseFloat(y);
   if(isNaN(x))return isNaN(y)?0:1;
   if(isNaN(y))return -1;
   return up?x-y:y-x;
  });
  rows.forEach(r=>body.appendChild(r));
 }));
 const filters=Array.from(document.querySelectorAll('.filters [data-column]'));
 const shown=document.getElementById('shown');
 const apply=()=>{
  let count=0;
  rows.forEach(r=>{
   const ok=filters.every(f=>{
    const want=f.value.trim().toLowerCase();
    if(!want)return true;
    const has=r.cells[+f.dataset.column].textContent.toLowerCase();
    return f.tagName==='SELECT'?has===want:has.includes(want);
   });
   r.hidden=!ok;count+=ok;
  });
  shown.textContent=count+' of '+rows.length+' rows';
 };
 filters.forEach(f=>f.addEventListener('input',apply));
 apply();
 const all=Array.from(document.querySelectorAll('details'));
 document.getElementById('open-all').addEventListener('click',()=>all.forEach(d=>d.open=true));
 const reveal=()=>{
  const aim=location.hash.length>1&&document.getElementById(location.hash.slice(1));
  if(aim&&aim.tagName==='DETAILS'){aim.open=true;aim.scrollIntoView();}
 };
 addEventListener('hashchange',reveal);
 reveal();
})();
)";

std::string accuracy_label(double accuracy) {
  return accuracy >= 1e-3 ? fmt::format("{:g} %", 100 * accuracy) : tolerance_label(accuracy);
}

/// A list of names with counts, most first: "ipm (12), auto (3)".
std::string ranked(const std::map<std::string, int>& counts, std::size_t longest) {
  std::vector<std::pair<int, std::string>> order;
  for (const auto& [name, count] : counts) order.emplace_back(-count, name);
  std::sort(order.begin(), order.end());
  std::string list;
  for (std::size_t i = 0; i < order.size() && i < longest; ++i) {
    list += fmt::format("{}<strong>{}</strong> ({})", i == 0 ? "" : ", ",
                        escape_markup(order[i].second), -order[i].first);
  }
  return list.empty() ? "–" : list;
}

std::string law_label(const PowerLaw& law) {
  if (!std::isfinite(law.exponent)) return "–";
  if (!std::isfinite(law.confidence)) return fmt::format("{:.2f}", law.exponent);
  return fmt::format("{:.2f} ± {:.2f}", law.exponent, law.confidence);
}

class Page {
 public:
  Page(const Comparison& comparison, const ReportContext& context,
       const std::vector<ReportSection>& sections)
      : c_(comparison),
        context_(context),
        sections_(sections),
        solvers_(solvers_of(comparison)),
        tols_(tolerances_of(comparison)),
        growth_(growth(comparison)) {}

  std::string write() {
    add("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
        "<link rel=\"icon\" href=\"data:,\">\n"
        "<title>Contact solvers compared</title>\n<style>");
    add(kStyle);
    add("</style></head><body>\n");
    answer();
    contents();
    answer_by_problem();
    meaning();
    solver_summary();
    regret();
    profiles();
    growth_section();
    for (const ReportSection& section : sections_) {
      heading(section.id, section.title);
      add(section.html);
    }
    problems();
    table();
    measures();
    provenance();
    add("<script>");
    add(kScript);
    add("</script>\n</body></html>\n");
    return with_drawings();
  }

 private:
  void add(std::string_view text) { html_ += text; }

  void heading(const std::string& id, const std::string& title) {
    add(fmt::format("<h2 id=\"{}\">{}</h2>\n", escape_markup(id), escape_markup(title)));
  }

  /// Where a chart will stand; gnuplot draws them all at once in the end.
  void figure(Chart chart, const std::string& caption, const std::string& command,
              const std::string& data) {
    add("<figure>");
    places_.push_back(html_.size());
    charts_.push_back(std::move(chart));
    add(
        fmt::format("<figcaption>{}<br><span class=\"small\">Made by <code>{}</code>; data: "
                    "{}.</span></figcaption></figure>\n",
                    caption, escape_markup(command), data));
  }

  std::string with_drawings() {
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

  static std::string error_word(const Ranking& rank) {
    switch (rank.measure) {
      case Ranking::Measure::kForce:
        return "force";
      case Ranking::Measure::kVelocity:
        return "velocity";
      case Ranking::Measure::kGuarded:
        return "guarded";
    }
    return "";
  }

  void answer() {
    add("<h1>Contact solvers: what accuracy costs</h1>\n");
    if (!c_.complete) add("<p><strong>This comparison was stopped; rows are missing.</strong></p>");
    add(
        fmt::format("<p>{} problems, {} solvers. For each accuracy: on how many problems some "
                    "solver reaches it, which solvers get there first, with the number of "
                    "problems, and the tolerance that they need in the median. Errors are true "
                    "ones, measured against a reference solution.</p>\n",
                    c_.problems.size(), solvers_.size()));
    add("<div class=\"scroll\"><table><thead><tr><th>true error</th><th class=\"n\">reached "
        "on</th><th class=\"n\">tolerance</th><th>fastest on</th></tr></thead><tbody>\n");
    for (double accuracy : kProfileAccuracies) {
      std::map<std::string, int> wins;
      std::vector<double> needed;
      for (const ProblemSummary& p : c_.problems) {
        if (const ComparisonRow* best = fastest_to(p, c_.rows, accuracy)) {
          ++wins[best->solver];
          needed.push_back(best->tol);
        }
      }
      std::sort(needed.begin(), needed.end());
      add(fmt::format(
          "<tr><td>{}</td><td class=\"n\">{} of {}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
          accuracy_label(accuracy), needed.size(), c_.problems.size(),
          needed.empty() ? "–" : tolerance_label(needed[(needed.size() - 1) / 2]),
          ranked(wins, 4)));
    }
    add("</tbody></table></div>\n");
    const Regret r = regret_of(c_, "auto");
    if (!r.entries.empty()) {
      add(
          fmt::format("<p>Without a choice, <strong>auto</strong> takes {} times as long as the "
                      "fastest other solver in the median, and {} in nine cases of ten.</p>\n",
                      ratio_label(r.median),
                      std::isfinite(r.ninth_decile)
                          ? "at most " + ratio_label(r.ninth_decile) + " times as long"
                          : "does not solve all"));
    }
  }

  void contents() {
    add("<nav><a href=\"#answer\">Fastest, by problem</a><a href=\"#tolerance\">What a tolerance "
        "means</a><a href=\"#solvers\">Who solves "
        "what</a>");
    if (has_auto()) add("<a href=\"#auto\">auto</a>");
    if (c_.problems.size() > 1) add("<a href=\"#profiles\">Profiles</a>");
    if (!growth_.empty()) add("<a href=\"#growth\">Growth with size</a>");
    for (const ReportSection& section : sections_) {
      add(fmt::format("<a href=\"#{}\">{}</a>", escape_markup(section.id),
                      escape_markup(section.title)));
    }
    add("<a href=\"#problems\">Problems</a><a href=\"#all\">All rows</a><a "
        "href=\"#measures\">What the measures mean</a><a href=\"#made\">How this was "
        "made</a></nav>\n");
  }

  bool has_auto() const {
    return solvers_.size() > 1 &&
           std::find(solvers_.begin(), solvers_.end(), "auto") != solvers_.end();
  }

  static std::string best_label(const ComparisonRow& best) {
    return fmt::format("<strong>{}</strong> at {}<br>{}", escape_markup(best.solver),
                       tolerance_label(best.tol), seconds_label(best.time()));
  }

  void answer_by_problem() {
    heading("answer", "Fastest, by problem");
    add("<p>Each entry: the fastest solver, the tolerance that it needs for this true error, and "
        "its time.</p>\n<div class=\"scroll\"><table class=\"cards\"><thead><tr><th>problem</th>"
        "<th class=\"n\">contacts</th><th>error in</th>");
    for (double a : kProfileAccuracies) add(fmt::format("<th>to {}</th>", accuracy_label(a)));
    add("</tr></thead><tbody>\n");
    for (const ProblemSummary& p : c_.problems) {
      const Ranking rank = ranking(p, c_.rows);
      add(fmt::format(
          "<tr><td><a href=\"#{}\">{}</a>{}</td><td class=\"n\" data-label=\"contacts\">{}</td>"
          "<td data-label=\"error in\">{}</td>",
          id_of(p), escape_markup(p.name),
          p.several_velocities() ? " †"
          : p.poor_reference()   ? " ‡"
                                 : "",
          p.contacts, error_word(rank)));
      for (double a : kProfileAccuracies) {
        const ComparisonRow* best = fastest_to(p, c_.rows, a);
        add(fmt::format("<td data-label=\"to {}\"><span>{}</span></td>", accuracy_label(a),
                        best == nullptr ? "–" : best_label(*best)));
      }
      add("</tr>\n");
    }
    add("</tbody></table></div>\n"
        "<p class=\"small\">A dash: nothing that was tried got there. † several velocity "
        "solutions, ‡ no reference with a guarded error below 1e-9: ranked by the guarded error, "
        "because a distance to one solution, or to none, says nothing.</p>\n");
  }

  /// Of the problem's part of the page.
  std::string id_of(const ProblemSummary& p) const {
    return fmt::format("p{}", &p - c_.problems.data() + 1);
  }

  void meaning() {
    heading("tolerance", "What a tolerance means");
    add("<p>The true errors of all rows that met a tolerance, whatever the solver.</p>\n<div "
        "class=\"scroll\"><table><thead><tr><th>tolerance</th><th class=\"n\">rows</th><th "
        "class=\"n\">median error</th><th class=\"n\">90 % below</th><th "
        "class=\"n\">worst</th><th>of</th></tr></thead><tbody>\n");
    for (const ToleranceMeaning& m : tolerance_meaning(c_)) {
      add(fmt::format(
          "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
          "class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
          tolerance_label(m.tol), m.rows, error_label(m.median), error_label(m.ninth_decile),
          error_label(m.worst),
          m.rows == 0 ? "–"
                      : escape_markup(m.worst_solver) + " on " + escape_markup(m.worst_problem)));
    }
    add("</tbody></table></div>\n<p class=\"small\">The error in the force on the worst body, or "
        "in "
        "the velocities where a problem does not know its bodies. Problems with several velocity "
        "solutions († above) or without a trusted reference (‡) are left out.</p>\n");
  }

  void solver_summary() {
    heading("solvers", "Who solves what");
    add("<div class=\"scroll\"><table><thead><tr><th>solver</th>");
    for (double tol : tols_) {
      add(fmt::format("<th class=\"n\">solved at {}</th><th class=\"n\">time / best</th>",
                      tolerance_label(tol)));
    }
    add("<th class=\"n\">natural map ≤ 1e-8</th></tr></thead><tbody>\n");
    std::vector<std::vector<SolvedCount>> counts;
    for (double tol : tols_) counts.push_back(count_solved(c_, tol));
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      add(fmt::format("<tr><td>{}</td>", escape_markup(solvers_[s])));
      for (const auto& at_tol : counts) {
        add(fmt::format("<td class=\"n\">{} of {}</td><td class=\"n\">{}</td>", at_tol[s].solved,
                        at_tol[s].problems,
                        std::isfinite(at_tol[s].median_ratio)
                            ? fmt::format("{:.{}f}", at_tol[s].median_ratio,
                                          at_tol[s].median_ratio < 9.95 ? 1 : 0)
                            : "–"));
      }
      add(fmt::format("<td class=\"n\">{} of {}</td></tr>\n", counts.back()[s].by_natural_map,
                      counts.back()[s].problems));
    }
    add("</tbody></table></div>\n<p class=\"small\">Solved: the guarded error, recomputed from the "
        "impulses, is at most the tolerance. time / best: median over the solved problems of the "
        "solver's time over the fastest solver's. Natural map: at the tightest tolerance.</p>\n");
  }

  void regret() {
    if (!has_auto()) return;
    heading("auto", "What it costs to let auto choose");
    const Regret all = regret_of(c_, "auto"), longer = regret_of(c_, "auto", 1e-3);
    add(fmt::format(
        "<p>The time of <code>auto</code> over the time of the fastest other solver "
        "that met the same tolerance on the same problem: {} cases. Below 1, auto is "
        "faster than all others. A case that auto does not solve counts as "
        "infinite.{}</p>\n",
        all.entries.size(),
        all.alone > 0 ? fmt::format(" In {} more, auto alone met the tolerance.", all.alone) : ""));
    if (all.entries.empty()) return;
    add("<div class=\"grid\"><div><div class=\"scroll\"><table><thead><tr><th>cases</th><th "
        "class=\"n\">number</th><th class=\"n\">not solved</th><th class=\"n\">median</th><th "
        "class=\"n\">90 % below</th><th class=\"n\">worst</th></tr></thead><tbody>\n");
    const auto line = [this](const std::string& name, const Regret& r) {
      add(
          fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
                      "class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>\n",
                      name, r.entries.size(), r.failed, ratio_label(r.median),
                      ratio_label(r.ninth_decile), ratio_label(r.worst)));
    };
    line("all", all);
    line("fastest other ≥ 1 ms", longer);
    for (double tol : tols_) {
      Comparison part;
      for (const ComparisonRow& row : c_.rows) {
        if (row.tol == tol) part.rows.push_back(row);
      }
      line("tolerance " + tolerance_label(tol), regret_of(part, "auto"));
    }
    add("</tbody></table></div>\n<h3>The ten worst cases</h3>\n<div class=\"scroll\"><table><thead>"
        "<tr><th>problem</th><th class=\"n\">tolerance</th><th class=\"n\">ratio</th><th "
        "class=\"n\">auto</th><th>fastest other</th></tr></thead><tbody>\n");
    for (std::size_t i = 0; i < all.entries.size() && i < 10; ++i) {
      const Regret::Entry& e = all.entries[i];
      add(
          fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
                      "class=\"n\">{}</td><td>{}, {}</td></tr>\n",
                      escape_markup(e.problem), tolerance_label(e.tol), ratio_label(e.ratio),
                      seconds_label(e.time), escape_markup(e.best), seconds_label(e.best_time)));
    }
    add("</tbody></table></div></div>\n");
    figure(regret_chart({all, longer}, {"all cases", "fastest other at least 1 ms"}),
           "How often auto is within a multiple of the fastest other solver's time.",
           context_.command, "cpu_min of the rows with guarded ≤ tol in comparison.csv");
    add("</div>\n");
  }

  void profiles() {
    if (c_.problems.size() < 2) return;
    const std::size_t total = c_.problems.size();
    heading("profiles", "Performance profiles");
    add("<p>How far up a curve starts at the left: the share of problems on which the solver is "
        "the cheapest. How high it ends at the right: the share that it solves at all, within a "
        "thousand times the least cost. In between, the share solved within that multiple of the "
        "least cost (Dolan and Moré 2002).</p>\n<h3>At a fixed tolerance</h3>\n<div "
        "class=\"grid\">\n");
    for (double tol : tols_) {
      const std::string at = tolerance_label(tol);
      figure(profile_chart(performance_profiles(c_, time_at(c_, tol)), "time",
                           "Time profile at tolerance " + at),
             fmt::format("Time to meet tolerance {}, {} problems.", at, total), context_.command,
             "cpu_min of the rows with guarded ≤ tol in comparison.csv");
      figure(profile_chart(performance_profiles(c_, iterations_at(c_, tol)), "iterations",
                           "Iteration profile at tolerance " + at),
             fmt::format("Iterations to meet tolerance {}, {} problems. An iteration costs much "
                         "more in some solvers than in others.",
                         at, total),
             context_.command, "iterations of the rows with guarded ≤ tol in comparison.csv");
    }
    add("</div>\n<h3>At a fixed true error</h3>\n<p>Time of each solver's cheapest row whose true "
        "error is that small, whatever its tolerance.</p>\n<div class=\"grid\">\n");
    for (double accuracy : kProfileAccuracies) {
      const std::string to = accuracy_label(accuracy);
      figure(profile_chart(performance_profiles(c_, time_to(c_, accuracy)), "time",
                           "Time profile to a true error of " + to),
             fmt::format("Time to a true error of {}, {} problems.", to, total), context_.command,
             "cpu_min and the error of the ranking (ranked_by) in comparison.csv and "
             "comparison.json");
    }
    add("</div>\n<h3>Within a fixed time</h3>\n<p>How the least true error that a solver reaches "
        "within the time is distributed over the problems: the share of problems with an error of "
        "at most that on the axis. Higher is better. Only what the tolerances of this comparison "
        "gave is counted.</p>\n<div class=\"grid\">\n");
    for (double budget : kBudgets) {
      figure(
          budget_chart(errors_within(c_, budget), "Errors within " + seconds_label(budget)),
          fmt::format("True error reached within {}, {} problems.", seconds_label(budget), total),
          context_.command, "cpu_min and the error of the ranking in comparison.csv");
    }
    add("</div>\n");
  }

  void growth_section() {
    if (growth_.empty()) return;
    heading("growth", "Growth with size");
    add("<p>Problems that differ in size alone. Iterations and time are fitted by N<sup>p</sup>, N "
        "the number of disks, over the sizes that the solver solved; p is given with its 95 % "
        "confidence (Student's t), which needs three sizes. Empty markers were not solved and are "
        "not fitted; a solver that was out of time is not tried on larger sizes.</p>\n");
    std::vector<std::string> series;
    for (const Growth& g : growth_) {
      if (series.empty() || series.back() != g.series) series.push_back(g.series);
    }
    for (const std::string& name : series) {
      std::string targets;
      for (const ProblemSummary& p : c_.problems) {
        if (p.series == name) targets += (targets.empty() ? "" : " ") + p.target;
      }
      const std::string replay = fmt::format(fmt::runtime(context_.command_of_target), targets);
      add(fmt::format("<details><summary>{}</summary>\n", escape_markup(name)));
      add("<div class=\"scroll\"><table><thead><tr><th>solver</th>");
      for (double tol : tols_) {
        add(fmt::format("<th class=\"n\">iterations, {0}</th><th class=\"n\">time, {0}</th>",
                        tolerance_label(tol)));
      }
      add("</tr></thead><tbody>\n");
      for (const std::string& solver : solvers_) {
        add(fmt::format("<tr><td>{}</td>", escape_markup(solver)));
        for (double tol : tols_) {
          for (const Growth& g : growth_) {
            if (g.series != name || g.solver != solver || g.tol != tol) continue;
            add(fmt::format("<td class=\"n\">{}</td><td class=\"n\">{}</td>",
                            law_label(g.iterations), law_label(g.time)));
          }
        }
        add("</tr>\n");
      }
      add("</tbody></table></div>\n<div class=\"grid\">\n");
      std::vector<double> shown = {tols_.front()};
      if (tols_.size() > 1) shown.push_back(tols_.back());
      for (double tol : shown) {
        for (GrowthOf quantity : {GrowthOf::kIterations, GrowthOf::kTime}) {
          const bool time = quantity == GrowthOf::kTime;
          figure(growth_chart(growth_, name, tol, quantity),
                 fmt::format("{} at tolerance {}, {}.", time ? "Time" : "Iterations",
                             tolerance_label(tol), escape_markup(name)),
                 replay,
                 fmt::format("{} in comparison.csv, dofs / 3 in comparison.json",
                             time ? "cpu_min" : "iterations"));
        }
      }
      add("</div></details>\n");
    }
  }

  void problems() {
    heading("problems", "Problem by problem");
    add("<p>Open a problem for its diagrams. First: what a solver's time buys; lower left is "
        "better, one line a solver, one marker a tolerance; an empty marker did not meet its "
        "tolerance. Then what a tolerance means: the true error that comes with it. Then how the "
        "guarded error falls along one solve at the tightest tolerance that was run. <button "
        "type=\"button\" id=\"open-all\">Open all</button></p>\n");
    for (const ProblemSummary& p : c_.problems) {
      const ComparisonRow* best = fastest_to(p, c_.rows, 1e-2);
      add(fmt::format(
          "<details id=\"{}\"{}><summary><strong>{}</strong> <span class=\"small\">{} contacts{}"
          "</span></summary>\n",
          id_of(p), c_.problems.size() <= 2 ? " open" : "", escape_markup(p.name), p.contacts,
          best == nullptr ? ""
                          : fmt::format(", to 1 %: {} at {}, {}", escape_markup(best->solver),
                                        tolerance_label(best->tol), seconds_label(best->time()))));
      problem(p);
      add("</details>\n");
    }
  }

  void problem(const ProblemSummary& p) {
    if (!p.defect.empty()) {
      add(fmt::format("<p>Not solved by anyone: {}</p>\n", escape_markup(p.defect)));
      return;
    }
    add(fmt::format(
        "<p class=\"small\">{}. {} contacts, d = {}. Reference by {}, guarded error "
        "{}, natural map {}.{}</p>\n",
        escape_markup(p.origin), p.contacts, p.dim,
        p.reference_solver.empty() ? "nobody" : p.reference_solver,
        error_label(p.reference_guarded), error_label(p.reference_natural_map), uniqueness(p)));
    if (p.contacts == 0) return;
    pareto_sentence(p);
    const Ranking rank = ranking(p, c_.rows);
    const std::string replay = fmt::format(fmt::runtime(context_.command_of_target), p.target);
    const std::string name = escape_markup(p.name);
    const std::string column = rank.measure == Ranking::Measure::kForce      ? "force_error"
                               : rank.measure == Ranking::Measure::kVelocity ? "velocity_error"
                                                                             : "guarded";
    add("<div class=\"grid\">\n");
    figure(work_precision_chart(c_, p), fmt::format("Work and precision, {}.", name), replay,
           "cpu_min and " + column + " in comparison.csv");
    figure(tolerance_chart(c_, p), fmt::format("Error against tolerance, {}.", name), replay,
           "tol and " + column + " in comparison.csv");
    const bool history = std::any_of(c_.histories.begin(), c_.histories.end(),
                                     [&p](const History& h) { return h.problem == p.name; });
    if (history) {
      figure(history_chart(c_, p), fmt::format("Guarded error against iteration, {}.", name),
             replay, "history.csv");
    }
    add("</div>\n");
  }

  static std::string uniqueness(const ProblemSummary& p) {
    if (p.poor_reference()) {
      return " <strong>No trusted reference</strong>: solvers are ranked by the guarded error.";
    }
    if (p.several_velocities()) {
      return fmt::format(
          " <strong>Several velocity solutions</strong>: two solvers below 1e-9 differ by {} in "
          "the "
          "energy norm.",
          error_label(p.velocity_spread));
    }
    if (std::isfinite(p.velocity_spread)) {
      return fmt::format(" Solvers below 1e-9 agree on the velocities to {}.",
                         error_label(p.velocity_spread));
    }
    return " No second solver stands below 1e-9, so nothing is known of other solutions.";
  }

  void pareto_sentence(const ProblemSummary& p) {
    auto best = pareto_rows(p, c_.rows);
    std::sort(best.begin(), best.end(),
              [](const ComparisonRow* a, const ComparisonRow* b) { return a->time() < b->time(); });
    const Ranking rank = ranking(p, c_.rows);
    std::string list;
    for (const ComparisonRow* row : best) {
      list += fmt::format("{}{} at {} ({}, {})", list.empty() ? "" : "; ",
                          escape_markup(row->solver), tolerance_label(row->tol),
                          seconds_label(row->time()), error_label(rank.of(*row)));
    }
    if (!list.empty())
      add(fmt::format("<p>Beaten by none in both time and {}: {}.</p>\n", rank.name(), list));
  }

  void select(int column, const char* label, const std::vector<std::string>& values) {
    add(fmt::format("<label>{}<select data-column=\"{}\"><option value=\"\">all</option>", label,
                    column));
    for (const std::string& v : values) add(fmt::format("<option>{}</option>", escape_markup(v)));
    add("</select></label>");
  }

  void table() {
    add("<section class=\"wide\">");
    heading("all", "All rows");
    add("<div class=\"filters\">");
    std::vector<std::string> names, tols, statuses;
    for (const ProblemSummary& p : c_.problems) names.push_back(p.name);
    for (double tol : tols_) tols.push_back(tolerance_label(tol));
    for (const ComparisonRow& r : c_.rows) {
      if (std::find(statuses.begin(), statuses.end(), r.status) == statuses.end()) {
        statuses.push_back(r.status);
      }
    }
    add("<label>problem contains<input data-column=\"0\" size=\"14\"></label>");
    select(0, "problem", names);
    select(1, "solver", solvers_);
    select(2, "tolerance", tols);
    select(3, "status", statuses);
    select(4, "Pareto", {"yes"});
    add("<span id=\"shown\" class=\"small\" aria-live=\"polite\"></span></div>\n"
        "<div class=\"scroll\"><table id=\"rows\"><thead><tr>");
    struct Head {
      const char* name;
      bool numeric;
    };
    for (const Head& h : {Head{"problem", false},
                          {"solver", false},
                          {"tol", true},
                          {"status", false},
                          {"Pareto", false},
                          {"iterations", true},
                          {"time", true},
                          {"wall time", true},
                          {"of it set-up", true},
                          {"guarded", true},
                          {"natural map", true},
                          {"raw (42)", true},
                          {"velocity error", true},
                          {"force error", true},
                          {"contact force error", true},
                          {"penetration", true},
                          {"energy error", true},
                          {"take-off / stick / slip", false}}) {
      add(fmt::format("<th{}><button type=\"button\">{}</button></th>",
                      h.numeric ? " class=\"n\"" : "", h.name));
    }
    add("</tr></thead><tbody>\n");
    std::vector<const ComparisonRow*> pareto;
    for (const ProblemSummary& p : c_.problems) {
      for (const ComparisonRow* row : pareto_rows(p, c_.rows)) pareto.push_back(row);
    }
    for (const ComparisonRow& r : c_.rows) {
      const auto value = [](double x, const std::string& text) {
        return fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", x, text);
      };
      add(fmt::format("<tr{}><td>{}</td><td>{}</td>", r.solved() ? "" : " class=\"bad\"",
                      escape_markup(r.problem), escape_markup(r.solver)));
      add(value(r.tol, tolerance_label(r.tol)));
      const bool front = std::find(pareto.begin(), pareto.end(), &r) != pareto.end();
      add(fmt::format("<td title=\"{}\">{}</td><td>{}</td>", escape_markup(r.message),
                      escape_markup(r.status), front ? "yes" : ""));
      add(value(r.iterations, std::to_string(r.iterations)));
      add(value(r.time(), seconds_label(r.time())));
      add(value(r.total_min, seconds_label(r.total_min)));
      add(value(r.setup_min, seconds_label(r.setup_min)));
      for (double x : {r.guarded, r.natural_map, r.raw42, r.velocity_error, r.force_error,
                       r.contact_force_error, r.penetration, r.energy_error}) {
        add(value(x, error_label(x)));
      }
      add(fmt::format("<td class=\"n\">{} / {} / {}</td></tr>\n", r.take_off, r.stick, r.slip));
    }
    add("</tbody></table></div>\n<p class=\"small\">Click a heading to sort. The status shows the "
        "solver's own words when the pointer rests on it; rows that did not meet their tolerance "
        "are marked and stay in the table. Printed are the rows that are shown.</p></section>\n");
  }

  void measures() {
    heading("measures", "What the measures mean");
    add(R"(<dl>
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
</dl>
)");
  }

  void provenance() {
    heading("made", "How this was made");
    add("<dl>");
    const auto item = [this](const char* name, const std::string& value) {
      add(fmt::format("<dt>{}</dt><dd>{}</dd>", name, value));
    };
    item("command", "<code>" + escape_markup(context_.command) + "</code>");
    item("program", fmt::format("bipot {}, commit {}", context_.build.version,
                                escape_markup(context_.build.commit)));
    item("compiler", escape_markup(context_.build.compiler));
    item("flags", "<code>" + escape_markup(context_.build.flags) + "</code>");
    item("machine", fmt::format("{}, {} logical cores, 1 used", escape_markup(context_.build.cpu),
                                context_.build.cores));
    item("limits", fmt::format("{:g} s a solve, {:g} s an attempt at a reference, CPU time; at "
                               "least {} repeat{} and {:g} "
                               "s of them",
                               context_.options.time_limit, context_.options.reference_time_limit,
                               context_.options.repeat, context_.options.repeat == 1 ? "" : "s",
                               context_.options.min_time));
    item("date", context_.date);
    std::string made;
    std::vector<std::string> commits;
    for (const ComparisonRow& row : c_.rows) {
      if (std::find(commits.begin(), commits.end(), row.commit) == commits.end()) {
        commits.push_back(row.commit);
        made += (made.empty() ? "" : ", ") + escape_markup(row.commit);
      }
    }
    if (commits.size() > 1) item("rows of commits", made);
    add("</dl>\n<p class=\"small\">The numbers behind all figures stand beside this page: "
        "comparison.csv (a line a row), history.csv (errors along the solves) and comparison.json "
        "(rows, problems, profiles, growth, regret).</p>\n");
  }

  const Comparison& c_;
  const ReportContext& context_;
  const std::vector<ReportSection>& sections_;
  std::vector<std::string> solvers_;
  std::vector<double> tols_;
  std::vector<Growth> growth_;
  std::string html_;
  std::vector<std::size_t> places_;  // of the charts in it
  std::vector<Chart> charts_;
};

}  // namespace

std::string to_html(const Comparison& comparison, const ReportContext& context,
                    const std::vector<ReportSection>& sections) {
  return Page(comparison, context, sections).write();
}

}  // namespace bipot
