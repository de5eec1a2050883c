#pragma once

#include <concepts>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "bench/report/build_info.h"
#include "bench/report/chart.h"
#include "bench/report/json_output.h"

namespace bipot {

// A report is written once, as a Document. It is rendered as a page (HTML), as text for a terminal,
// and as data: its tables as JSON, one table as CSV.
//
// Texts are plain. In all but tips, `code`, **strong** and [words](#id) have their usual meaning,
// and the end of a line breaks it. A link leads into the page or to a file beside it. Looks are
// classes of bench/report/page_style.cc: good, weak, bad, none, grey, beyond, over, small, quote.

struct Table {
  /// A value, and its form for readers. CSV and JSON have the value alone.
  struct Cell {
    Cell() = default;  ///< empty in CSV, null in JSON
    Cell(std::integral auto x) {
      if constexpr (std::same_as<decltype(x), bool>) {
        value = x;
      } else {
        value = static_cast<long>(x);
      }
    }
    Cell(double x) : value(x) {}
    Cell(const char* x) : value(std::string(x)) {}
    Cell(std::string_view x) : value(std::string(x)) {}
    Cell(std::string x) : value(std::move(x)) {}

    Cell& shown(std::string x) { return text = std::move(x), *this; }
    Cell& tipped(std::string x) { return tip = std::move(x), *this; }
    Cell& as(std::string x) { return look = std::move(x), *this; }

    std::variant<std::monostate, bool, long, double, std::string> value;
    std::optional<std::string> text;  ///< shown instead of the value
    std::string tip;                  ///< shown when the pointer rests on it
    std::string look;
  };
  struct Column {
    std::string key;                        ///< in CSV and JSON; empty: not there
    std::string name;                       ///< the heading; empty: a column hidden from readers
    std::string (*show)(double) = nullptr;  ///< of numbers (labels.h), flush right; null: texts
    std::string unit;                       ///< shown in brackets behind the name
    std::string meaning;                    ///< shown when the pointer rests on the heading
    bool filter = false;  ///< of a sortable table: the reader can filter by its values
  };
  struct Row {
    /// A single one is a title of the rows below, absent in CSV and JSON.
    std::vector<Cell> cells;
    std::string look;
    std::string id;
  };
  /// Columns of data that readers do not see.
  static std::vector<Column> keyed(std::initializer_list<const char*> keys);

  std::vector<Column> columns;
  std::vector<Row> rows;
  std::string key;        ///< in the JSON of a document; empty: not included
  std::string caption;    ///< above it
  std::string note;       ///< below it, small
  std::string page_note;  ///< after the note, on pages only
  bool sortable = false;

  void add(std::vector<Cell> cells, std::string row_look = {}, std::string id = {});
};

/// A chart or an image. Consecutive ones form a grid.
struct Figure {
  std::optional<Chart> chart;
  /// Name of an image beside the page. With a chart: its SVG file, which write_figures makes.
  std::string file;
  std::string caption;
  std::string command;  ///< makes it again; empty: not said
  std::string source;   ///< where its numbers stand; empty: not said
  bool wide = false;    ///< over the whole width of the grid
};

struct Terms {
  std::vector<std::pair<std::string, std::string>> entries;
};

/// Origin of numbers: program, machine and date.
struct Provenance {
  std::string name;     ///< of the command: "compare"
  std::string command;  ///< as it was typed
  std::string date;
  BuildInfo build;
  int threads = 1;
};
/// Provenance of this program, now.
Provenance provenance(std::string name, std::string command);
Terms to_terms(const Provenance& made);
/// The first members of JSON reports.
Json to_json(const Provenance& made);

struct Document {
  struct Heading {
    int level = 2;
    std::string text, id;
  };
  struct Paragraph {
    std::string text, look;
  };
  struct Block;
  /// Collapsed on a page.
  struct Details {
    std::string summary, id;
    bool open = false;
    std::vector<Block> blocks;
  };
  std::string title;
  Provenance made;
  bool contents = false;  ///< links to the headings of level 2, before the first of them
  std::vector<Block> blocks;

  void heading(std::string text, std::string id = {}, int level = 2);
  void say(std::string text, std::string look = {});
  void add(Table table);
  void add(Figure figure);
  void add(Terms terms);
  void fold(std::string summary, Document inside, std::string id = {}, bool open = false);
  void fold(std::string summary, Table inside, std::string id = {});
  void append(Document part);
};
struct Document::Block {
  std::variant<Heading, Paragraph, Table, Figure, Terms, Details> content;
};

/// Text of a cell and of a heading for readers, marks included.
std::string text_of(const Table::Cell& cell, const Table::Column& column);
std::string heading_of(const Table::Column& column);
/// Figures with a chart, folded ones among them, in their order.
std::vector<const Figure*> charts_of(const std::vector<Document::Block>& blocks);
/// True if the row is a title of the rows below it.
bool is_title(const Table& table, const Table::Row& row);

/// A page that needs no other file except those named by its figures. Throws FileError if gnuplot
/// cannot draw.
std::string to_html(const Document& document);
/// Lines of at most 100 columns, if words and first columns allow it; no figures.
std::string to_text(const Document& document);
std::string to_text(const Table& table);
/// Rows of |cells|.
std::string to_markdown(const Table& table);
/// The provenance, and each table that has a key.
Json to_json(const Document& document);
/// An array with an object for each row.
Json to_json(const Table& table);
/// The keys, then a line for each row; numbers to the last bit.
std::string to_csv(const Table& table);
/// Both without the end of the line.
std::string csv_header(const std::vector<Table::Column>& columns);
std::string csv_line(const std::vector<Table::Column>& columns,
                     const std::vector<Table::Cell>& cells);

/// The files of figures that name one and have a chart, see write_chart_files. Throws FileError.
void write_figures(const std::filesystem::path& folder, const Document& document);

}  // namespace bipot
