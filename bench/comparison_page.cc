// The comparison as one self-contained HTML page.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bench/comparison_report.h"
#include "bench/chart.h"
#include "solvers/registry.h"

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
dl{display:grid;grid-template-columns:minmax(7em,max-content) 1fr;gap:.3em 1em}
dt{font-weight:600}dd{margin:0;max-width:42em}
@media(max-width:600px){body{padding:10px}dl{display:block}dd{margin:0 0 .5em}
 #answer thead{display:none}#answer tr{display:block;border-bottom:1px solid #bbb;padding:.4em 0}
 #answer td{display:flex;gap:.8em;position:static;border:0;padding:.1em .6em;text-align:left}
 #answer td:first-child{font-weight:600;font-size:1rem}
 #answer td[data-label]::before{content:attr(data-label);flex:0 0 5.5em;color:#555}
 #rows td:first-child,#rows th:first-child{min-width:7.5em;max-width:7.5em;overflow-wrap:anywhere}}
@media print{body{max-width:none;padding:0;font-size:10pt}.filters{display:none}
 .scroll{overflow:visible;border:0}th:first-child,td:first-child{position:static}
 table{font-size:7.5pt}th,td{padding:.15em .3em}#rows{font-size:6pt}@page wide{size:landscape;margin:10mm}
 .wide{page:wide}.grid{grid-template-columns:1fr 1fr}
 h2,h3{break-after:avoid}tr{break-inside:avoid}}
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
})();
)";

std::string seconds(double s) {
  if (!std::isfinite(s)) return "–";
  if (s < 1e-3) return fmt::format("{:.3g} µs", s * 1e6);
  if (s < 1) return fmt::format("{:.3g} ms", s * 1e3);
  return fmt::format("{:.3g} s", s);
}

std::string small_number(double x) {
  return std::isfinite(x) ? fmt::format("{:.1e}", x) : std::isnan(x) ? "–" : "∞";
}

std::string accuracy_label(double accuracy) {
  return accuracy >= 1e-3 ? fmt::format("{:g} %", 100 * accuracy) : tolerance_label(accuracy);
}

const char* kReplay = "<br><span class=\"small\">Made by <code>{}</code></span>";

/// A solver keeps its marker in all figures of all reports of a build.
int style_of(const std::string& solver) {
  const auto names = solver_names();
  return static_cast<int>(std::find(names.begin(), names.end(), solver) - names.begin());
}

class Page {
 public:
  Page(const Comparison& comparison, const ReportContext& context)
      : c_(comparison), context_(context) {
    for (const ComparisonRow& row : c_.rows) {
      if (std::find(solvers_.begin(), solvers_.end(), row.solver) == solvers_.end()) {
        solvers_.push_back(row.solver);
      }
      if (std::find(tols_.begin(), tols_.end(), row.tol) == tols_.end()) tols_.push_back(row.tol);
    }
    std::sort(tols_.begin(), tols_.end(), std::greater<>());
  }

  std::string write() {
    add("<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
        "<link rel=\"icon\" href=\"data:,\">\n"
        "<title>Contact solvers compared</title>\n<style>");
    add(kStyle);
    add("</style></head><body>\n");
    answer();
    solver_summary();
    profiles();
    problems();
    table();
    measures();
    provenance();
    add("<script>");
    add(kScript);
    add("</script>\n</body></html>\n");
    return std::move(html_);
  }

