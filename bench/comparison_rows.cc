// Columns of a comparison's table, and the CSV file that keeps it.

#include <fmt/format.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "bench/comparison.h"
#include "core/file_error.h"

namespace bipot {
namespace {

Column text_column(std::string_view name, std::string ComparisonRow::*field,
                   std::string_view explanation) {
  return {name, explanation, [field](const ComparisonRow& r) { return r.*field; },
          [field](ComparisonRow& r, const std::string& t) { r.*field = t; }, true};
}

Column number_column(std::string_view name, double ComparisonRow::*field,
                     std::string_view explanation) {
  return {name, explanation,
          [field](const ComparisonRow& r) { return fmt::format("{}", r.*field); },
          [field](ComparisonRow& r, const std::string& t) {
            r.*field = std::strtod(t.c_str(), nullptr);
          },
          false};
}

Column count_column(std::string_view name, int ComparisonRow::*field,
                    std::string_view explanation) {
  return {name, explanation, [field](const ComparisonRow& r) { return std::to_string(r.*field); },
          [field](ComparisonRow& r, const std::string& t) {
            r.*field = static_cast<int>(std::strtol(t.c_str(), nullptr, 10));
          },
          false};
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + '"';
}

std::vector<std::string> split_csv(const std::string& line) {
  std::vector<std::string> fields(1);
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (inside && i + 1 < line.size() && line[i + 1] == '"') {
        fields.back() += line[++i];
      } else {
        inside = !inside;
      }
    } else if (line[i] == ',' && !inside) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  return fields;
}

}  // namespace

const std::vector<Column>& comparison_columns() {
  using Row = ComparisonRow;
  static const std::vector<Column> columns = {
      text_column("problem", &Row::problem, "name of the problem"),
      text_column("solver", &Row::solver, "name of the solver, see `bipot list solvers`"),
      number_column("tol", &Row::tol, "tolerance that the solver was given"),
      count_column("contacts", &Row::contacts, "number of candidate contacts"),
      count_column("dim", &Row::dim, "rows of a contact: 1 without friction, 2 in the plane, 3"),
      text_column("status", &Row::status, "how the solve ended"),
      count_column("iterations", &Row::iterations, "solver's own count; costs differ between them"),
      count_column("repeats", &Row::repeats, "solves behind the times"),
      number_column("total_min", &Row::total_min, "least wall time of set-up and solve [s]"),
      number_column("setup_min", &Row::setup_min, "least wall time of the set-up [s]"),
      number_column("setup_median", &Row::setup_median, "median wall time of the set-up [s]"),
      number_column("solve_min", &Row::solve_min, "least wall time of the iteration [s]"),
      number_column("solve_median", &Row::solve_median, "median wall time of the iteration [s]"),
      number_column("cpu_min", &Row::cpu_min,
                    "least CPU time of a repeat, final check included [s]"),
      number_column("guarded", &Row::guarded, "max(epsilon, eta): what the tolerance bounds"),
      number_column("epsilon", &Row::epsilon, "guarded error in the law of contact, energy ratio"),
      number_column("eta", &Row::eta, "natural map in energy"),
      number_column("raw42", &Row::raw42,
                    "the error in the law without guards; nan where nothing slides"),
      number_column("natural_map", &Row::natural_map,
                    "relative natural map, as other codes use it"),
      count_column("take_off", &Row::take_off, "contacts without force"),
      count_column("stick", &Row::stick, "contacts that stick"),
      count_column("slip", &Row::slip, "contacts that slide"),
      number_column("velocity_error", &Row::velocity_error,
                    "true error of the velocities, energy norm, relative"),
      number_column("force_error", &Row::force_error,
                    "true error of the resultant force, worst body, relative"),
      number_column("contact_force_error", &Row::contact_force_error,
                    "true error of the worst contact force, where these are unique"),
      number_column("penetration_velocity", &Row::penetration_velocity,
                    "largest approach velocity left [m/s]"),
      number_column("penetration", &Row::penetration,
                    "overlap added in a step, fraction of the smallest radius"),
      number_column("dissipated", &Row::dissipated, "energy taken out of the free motion [J]"),
      number_column("energy_error", &Row::energy_error, "true relative error of that energy"),
      text_column("commit", &Row::commit, "version of the program that made the row"),
      text_column("message", &Row::message, "what the solver said"),
  };
  return columns;
}

std::string csv_header() {
  std::string line;
  for (const Column& column : comparison_columns()) {
    if (!line.empty()) line += ',';
    line += column.name;
  }
  return line;
}

std::string to_csv(const ComparisonRow& row) {
  std::string line;
  bool first = true;
  for (const Column& column : comparison_columns()) {
    if (!first) line += ',';
    first = false;
    line += column.text ? quoted(column.write(row)) : column.write(row);
  }
  return line;
}

std::vector<ComparisonRow> read_csv_rows(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw FileError(path, "", "cannot be opened");
  std::ostringstream content;
  content << in.rdbuf();
  const std::string text = content.str();
  std::vector<ComparisonRow> rows;
  std::size_t begin = 0;
  for (int number = 1;; ++number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;  // a line without its end was being written
    const std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    if (number == 1) {
      if (line != csv_header()) throw FileError(path, "line 1", "not a table of this version");
      continue;
    }
    const std::vector<std::string> fields = split_csv(line);
    const auto& columns = comparison_columns();
    if (fields.size() != columns.size()) {
      throw FileError(path, fmt::format("line {}", number),
                      fmt::format("{} fields, expected {}", fields.size(), columns.size()));
    }
    ComparisonRow& row = rows.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].read(row, fields[i]);
  }
  return rows;
}

}  // namespace bipot
