#include "bench/report/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/report/csv_text.h"
#include "bench/report/labels.h"
#include "bench/report/text_lines.h"

namespace bipot {
namespace {

constexpr std::size_t kTextWidth = 100, kHeadsWidth = 60, kColumnGap = 2;

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // which clang 14 does not deduce

/// Text without the marks of strong words and the targets of links.
std::string plain(std::string_view text) {
  std::string out;
  for (const Span& span : spans_of(text)) out += span.code ? '`' + span.text + '`' : span.text;
  return out;
}

void write_paragraph(std::string& out, std::string_view text) {
  for (const std::string& line : wrapped_lines(plain(text), kTextWidth)) out += line + '\n';
}

/// How many first columns tell the rows below a title apart: each block of a table has them. If
/// they are too wide, 1.
std::size_t heads_of(const std::vector<std::vector<std::string>>& cells,
                     const std::vector<std::size_t>& widths) {
  std::size_t width = 0;
  for (std::size_t heads = 1; heads < widths.size(); ++heads) {
    width += widths[heads - 1] + kColumnGap;
    if (width > kHeadsWidth) break;
    std::set<std::vector<std::string>> names;
    const bool apart = std::ranges::all_of(cells, [&](const auto& texts) {
      if (texts.size() == 1) names.clear();
      std::vector<std::string> name = texts;
      name.resize(heads);
      return names.insert(std::move(name)).second;
    });
    if (apart) return heads;
  }
  return std::min(widths.size(), std::size_t{1});
}

/// The columns [begin, end) after the heads.
void write_columns(std::string& out, const Table& table, const std::vector<std::size_t>& shown,
                   const std::vector<std::vector<std::string>>& cells,
                   const std::vector<std::size_t>& widths, std::size_t heads, std::size_t begin,
                   std::size_t end) {
  for (const auto& texts : cells) {
    std::string made;
    for (std::size_t k = 0; k < end; k = k + 1 == heads ? begin : k + 1) {
      if (k >= texts.size()) break;
      const std::string fill(widths[k] - std::min(widths[k], letters(texts[k])), ' ');
      if (k > 0) made += std::string(kColumnGap, ' ');
      const bool right = table.columns[shown[k]].show != nullptr;
      made += right ? fill + texts[k] : texts[k] + fill;
    }
    out += made.substr(0, made.find_last_not_of(' ') + 1) + '\n';
  }
}

void write_blocks(std::string& out, const std::vector<Document::Block>& blocks);

void write_block(std::string& out, const Document::Block& block) {
  const std::string space = out.empty() ? "" : "\n";
  std::visit(
      Overloaded{[&](const Document::Heading& h) { out += space + plain(h.text) + '\n'; },
                 [&](const Document::Paragraph& p) { write_paragraph(out, p.text); },
                 [&](const Table& t) { out += space + to_text(t) + '\n'; }, [](const Figure&) {},
                 [&](const Terms& t) {
                   for (const auto& [term, text] : t.entries) {
                     write_paragraph(out, term + ": " + text);
                   }
                 },
                 [&](const Document::Details& d) {
                   out += space + plain(d.summary) + '\n';
                   write_blocks(out, d.blocks);
                 }},
      block.content);
}

void write_blocks(std::string& out, const std::vector<Document::Block>& blocks) {
  for (const Document::Block& block : blocks) write_block(out, block);
}

Json value_json(const Table::Cell& cell) {
  return std::visit(Overloaded{[](std::monostate) { return Json(nullptr); },
                               [](const auto& x) { return Json(x); }},
                    cell.value);
}

/// Quoted if it has other characters than letters, digits and dots.
std::string csv_word(const std::string& text) {
  const bool bare = std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_.+-").find(c) != std::string_view::npos;
  });
  return bare ? text : csv_text(text);
}

std::string value_csv(const Table::Cell& cell) {
  return std::visit(Overloaded{[](std::monostate) { return std::string(); },
                               [](const std::string& x) { return csv_word(x); },
                               [](const auto& x) { return fmt::format("{}", x); }},
                    cell.value);
}

}  // namespace

