#include "bench/compare/page_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/report/chart.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

constexpr const char* kTableScript = R"(
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

void add_filter(PageDraft& page, int column, const char* label,
                const std::vector<std::string>& values) {
  page.add(fmt::format("<label>{}<select data-column=\"{}\"><option value=\"\">all</option>", label,
                       column));
  for (const std::string& v : values) {
    page.add(fmt::format("<option>{}</option>", escape_markup(v)));
  }
  page.add("</select></label>");
}

}  // namespace

void add_table(PageDraft& page, const PageContent& of) {
  page.add("<section class=\"wide\">");
  page.heading("all", "All rows");
  page.add("<div class=\"filters\">");
  std::vector<std::string> names, tols, statuses;
  for (const ProblemSummary& p : of.comparison.problems) names.push_back(p.name);
  for (double tol : of.tols) tols.push_back(tolerance_label(tol));
  for (const ComparisonRow& r : of.comparison.rows) {
    if (std::find(statuses.begin(), statuses.end(), r.status) == statuses.end()) {
      statuses.push_back(r.status);
    }
  }
  page.add("<label>problem contains<input data-column=\"0\" size=\"14\"></label>");
  add_filter(page, 0, "problem", names);
  add_filter(page, 1, "solver", of.solvers);
  add_filter(page, 2, "tolerance", tols);
  add_filter(page, 3, "status", statuses);
  add_filter(page, 4, "Pareto", {"yes"});
  page.add(
      "<span id=\"shown\" class=\"small\" aria-live=\"polite\"></span></div>\n"
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
    page.add(fmt::format("<th{}><button type=\"button\">{}</button></th>",
                         h.numeric ? " class=\"n\"" : "", h.name));
  }
  page.add("</tr></thead><tbody>\n");
  std::vector<const ComparisonRow*> pareto;
  for (const ProblemSummary& p : of.comparison.problems) {
    for (const ComparisonRow* row : pareto_rows(p, of.comparison.rows)) pareto.push_back(row);
  }
  for (const ComparisonRow& r : of.comparison.rows) {
    const auto value = [](double x, const std::string& text) {
      return fmt::format("<td class=\"n\" data-v=\"{}\">{}</td>", x, text);
    };
    page.add(fmt::format("<tr{}><td>{}</td><td>{}</td>", r.solved() ? "" : " class=\"bad\"",
                         escape_markup(r.problem), escape_markup(r.solver)));
    page.add(value(r.tol, tolerance_label(r.tol)));
    const bool front = std::find(pareto.begin(), pareto.end(), &r) != pareto.end();
    page.add(fmt::format("<td title=\"{}\">{}</td><td>{}</td>", escape_markup(r.message),
                         escape_markup(r.status), front ? "yes" : ""));
    page.add(value(r.iterations, std::to_string(r.iterations)));
    page.add(value(r.time(), seconds_label(r.time())));
    page.add(value(r.total_min, seconds_label(r.total_min)));
    page.add(value(r.setup_min, seconds_label(r.setup_min)));
    for (double x : {r.guarded, r.natural_map, r.raw42, r.velocity_error, r.force_error,
                     r.contact_force_error, r.penetration, r.energy_error}) {
      page.add(value(x, error_label(x)));
    }
    page.add(fmt::format("<td class=\"n\">{} / {} / {}</td></tr>\n", r.take_off, r.stick, r.slip));
  }
  page.add(
      "</tbody></table></div>\n<p class=\"small\">Click a heading to sort. The status shows the "
      "solver's own words when the pointer rests on it; rows that did not meet their tolerance "
      "are marked and stay in the table. Printed are the rows that are shown.</p></section>\n");
}

std::string_view table_script() { return kTableScript; }

}  // namespace bipot
