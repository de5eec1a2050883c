#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "bench/report/document.h"
#include "bench/report/page_style.h"
#include "bench/report/text_lines.h"

namespace bipot {
namespace {

/// Sorts and filters tables, and opens collapsed parts, also for the target of a link.
constexpr std::string_view kScript = R"(
(function(){
 document.querySelectorAll('section.sortable').forEach(section=>{
  const table=section.querySelector('table'),body=table.tBodies[0];
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
  const filters=Array.from(section.querySelectorAll('[data-column]'));
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
   section.querySelector('.shown').textContent=count+' of '+rows.length+' rows';
  };
  filters.forEach(f=>f.addEventListener('input',apply));
  apply();
 });
 const all=Array.from(document.querySelectorAll('details'));
 const button=document.getElementById('open-all');
 if(button)button.addEventListener('click',()=>all.forEach(d=>d.open=true));
 const reveal=()=>{
  const aim=location.hash.length>1&&document.getElementById(location.hash.slice(1));
  if(aim&&aim.tagName==='DETAILS'){aim.open=true;aim.scrollIntoView();}
 };
 addEventListener('hashchange',reveal);
 reveal();
})();
)";

std::string attribute(std::string_view name, std::string_view value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, escape_markup(value));
}

std::string class_of(std::string_view look, bool numeric) {
  return attribute("class", numeric && !look.empty() ? fmt::format("n {}", look)
                            : numeric                ? "n"
                                                     : std::string(look));
}

std::string prose(std::string_view text) {
  std::string out;
  for (const Span& span : spans_of(text)) {
    std::string piece = replaced(escape_markup(span.text), "\n", "<br>");
    if (span.code) piece = "<code>" + piece + "</code>";
    if (!span.aim.empty()) piece = fmt::format("<a href=\"{}\">{}</a>", span.aim, piece);
    out += span.strong ? "<strong>" + piece + "</strong>" : piece;
  }
  return out;
}

bool has_sortable(const std::vector<Document::Block>& blocks) {
  return std::ranges::any_of(blocks, [](const Document::Block& block) {
    const auto* table = std::get_if<Table>(&block.content);
    return table != nullptr && table->sortable;
  });
}

class PageWriter {
 public:
  explicit PageWriter(const Document& document) : document_(document) {
    has_script_ = has_sortable(document.blocks);
    std::vector<Chart> charts;
    // In the order of the page: gnuplot draws all at once.
    for (const Figure* figure : charts_of(document.blocks)) charts.push_back(*figure->chart);
    drawings_ = to_svg(charts);
  }