std::string text_of(const Table::Cell& cell, const Table::Column& column) {
  if (cell.text) return *cell.text;
  return std::visit(Overloaded{[](std::monostate) { return std::string(); },
                               [](bool x) { return std::string(x ? "yes" : ""); },
                               [](long x) { return std::to_string(x); },
                               [&](double x) {
                                 return column.show ? column.show(x)
                                                    : short_exponent(fmt::format("{:g}", x));
                               },
                               [](const std::string& x) { return x; }},
                    cell.value);
}

std::vector<const Figure*> charts_of(const std::vector<Document::Block>& blocks) {
  std::vector<const Figure*> charts;
  for (const Document::Block& block : blocks) {
    if (const auto* figure = std::get_if<Figure>(&block.content)) {
      if (figure->chart) charts.push_back(figure);
    } else if (const auto* details = std::get_if<Document::Details>(&block.content)) {
      for (const Figure* inside : charts_of(details->blocks)) charts.push_back(inside);
    }
  }
  return charts;
}

bool is_title(const Table& table, const Table::Row& row) {
  return row.cells.size() == 1 && table.columns.size() > 1;
}

std::string heading_of(const Table::Column& column) {
  return column.unit.empty() ? column.name : fmt::format("{} [{}]", column.name, column.unit);
}

std::vector<Table::Column> Table::keyed(std::initializer_list<const char*> keys) {
  std::vector<Column> columns;
  for (const char* key : keys) columns.push_back({.key = key});
  return columns;
}
void Table::add(std::vector<Cell> cells, std::string row_look, std::string id) {
  rows.push_back({std::move(cells), std::move(row_look), std::move(id)});
}

void Document::heading(std::string text, std::string id, int level) {
  blocks.push_back({Heading{level, std::move(text), std::move(id)}});
}
void Document::say(std::string text, std::string look) {
  blocks.push_back({Paragraph{std::move(text), std::move(look)}});
}
void Document::add(Table table) { blocks.push_back({std::move(table)}); }
void Document::add(Figure figure) { blocks.push_back({std::move(figure)}); }
void Document::add(Terms terms) { blocks.push_back({std::move(terms)}); }
void Document::fold(std::string summary, Document inside, std::string id, bool open) {
  blocks.push_back(
      {Document::Details{std::move(summary), std::move(id), open, std::move(inside.blocks)}});
}
void Document::fold(std::string summary, Table inside, std::string id) {
  Document part;
  part.add(std::move(inside));
  fold(std::move(summary), std::move(part), std::move(id));
}
void Document::append(Document part) {
  for (Document::Block& block : part.blocks) blocks.push_back(std::move(block));
}

Provenance provenance(std::string name, std::string command) {
  return {std::move(name), std::move(command), date_and_time(), build_info()};
}

Terms to_terms(const Provenance& made) {
  const BuildInfo& build = made.build;
  return {{{"command", '`' + made.command + '`'},
           {"program", fmt::format("bipot {}, commit {}", build.version, build.commit)},
           {"compiler", build.compiler},
           {"flags", '`' + build.flags + '`'},
           {"machine",
            fmt::format("{}, {} logical cores, {} used", build.cpu, build.cores, made.threads)},
           {"date", made.date}}};
}

Json to_json(const Provenance& made) {
  const BuildInfo& build = made.build;
  return {{"command", made.name},
          {"command_line", made.command},
          {"version", build.version},
          {"commit", build.commit},
          {"compiler", build.compiler},
          {"flags", build.flags},
          {"build_type", build.build_type},
          {"cpu", build.cpu},
          {"cores", build.cores},
          {"threads", made.threads},
          {"date", made.date}};
}