 private:
  void add(std::string_view text) { html_ += text; }

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
    const double goal = 1e-2;
    std::map<std::string, int> wins;
    int answered = 0;
    for (const ProblemSummary& p : c_.problems) {
      if (const ComparisonRow* best = fastest_to(p, c_.rows, goal)) {
        ++wins[best->solver];
        ++answered;
      }
    }
    if (!c_.complete) add("<p><strong>This comparison was stopped; rows are missing.</strong></p>");
    std::vector<std::pair<int, std::string>> order;
    for (const auto& [solver, count] : wins) order.emplace_back(-count, solver);
    std::sort(order.begin(), order.end());
    std::string winners;
    for (std::size_t i = 0; i < order.size() && i < 4; ++i) {
      winners += fmt::format("{}<strong>{}</strong> ({})", i == 0 ? "" : ", ",
                             escape_markup(order[i].second), -order[i].first);
    }
    add(
        fmt::format("<p>Of {} problems, {} were solved to an error of 1&nbsp;% by some solver. "
                    "Fastest there: {}. Each entry below names the fastest solver, the tolerance "
                    "that it needs for this accuracy, and its time.</p>\n",
                    c_.problems.size(), answered, winners.empty() ? "none" : winners));
    add("<div class=\"scroll\"><table id=\"answer\"><thead><tr><th>problem</th>"
        "<th class=\"n\">contacts</th><th>error in</th>");
    const std::vector<double> accuracies = {1e-1, 1e-2, 1e-4, 1e-6, 1e-8};
    for (double a : accuracies) add(fmt::format("<th>to {}</th>", accuracy_label(a)));
    add("</tr></thead><tbody>\n");
    for (const ProblemSummary& p : c_.problems) {
      const Ranking rank = ranking(p, c_.rows);
      add(fmt::format(
          "<tr><td>{}{}</td><td class=\"n\" data-label=\"contacts\">{}</td><td data-label=\"error "
          "in\">{}</td>",
          escape_markup(p.name), p.several_velocities() ? " †" : "", p.contacts, error_word(rank)));
      for (double a : accuracies) {
        const ComparisonRow* best = fastest_to(p, c_.rows, a);
        if (best == nullptr) {
          add(fmt::format("<td data-label=\"to {}\">–</td>", accuracy_label(a)));
        } else {
          add(fmt::format(
              "<td data-label=\"to {}\"><span><strong>{}</strong> at {}<br>{}</span></td>",
              accuracy_label(a), escape_markup(best->solver), tolerance_label(best->tol),
              seconds(best->total_min)));
        }
      }
      add("</tr>\n");
    }
    add("</tbody></table></div>\n"
        "<p class=\"small\">A dash: nothing that was tried got there. † several velocity "
        "solutions: "
        "ranked by the guarded error, because a distance to one of them says nothing. Errors are "
        "against a reference solution, not against the tolerance.</p>\n");
  }

  void solver_summary() {
    add("<h2>Who solves what</h2>\n<div class=\"scroll\"><table><thead><tr><th>solver</th>");
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

  void profiles() {
    if (c_.problems.size() < 2) return;
    add("<h2>Performance profiles</h2>\n<p>How far up a curve starts at the left: the share of "
        "problems on which the solver is the fastest. How high it ends at the right: the share "
        "that "
        "it solves at all. In between, the share solved within that multiple of the fastest "
        "solver's time (Dolan and Moré 2002).</p>\n<div class=\"grid\">\n");
    for (double tol : tols_) {
      const int total = static_cast<int>(c_.problems.size());
      std::map<std::string, std::vector<double>> ratios;
      double largest = 10;
      for (const ProblemSummary& p : c_.problems) {
        double best = std::numeric_limits<double>::infinity();
        const auto counts = [&](const ComparisonRow& r) {
          return r.problem == p.name && r.tol == tol && r.solved() && r.total_min > 0;
        };
        for (const ComparisonRow& r : c_.rows) {
          if (counts(r)) best = std::min(best, r.total_min);
        }
        for (const ComparisonRow& r : c_.rows) {
          if (!counts(r)) continue;
          ratios[r.solver].push_back(r.total_min / best);
          largest = std::max(largest, r.total_min / best);
        }
      }
      Chart chart;
      chart.title = fmt::format("Performance profile at tolerance {}", tolerance_label(tol));
      chart.x = {"time over the fastest solver's", ChartAxis::Kind::kLog, 1.0,
                 std::pow(10, std::ceil(std::log10(largest)))};
      chart.y = {"share of problems solved", ChartAxis::Kind::kLinear, 0.0, 1.0};
      for (const std::string& solver : solvers_) {
        ChartSeries series{solver, style_of(solver), {}};
        std::vector<double>& x = ratios[solver];
        std::sort(x.begin(), x.end());
        double share = 0;
        const std::size_t stride = 1 + x.size() / 10;  // markers, thinned so that they stay apart
        for (std::size_t i = 0; i < x.size(); ++i) {
          if (i > 0 || x[i] > 1) series.points.push_back({x[i], share, false, "", false});
          share = static_cast<double>(i + 1) / total;
          const bool marked = (x.size() - 1 - i) % stride == 0;
          series.points.push_back(
              {x[i], share, false,
               fmt::format("{}: {:.0f} % within {:.3g}", solver, 100 * share, x[i]), marked});
        }
        if (!x.empty()) series.points.push_back({*chart.x.high, share, false, "", false});
        chart.series.push_back(std::move(series));
      }
      figure(chart,
             fmt::format("Time profile at tolerance {} over {} problems.", tolerance_label(tol),
                         total),
             context_.command);
    }
    add("</div>\n");
  }

  void problems() {
    add("<h2>Problem by problem</h2>\n<p>Left: what a solver's time buys; lower left is better. "
        "One line a solver, one marker a tolerance; an empty marker did not meet its tolerance. "
        "Right: what a tolerance means: the true error that comes with it.</p>\n");
    for (const ProblemSummary& p : c_.problems) {
      add(fmt::format("<h3>{}</h3>\n", escape_markup(p.name)));
      if (!p.defect.empty()) {
        add(fmt::format("<p>Not solved by anyone: {}</p>\n", escape_markup(p.defect)));
        continue;
      }
      add(fmt::format(
          "<p class=\"small\">{}. {} contacts, d = {}. Reference by {}, guarded error "
          "{}, natural map {}.{}</p>\n",
          escape_markup(p.origin), p.contacts, p.dim,
          p.reference_solver.empty() ? "nobody" : p.reference_solver,
          small_number(p.reference_guarded), small_number(p.reference_natural_map), uniqueness(p)));
      if (p.contacts == 0) continue;
      pareto_sentence(p);
      const Ranking rank = ranking(p, c_.rows);
      const std::string replay = fmt::format(fmt::runtime(context_.command_of_target), p.target);
      add("<div class=\"grid\">\n");
      Chart work, meaning;
      work.title = fmt::format("Work-precision diagram of {}", p.name);
      work.x = {"wall time, set-up and solve", ChartAxis::Kind::kLogSeconds};
      work.y = {std::string(rank.name()), ChartAxis::Kind::kLog};
      if (rank.measure == Ranking::Measure::kForce) work.y.label = "force error, worst body";
      meaning.title = fmt::format("Error against tolerance for {}", p.name);
      meaning.x = {"tolerance", ChartAxis::Kind::kLog};
      meaning.y = work.y;
      // Below the reference's own error nothing can be told.
      work.y.low = meaning.y.low = floor_of(p, rank);
      if (rank.measure != Ranking::Measure::kGuarded && p.reference_guarded >= *work.y.low) {
        work.y_line = meaning.y_line = p.reference_guarded;
        work.y_line_label = meaning.y_line_label = "guarded error of the reference";
      }
      for (const std::string& solver : solvers_) {
        ChartSeries in_time{solver, style_of(solver), {}}, in_tol = in_time;
        for (const ComparisonRow& r : c_.rows) {
          if (r.problem != p.name || r.solver != solver) continue;
          const double error = rank.of(r);
          const std::string note = fmt::format("{} at {}: {}, {} iterations, {}, {} {:.1e}", solver,
                                               tolerance_label(r.tol), r.status, r.iterations,
                                               seconds(r.total_min), rank.name(), error);
          if (!std::isfinite(error) || !std::isfinite(r.total_min)) continue;
          in_time.points.push_back({r.total_min, error, !r.solved(), note});
          in_tol.points.push_back({r.tol, error, !r.solved(), note});
        }
        if (in_time.points.empty()) continue;
        work.series.push_back(std::move(in_time));
        meaning.series.push_back(std::move(in_tol));
      }
      figure(work, fmt::format("Work and precision, {}.", escape_markup(p.name)), replay);
      figure(meaning, fmt::format("Error against tolerance, {}.", escape_markup(p.name)), replay);
      add("</div>\n");
    }
  }

  double floor_of(const ProblemSummary& p, const Ranking& rank) const {
    double least = 1;
    for (const ComparisonRow& r : c_.rows) {
      if (r.problem == p.name && rank.of(r) > 0) least = std::min(least, rank.of(r));
    }
    return std::max(1e-15, std::pow(10, std::floor(std::log10(least))));
  }

  static std::string uniqueness(const ProblemSummary& p) {
    if (p.several_velocities()) {
      return fmt::format(
          " <strong>Several velocity solutions</strong>: two solvers below 1e-9 differ by {} in "
          "the "
          "energy norm.",
          small_number(p.velocity_spread));
    }
    if (std::isfinite(p.velocity_spread)) {
      return fmt::format(" Solvers below 1e-9 agree on the velocities to {}.",
                         small_number(p.velocity_spread));
    }
    return " No second solver stands below 1e-9, so nothing is known of other solutions.";
  }

  void pareto_sentence(const ProblemSummary& p) {
    auto best = pareto_rows(p, c_.rows);
    std::sort(best.begin(), best.end(), [](const ComparisonRow* a, const ComparisonRow* b) {
      return a->total_min < b->total_min;
    });
    const Ranking rank = ranking(p, c_.rows);
    std::string list;
    for (const ComparisonRow* row : best) {
      list += fmt::format("{}{} at {} ({}, {})", list.empty() ? "" : "; ",
                          escape_markup(row->solver), tolerance_label(row->tol),
                          seconds(row->total_min), small_number(rank.of(*row)));
    }
    if (!list.empty())
      add(fmt::format("<p>Beaten by none in both time and {}: {}.</p>\n", rank.name(), list));
  }

  void figure(const Chart& chart, const std::string& caption, const std::string& command) {
    add("<figure>");
    add(to_svg(chart));
    add("<figcaption>" + caption);
    add(fmt::format(fmt::runtime(kReplay), escape_markup(command)));
    add("</figcaption></figure>\n");
  }

  void select(int column, const char* label, const std::vector<std::string>& values) {
    add(fmt::format("<label>{}<select data-column=\"{}\"><option value=\"\">all</option>", label,
                    column));
    for (const std::string& v : values) add(fmt::format("<option>{}</option>", escape_markup(v)));
    add("</select></label>");
  }

  void table() {
    add("<section class=\"wide\"><h2>All measurements</h2>\n<div class=\"filters\">");
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
                          {"of it set-up", true},
                          {"CPU", true},
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
      add(value(r.total_min, seconds(r.total_min)));
      add(value(r.setup_min, seconds(r.setup_min)));
      add(value(r.cpu_min, seconds(r.cpu_min)));
      for (double x : {r.guarded, r.natural_map, r.raw42, r.velocity_error, r.force_error,
                       r.contact_force_error, r.penetration, r.energy_error}) {
        add(value(x, small_number(x)));
      }
      add(fmt::format("<td class=\"n\">{} / {} / {}</td></tr>\n", r.take_off, r.stick, r.slip));
    }
    add("</tbody></table></div>\n<p class=\"small\">Click a heading to sort. The status shows the "
        "solver's own words when the pointer rests on it; rows that did not meet their tolerance "
        "are marked and stay in the table.</p></section>\n");
  }

  void measures() {
    add(R"(<h2>What the columns mean</h2>
<dl>
<dt>tolerance</dt><dd>What the solver was asked for: every solver stops when the guarded error falls below it.</dd>
<dt>guarded</dt><dd>How far the contact law is violated, as energy over energy; recomputed after the solve from the impulses alone. The larger of ε (the gap in the law plus the energy of penetration) and η (the natural map measured in energy).</dd>
<dt>natural map</dt><dd>The relative residual that other codes print, with one scaling for each contact.</dd>
<dt>raw (42)</dt><dd>The plain error in the law without guards; undefined where nothing slides, and blind to penetration.</dd>
<dt>velocity error</dt><dd>Kinetic energy norm of the difference to the reference velocities, over that of the velocity change that contacts make. 1 is as wrong as no contact forces at all.</dd>
<dt>force error</dt><dd>Resultant contact force on a body, largest difference over all bodies, over the largest resultant. Given where the problem knows its bodies.</dd>
<dt>contact force error</dt><dd>Worst single contact force over the largest one; given only where contact forces are unique (a packing usually holds itself in many ways) and the problem is small enough to check.</dd>
<dt>penetration</dt><dd>Overlap that the remaining approach velocity adds in one step, as a fraction of the smallest radius. Given where step and radius are known.</dd>
<dt>energy error</dt><dd>Relative error of the energy that the contacts take out of the free motion.</dd>
<dt>time</dt><dd>Wall time of set-up and iteration on one core, error checks of the solver included; the least of the repeats. The table in CSV has medians too.</dd>
<dt>Pareto</dt><dd>No other row of the problem is both faster and more accurate.</dd>
<dt>reference</dt><dd>Solved to 1e-12 or as far as it goes by auto, newton, ipm and apgd in turn, the lowest guarded error kept; errors below the reference's own accuracy mean nothing.</dd>
</dl>
)");
  }

  void provenance() {
    add("<h2>How this was made</h2>\n<dl>");
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
    item("limits", fmt::format("{:g} s a solve, {:g} s an attempt at a reference, {} repeat{}",
                               context_.options.time_limit, context_.options.reference_time_limit,
                               context_.options.repeat, context_.options.repeat == 1 ? "" : "s"));
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
    add("</dl>\n<p class=\"small\">The numbers behind all figures stand in comparison.csv and "
        "comparison.json beside this page.</p>\n");
  }

  const Comparison& c_;
  const ReportContext& context_;
  std::vector<std::string> solvers_;
  std::vector<double> tols_;
  std::string html_;
};

}  // namespace

std::string to_html(const Comparison& comparison, const ReportContext& context) {
  return Page(comparison, context).write();
}

}  // namespace bipot