  std::string write() {
    add("{}<h1>{}</h1>\n", page_head(document_.title), prose(document_.title));
    bool listed = !document_.contents;
    for (std::size_t k = 0; k < document_.blocks.size();) {
      const auto* heading = std::get_if<Document::Heading>(&document_.blocks[k].content);
      if (!listed && heading != nullptr && heading->level == 2) {
        write_contents();
        listed = true;
      }
      k = write_from(document_.blocks, k);
    }
    if (has_script_) add("<script>{}</script>\n", kScript);
    return html_ + "</body></html>\n";
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(html_), format, std::forward<Values>(values)...);
  }

  void write_contents() {
    add("<nav>");
    for (const Document::Block& block : document_.blocks) {
      const auto* heading = std::get_if<Document::Heading>(&block.content);
      if (heading == nullptr || heading->level != 2 || heading->id.empty()) continue;
      add("<a href=\"#{}\">{}</a>", escape_markup(heading->id), prose(heading->text));
    }
    add("</nav>\n");
  }

  /// Writes one block, or all figures of a grid. Returns the index after them.
  std::size_t write_from(const std::vector<Document::Block>& blocks, std::size_t k) {
    if (!std::holds_alternative<Figure>(blocks[k].content)) {
      std::visit([this](const auto& content) { write(content); }, blocks[k].content);
      return k + 1;
    }
    add("<div class=\"grid\">\n");
    for (; k < blocks.size(); ++k) {
      const auto* figure = std::get_if<Figure>(&blocks[k].content);
      if (figure == nullptr) break;
      write(*figure);
    }
    add("</div>\n");
    return k;
  }

  void write(const Document::Heading& h) {
    add("<h{0}{1}>{2}</h{0}>\n", h.level, attribute("id", h.id), prose(h.text));
  }

  void write(const Document::Paragraph& p) {
    add("<p{}>{}</p>\n", attribute("class", p.look), prose(p.text));
  }

  void write(const Terms& terms) {
    add("<dl>");
    for (const auto& [term, text] : terms.entries) {
      add("<dt>{}</dt><dd>{}</dd>\n", prose(term), prose(text));
    }
    add("</dl>\n");
  }

  void write(const Document::Details& d) {
    if (has_script_ && !has_button_) {
      add("<p><button type=\"button\" id=\"open-all\">Open all that is folded</button></p>\n");
      has_button_ = true;
    }
    add("<details{}{}><summary>{}</summary>\n", attribute("id", d.id), d.open ? " open=\"\"" : "",
        prose(d.summary));
    for (std::size_t k = 0; k < d.blocks.size();) k = write_from(d.blocks, k);
    add("</details>\n");
  }

  void write(const Figure& f) {
    add("<figure{}>", f.wide ? " class=\"wide\"" : "");
    if (f.chart) {
      html_ += drawings_[next_++];
    } else {
      add("<a href=\"{0}\"><img src=\"{0}\" alt=\"{1}\"></a>", escape_markup(f.file),
          escape_markup(f.caption));
    }
    add("<figcaption>{}", prose(f.caption));
    if (f.chart && !f.file.empty()) {
      const std::string name = f.file.substr(0, f.file.rfind('.'));
      add(" <a href=\"{0}.svg\">Picture</a>, <a href=\"{0}.csv\">data</a>, "
          "<a href=\"{0}.gp\">script</a>.",
          escape_markup(name));
    }
    if (!f.command.empty()) {
      add("<br><span class=\"small\">Made by <code>{}</code>{}.</span>", escape_markup(f.command),
          f.source.empty() ? "" : "; data: " + prose(f.source));
    }
    add("</figcaption></figure>\n");
  }

  void write(const Table& table) {
    std::vector<std::size_t> shown;
    for (std::size_t k = 0; k < table.columns.size(); ++k) {
      if (!table.columns[k].name.empty()) shown.push_back(k);
    }
    if (shown.empty()) return;
    if (table.sortable) write_filters(table, shown);
    add("<div class=\"scroll\"><table{}>", table.sortable ? " class=\"sortable\"" : "");
    if (!table.caption.empty()) add("<caption>{}</caption>", prose(table.caption));
    add("<thead><tr>");
    for (const std::size_t k : shown) {
      const Table::Column& column = table.columns[k];
      const std::string name = prose(heading_of(column));
      add("<th{}{}>{}</th>", class_of("", column.show != nullptr),
          attribute("title", column.meaning),
          table.sortable ? "<button type=\"button\">" + name + "</button>" : name);
    }
    add("</tr></thead><tbody>\n");
    for (const Table::Row& row : table.rows) {
      if (is_title(table, row)) {
        add("<tr class=\"group\"{}><td colspan=\"{}\">{}</td></tr>\n", attribute("id", row.id),
            shown.size(), prose(text_of(row.cells[0], table.columns[0])));
        continue;
      }
      add("<tr{}{}>", attribute("class", row.look), attribute("id", row.id));
      for (const std::size_t k : shown) write_cell(table, row.cells[k], table.columns[k]);
      add("</tr>\n");
    }
    add("</tbody></table></div>\n");
    if (const std::string note = table.note + table.page_note; !note.empty()) {
      add("<p class=\"small\">{}</p>\n", prose(note));
    }
    if (table.sortable) add("</section>\n");
  }

  void write_cell(const Table& table, const Table::Cell& cell, const Table::Column& column) {
    add("<td{}{}", class_of(cell.look, column.show != nullptr), attribute("title", cell.tip));
    html_ += attribute("data-label", heading_of(column));  // rows are cards on small screens
    if (table.sortable) {
      if (const auto* number = std::get_if<double>(&cell.value)) add(" data-v=\"{}\"", *number);
    }
    add(">{}</td>", prose(text_of(cell, column)));
  }

  void write_filters(const Table& table, const std::vector<std::size_t>& shown) {
    add("<section class=\"sortable\"><div class=\"filters\"><label>{} contains"
        "<input data-column=\"0\" size=\"14\"></label>",
        prose(table.columns[shown[0]].name));
    for (std::size_t place = 0; place < shown.size(); ++place) {
      const Table::Column& column = table.columns[shown[place]];
      if (!column.filter) continue;
      add("<label>{}<select data-column=\"{}\"><option value=\"\">all</option>", prose(column.name),
          place);
      std::set<std::string> seen = {""};
      for (const Table::Row& row : table.rows) {
        const std::string text = text_of(row.cells[shown[place]], column);
        if (seen.insert(text).second) add("<option>{}</option>", escape_markup(text));
      }
      add("</select></label>");
    }
    add("<span class=\"shown small\" aria-live=\"polite\"></span></div>\n");
  }

  const Document& document_;
  std::vector<std::string> drawings_;
  std::size_t next_ = 0;
  bool has_script_ = false, has_button_ = false;
  std::string html_;
};

}  // namespace

std::string to_html(const Document& document) { return PageWriter(document).write(); }

}  // namespace bipot