std::string to_text(const Table& table) {
  std::vector<std::size_t> shown, widths;
  std::vector<std::vector<std::string>> cells(1);
  for (std::size_t k = 0; k < table.columns.size(); ++k) {
    if (table.columns[k].name.empty()) continue;
    shown.push_back(k);
    cells[0].push_back(plain(heading_of(table.columns[k])));
    widths.push_back(letters(cells[0].back()));
  }
  for (const Table::Row& row : table.rows) {
    auto& texts = cells.emplace_back();
    const bool title = is_title(table, row);
    if (title) texts.push_back(plain(text_of(row.cells[0], table.columns[0])));
    for (std::size_t k = 0; k < shown.size() && !title; ++k) {
      const std::size_t at = shown[k];
      texts.push_back(replaced(plain(text_of(row.cells[at], table.columns[at])), "\n", ", "));
      if (row.cells[at].look == "over") texts.back() += '*';  // bold on pages
      widths[k] = std::max(widths[k], letters(texts[k]));
    }
  }
  std::string out;
  if (!table.caption.empty()) write_paragraph(out, table.caption);
  const std::size_t heads = heads_of(cells, widths);
  std::size_t begin = heads;
  do {
    std::size_t end = begin, width = 0;
    for (std::size_t k = 0; k < heads; ++k) width += widths[k] + (k > 0 ? kColumnGap : 0);
    while (end < shown.size() && (end == begin || width + kColumnGap + widths[end] <= kTextWidth)) {
      width += kColumnGap + widths[end++];
    }
    if (begin > heads) out += '\n';
    write_columns(out, table, shown, cells, widths, heads, begin, std::max(end, heads));
    begin = end;
  } while (begin < shown.size());
  if (!table.note.empty()) write_paragraph(out, table.note);
  return out;
}

std::string to_text(const Document& document) {
  std::string out;
  if (!document.title.empty()) out += document.title + '\n';
  write_blocks(out, document.blocks);
  for (std::size_t at; (at = out.find("\n\n\n")) != std::string::npos;) out.erase(at, 1);
  return out;
}

std::string to_markdown(const Table& table) {
  std::string head = "|", rule = "|", rows;
  for (const Table::Column& column : table.columns) {
    if (column.name.empty()) continue;
    head += fmt::format(" {} |", heading_of(column));
    rule += " --- |";
  }
  for (const Table::Row& row : table.rows) {
    if (is_title(table, row)) continue;
    rows += '|';
    for (std::size_t k = 0; k < row.cells.size(); ++k) {
      const Table::Column& column = table.columns[k];
      if (!column.name.empty()) rows += fmt::format(" {} |", text_of(row.cells[k], column));
    }
    rows += '\n';
  }
  return head + '\n' + rule + '\n' + rows;
}

Json to_json(const Table& table) {
  Json all = Json::array();
  for (const Table::Row& row : table.rows) {
    if (is_title(table, row)) continue;
    Json object = Json::object();
    for (std::size_t k = 0; k < row.cells.size(); ++k) {
      if (!table.columns[k].key.empty()) object[table.columns[k].key] = value_json(row.cells[k]);
    }
    all.push_back(std::move(object));
  }
  return all;
}

Json to_json(const Document& document) {
  Json json = to_json(document.made);
  for (const Document::Block& block : document.blocks) {
    const auto* table = std::get_if<Table>(&block.content);
    if (table != nullptr && !table->key.empty()) json[table->key] = to_json(*table);
  }
  return json;
}

std::string csv_header(const std::vector<Table::Column>& columns) {
  std::string line;
  for (const Table::Column& column : columns) {
    if (column.key.empty()) continue;
    line += (line.empty() ? "" : ",") + column.key;
  }
  return line;
}

std::string csv_line(const std::vector<Table::Column>& columns,
                     const std::vector<Table::Cell>& cells) {
  std::string line;
  bool first = true;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    if (columns[k].key.empty()) continue;
    line += (first ? "" : ",") + value_csv(cells[k]);
    first = false;
  }
  return line;
}

std::string to_csv(const Table& table) {
  std::string out = csv_header(table.columns) + '\n';
  for (const Table::Row& row : table.rows) {
    if (!is_title(table, row)) out += csv_line(table.columns, row.cells) + '\n';
  }
  return out;
}

void write_figures(const std::filesystem::path& folder, const Document& document) {
  for (const Figure* figure : charts_of(document.blocks)) {
    if (figure->file.empty()) continue;
    write_chart_files(folder, std::filesystem::path(figure->file).stem().string(), *figure->chart);
  }
}

}  // namespace bipot
