#include "bench/experiments/paper_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/report/page_style.h"

namespace bipot {
namespace {

// Text for reading in larger type, plain tables instead of boxes.
constexpr std::string_view kOwnRules = R"(
body{max-width:1080px;font-size:16px}
h2{font-size:1.25rem;margin:2.4em 0 .5em;border-bottom-color:#bbb}
a{color:#0a4a8a}
.paper{border-left:3px solid #999;padding-left:.8em;color:#333}
.failed{border-left:3px solid #8a1c00;padding-left:.8em;color:#8a1c00}
.no{color:#8a1c00;font-weight:600}
.yes{color:#1d5c2e}
.yes,.no{white-space:nowrap}
.scroll{border:0}
table{border-collapse:collapse;font-size:.88rem;margin:.4em 0}
th,td{padding:.3em .7em .3em 0}
th:first-child,td:first-child{position:static}
thead th,thead th:first-child{background:none;border-bottom:1px solid #888}
summary{font-size:.88rem;color:#333;padding:.3em 0}
caption{text-align:left;color:#333;padding:.3em 0;caption-side:top}
.made td,.made th{background:#f6f6f6;font-weight:normal;padding:.25em .4em;color:#444}
.grid{grid-template-columns:repeat(auto-fill,minmax(min(100%,420px),1fr));gap:18px 28px;
 margin:1em 0}
figure.wide{grid-column:1/-1}
figure img{display:block;width:100%;height:auto}
figcaption{font-size:.88rem;max-width:44em;margin-top:.3em}
dl{font-size:.88rem}
dd{max-width:none;overflow-wrap:anywhere}
@media(max-width:620px){.cards thead{display:none}
 .cards tr{display:block;border-bottom:1px solid #bbb;padding:.35em 0}
 .cards td,.cards th{display:block;border:0;padding:.08em 0;text-align:left;white-space:normal}
 .cards td[data-label]::before{content:attr(data-label) ": ";color:#555}}
@media print{table{font-size:8pt}th,td{padding:.15em .5em .15em 0}
 .grid{grid-template-columns:1fr 1fr;gap:8px 16px}figcaption{font-size:8.5pt}
 a{color:inherit;text-decoration:none}
 .made td,.made th,code{background:none}@page{margin:14mm}}
)";

/// Entities, and `code` in backticks.
std::string prose(const std::string& text) {
  std::string out;
  bool code = false;
  for (const char c : escape_markup(text)) {
    if (c == '`') {
      out += code ? "</code>" : "<code>";
      code = !code;
    } else {
      out += c;
    }
  }
  return code ? out + "</code>" : out;
}

std::string seconds(double s) {
  return s < 10 ? fmt::format("{:.1f} s", s)
                : (s < 120 ? fmt::format("{:.0f} s", s) : fmt::format("{:.1f} min", s / 60));
}

std::string verdict(const std::optional<bool>& holds) {
  if (!holds) return "";
  return *holds ? "<span class=\"yes\">✓ holds</span>"
                : "<span class=\"no\">✗ does not hold</span>";
}

std::string checks_of(const PaperEntry& entry) {
  if (entry.status != PaperEntry::Status::kDone) {
    return fmt::format("<span class=\"no\">{}</span>", to_string(entry.status));
  }
  if (entry.checks() == 0) return "none";
  return fmt::format("<span class=\"{}\">{} {} of {} hold</span>",
                     entry.held() == entry.checks() ? "yes" : "no",
                     entry.held() == entry.checks() ? "✓" : "✗", entry.held(), entry.checks());
}

class Page {
 public:
  explicit Page(const PaperReport& report) : report_(report) {}

  std::string write() {
    add(page_head("Bipot: the paper's figures and tables", kOwnRules));
    add("<h1>The paper's figures and tables, made again and checked</h1>\n"
        "<p>The paper is Fortin, Hjiaj and de Saxcé, <cite>An improved discrete element method "
        "based on a variational formulation of the frictional contact law</cite>, Computers and "
        "Geotechnics 29 (2002) 609–640; numbers in parentheses are its equations. Each section "
        "says what the paper reports, then what this program finds. ε is the guarded error in the "
        "contact law (the larger of the guarded (42) and the natural map in energy) unless a "
        "text says raw (42).</p>\n");
    overview();
    for (const PaperEntry& entry : report_.entries) section(entry);
    provenance();
    add(page_end());
    return std::move(html_);
  }

 private:
  void add(const std::string& text) { html_ += text; }

  void overview() {
    add("<table class=\"cards\"><thead><tr><th>item</th><th>checks</th><th>time</th></tr></thead>"
        "<tbody>\n");
    for (const PaperEntry& e : report_.entries) {
      add(fmt::format(
          "<tr><td><a href=\"#{}\">{}</a>{}</td><td data-label=\"checks\">{}</td>"
          "<td data-label=\"time\">{}</td></tr>\n",
          escape_markup(e.name), escape_markup(e.title),
          e.quick ? " <span class=\"small\">(quick: small sizes)</span>" : "", checks_of(e),
          e.status == PaperEntry::Status::kNotRun ? "" : seconds(e.wall_seconds)));
    }
    add("</tbody></table>\n");
  }

  void section(const PaperEntry& e) {
    add(fmt::format("<section id=\"{}\"><h2>{}</h2>\n", escape_markup(e.name),
                    escape_markup(e.title)));
    if (e.status != PaperEntry::Status::kDone) {
      add(fmt::format(
          "<p class=\"failed\">This item is {}{}{}. Run <code>{}</code>.</p></section>\n",
          to_string(e.status), e.message.empty() ? "" : ": ", prose(e.message),
          escape_markup(e.command)));
      return;
    }
    add(fmt::format("<p class=\"paper\"><strong>The paper.</strong> {}</p>\n",
                    prose(e.result.paper)));
    const int paragraphs = static_cast<int>(e.result.ours.size());
    for (int i = 0; i < paragraphs; ++i) {
      add(fmt::format("<p>{}{}</p>\n", i == 0 ? "<strong>Here.</strong> " : "",
                      prose(e.result.ours[static_cast<std::size_t>(i)])));
      figures(e.result.figures, [i](const PaperFigure& f) { return f.after == i; });
    }
    figures(e.result.figures, [paragraphs](const PaperFigure& f) {
      return !f.after || *f.after < 0 || *f.after >= paragraphs;
    });
    numbers(e.result.numbers);
    for (const PaperTable& t : e.result.tables) table(t);
    add(fmt::format("<p class=\"small\">Made by <code>{}</code> in {} ({} of CPU).</p></section>\n",
                    escape_markup(e.command), seconds(e.wall_seconds), seconds(e.cpu_seconds)));
  }

  template <typename Chosen>
  void figures(const std::vector<PaperFigure>& all, const Chosen& chosen) {
    if (std::none_of(all.begin(), all.end(), chosen)) return;
    add("<div class=\"grid\">\n");
    for (const PaperFigure& f : all) {
      if (chosen(f)) figure(f);
    }
    add("</div>\n");
  }

  void figure(const PaperFigure& f) {
    const std::string file = f.chart ? f.name + ".svg" : f.file;
    const std::string text = f.chart ? f.chart->title : f.caption;
    add(fmt::format("<figure{}><a href=\"{}\"><img src=\"{}\" alt=\"{}\"></a><figcaption>{}",
                    f.wide ? " class=\"wide\"" : "", escape_markup(file), escape_markup(file),
                    escape_markup(text), prose(f.caption)));
    if (f.chart) {
      add(fmt::format(" <a href=\"{0}.csv\">Data</a>, <a href=\"{0}.gp\">script</a>.",
                      escape_markup(f.name)));
    }
    add(fmt::format("<br><span class=\"small\"><code>{}</code></span></figcaption></figure>\n",
                    escape_markup(f.command)));
  }

  // A command stands once, above the numbers that it makes.
  void numbers(const std::vector<PaperNumber>& all) {
    if (all.empty()) return;
    add("<table class=\"cards\"><thead><tr><th>quantity</th><th>by theory or the paper</th>"
        "<th class=\"n\">here</th><th>check</th></tr></thead><tbody>\n");
    const std::string* command = nullptr;
    for (const PaperNumber& n : all) {
      if (command == nullptr || *command != n.command) {
        command = &n.command;
        add(fmt::format("<tr class=\"made\"><th colspan=\"4\">made by <code>{}</code></th></tr>\n",
                        escape_markup(*command)));
      }
      add(fmt::format(
          "<tr><td>{}</td><td{}>{}</td><td class=\"n\" data-label=\"here\">{}</td>"
          "<td>{}</td></tr>\n",
          prose(n.meaning), n.expected.empty() ? "" : " data-label=\"by theory or the paper\"",
          prose(n.expected), escape_markup(to_text(n.value, n.unit, n.digits)), verdict(n.holds)));
    }
    add("</tbody></table>\n");
  }

  // A long table is folded: it is there for who looks something up.
  void table(const PaperTable& t) {
    constexpr std::size_t kLong = 30;
    const bool folded = t.rows.size() > kLong;
    const std::string caption = fmt::format("{} <span class=\"small\"><code>{}</code></span>",
                                            prose(t.caption), escape_markup(t.command));
    add(folded ? fmt::format("<details><summary>{} ({} rows)</summary>", caption, t.rows.size())
               : std::string());
    add("<div class=\"scroll\"><table>");
    if (!folded) add(fmt::format("<caption>{}</caption>", caption));
    add("<thead><tr>");
    for (const std::string& c : t.columns) add(fmt::format("<th>{}</th>", prose(c)));
    add("</tr></thead><tbody>\n");
    for (const auto& row : t.rows) {
      add("<tr>");
      for (const std::string& cell : row) add(fmt::format("<td>{}</td>", prose(cell)));
      add("</tr>\n");
    }
    add("</tbody></table></div>\n");
    if (folded) add("</details>\n");
  }

  void provenance() {
    add("<h2>How this page was made</h2>\n<dl>");
    add(page_term("last command", "<code>" + escape_markup(report_.command) + "</code>"));
    // Items kept from earlier runs may come from other programs and machines.
    const auto all = [this](const char* name, auto&& text_of) {
      std::vector<std::string> texts;
      for (const PaperEntry& e : report_.entries) {
        if (e.status == PaperEntry::Status::kNotRun) continue;
        const std::string text = text_of(e);
        if (std::find(texts.begin(), texts.end(), text) == texts.end()) texts.push_back(text);
      }
      for (const std::string& text : texts) add(page_term(name, escape_markup(text)));
    };
    all("program", [](const PaperEntry& e) {
      return fmt::format("bipot {}, commit {}", e.build.version, e.build.commit);
    });
    all("compiler",
        [](const PaperEntry& e) { return fmt::format("{}, {}", e.build.compiler, e.build.flags); });
    all("machine", [](const PaperEntry& e) {
      return fmt::format("{}, {} logical cores, 1 used", e.build.cpu, e.build.cores);
    });
    all("date", [](const PaperEntry& e) { return e.date.substr(0, 10); });
    double total = 0;
    for (const PaperEntry& e : report_.entries) total += e.wall_seconds;
    add(page_term("time", seconds(total) + " for all items"));
    add("</dl>\n<p class=\"small\">Every number of this page, and the points of every chart, stand "
        "in <a href=\"results.json\">results.json</a> beside it.</p>\n");
  }

  const PaperReport& report_;
  std::string html_;
};

}  // namespace

std::string to_html(const PaperReport& report) { return Page(report).write(); }

}  // namespace bipot
