#include "bench/report/page_style.h"

#include <fmt/format.h>

#include "bench/report/text_lines.h"

namespace bipot {
namespace {

constexpr std::string_view kSheet = R"(
:root{color-scheme:light dark;--ink:#1b1b1b;--soft:#555;--paper:#fff;--shade:#f3f3f3;--line:#d4d4d4;
 --link:#0a4a8a;--bad:#8a1c00;--good:#cfe8cf;--weak:#f6e3b4;--beyond:#e3dcf0;--none:#d5e4f3;--grey:#e4e4e4}
@media(prefers-color-scheme:dark){:root{--ink:#e4e4e4;--soft:#a8a8a8;--paper:#161719;--shade:#232528;
 --line:#3a3d41;--link:#8ab8ec;--bad:#ff9d80;--good:#1f4a2a;--weak:#574514;--beyond:#3d3355;--none:#21405c;--grey:#3a3d41}
 figure svg,figure img{filter:invert(.91) hue-rotate(180deg)}}
*{box-sizing:border-box}
body{margin:0 auto;max-width:1180px;padding:16px;font:15px/1.5 system-ui,sans-serif;color:var(--ink);
 background:var(--paper)}
h1{font-size:1.5rem;line-height:1.2;margin:.4em 0}
h2{font-size:1.2rem;margin:2em 0 .4em;border-bottom:1px solid var(--line);padding-bottom:.2em}
h3{font-size:1rem;margin:1.6em 0 .3em}
p,li{max-width:46em}
code{font:.88em ui-monospace,monospace;background:var(--shade);padding:.1em .3em;overflow-wrap:anywhere}
.small{color:var(--soft);font-size:.87rem}
.scroll{overflow-x:auto;border:1px solid var(--line)}
table{border-collapse:separate;border-spacing:0;font-variant-numeric:tabular-nums;font-size:.84rem;
 width:100%}
th,td{padding:.3em .4em;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
td.n,th.n{text-align:right;white-space:nowrap}
thead th{background:var(--shade)}
th:first-child,td:first-child{position:sticky;left:0;background:var(--paper)}
thead th:first-child{background:var(--shade)}
tr.bad td{color:var(--bad)}
tr.bad td:first-child{box-shadow:inset 3px 0 var(--bad)}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,400px),1fr));
 gap:12px 28px}
figure{margin:0;break-inside:avoid;min-width:0}
figure svg{display:block;width:100%;max-width:560px;height:auto}
figcaption{font-size:.87rem;max-width:560px}
h4{font-size:.95rem;margin:1.2em 0 .3em}
a{color:var(--link)}
caption{text-align:left;padding:.3em .4em}
.scroll+.scroll{margin-top:1em}
td.over{font-weight:700}
td.good{background:var(--good)}td.weak{background:var(--weak)}td.beyond{background:var(--beyond)}
td.none{background:var(--none)}td.grey{background:var(--grey)}td.bad{background:#d33;color:#fff}
tr.group td{background:var(--shade);font-weight:600;position:static}
p.quote,p.bad{border-left:3px solid #999;padding-left:.8em}
p.bad{border-color:var(--bad);color:var(--bad)}
.grid{margin:1em 0}
figure.wide{grid-column:1/-1}
figure.wide svg,figure.wide figcaption{max-width:none}
figure img{display:block;width:100%;height:auto}
nav{display:flex;flex-wrap:wrap;gap:.2em 1.2em;margin:1em 0}
details{border-bottom:1px solid var(--line);padding:.35em 0}
details[open]>summary{margin-bottom:.4em}
summary{cursor:pointer;overflow-wrap:anywhere}
th button{font:inherit;font-weight:bold;background:none;border:0;padding:0;color:inherit;
 cursor:pointer;text-align:inherit}
th[aria-sort=ascending] button::after{content:" \25B2"}
th[aria-sort=descending] button::after{content:" \25BC"}
.filters{display:flex;flex-wrap:wrap;gap:8px 16px;margin:.6em 0}
.filters label{display:flex;flex-direction:column;font-size:.8rem;color:var(--soft)}
select,input{font:inherit;padding:.25em;max-width:100%;border:1px solid var(--line);background:var(--paper);
 color:inherit}
button#open-all{font:inherit;font-size:.87rem}
dl{display:grid;grid-template-columns:minmax(7em,max-content) 1fr;gap:.3em 1em}
dt{font-weight:600}dd{margin:0;max-width:42em}
@media(max-width:620px){body{padding:10px}dl{display:block}dd{margin:0 0 .5em}
 table thead{display:none}
 table tr{display:block;border-bottom:1px solid var(--line);padding:.4em 0}
 table td{display:flow-root;position:static;border:0;padding:.1rem .5rem;text-align:left}
 table td:first-child{font-weight:600;font-size:1rem}
 table td[data-label]{padding-left:6.2rem}
 table td[data-label]::before{content:attr(data-label);float:left;width:5.2rem;margin-left:-5.7rem;color:var(--soft)}
 table td.bad::before{color:inherit}
 td.n{white-space:normal;text-align:left}}
@media(min-width:621px){.n+:not(.n){padding-left:1.6em}td.good,td.weak,td.beyond,td.none,td.bad{white-space:nowrap}}
@media print{body{max-width:none;padding:0;font-size:10pt}.scroll{overflow:visible;border:0}
 .filters,nav,#open-all{display:none}table{font-size:7.5pt}th,td{padding:.15em .3em}
 table.sortable{font-size:6pt}figcaption,.small{font-size:8pt}.grid{grid-template-columns:1fr 1fr}
 @page wide{size:landscape;margin:10mm}section.sortable{page:wide}
 th:first-child,td:first-child{position:static}
 h2,h3,h4,caption,summary{break-after:avoid}tr{break-inside:avoid}}
)";

}  // namespace

std::string page_head(std::string_view title) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{}</title>\n<style>{}</style></head><body>\n",
      escape_markup(title), kSheet);
}

}  // namespace bipot
