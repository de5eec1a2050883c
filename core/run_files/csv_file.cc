#include "core/run_files/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

#include "core/files/atomic_file.h"

namespace bipot {

namespace fs = std::filesystem;

namespace {

/// Calls f(name, unit) for each column; the unit may be empty.
template <class F>
void for_each_column(std::string_view columns, F&& f) {
  while (!columns.empty()) {
    const std::string_view column = columns.substr(0, columns.find(','));
    columns.remove_prefix(std::min(columns.size(), column.size() + 1));
    const std::size_t at = column.find(" [");
    if (at == std::string_view::npos) {
      f(column, std::string_view());
    } else {
      f(column.substr(0, at), column.substr(at + 2, column.size() - at - 3));
    }
  }
}

std::ptrdiff_t commas_outside_quotes(std::string_view line) {
  bool inside = false;
  return std::count_if(line.begin(), line.end(), [&](char c) {
    inside ^= c == '"';
    return c == ',' && !inside;
  });
}

}  // namespace

void add_number(std::string& line, double x) {
  if (std::isnan(x)) {
    line += ",nan";
  } else {
    fmt::format_to(std::back_inserter(line), ",{:.9g}", x + 0.0);  // -0 as 0
  }
}

std::string step_and_time(int step, double time) {
  std::string row = fmt::format("{}", step);
  add_number(row, time);
  return row;
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c == '\n' || c == '\r' ? ' ' : c;
  }
  return cell + "\"";
}

std::string without_units(std::string_view columns) {
  std::string names;
  for_each_column(columns, [&](std::string_view name, std::string_view) {
    if (!names.empty()) names += ',';
    names += name;
  });
  return names;
}

std::string unit_rows(std::string_view file, std::string_view columns) {
  std::string rows;
  for_each_column(columns, [&](std::string_view name, std::string_view unit) {
    if (!unit.empty()) rows += fmt::format("{},{},{}\n", file, name, unit);
  });
  return rows;
}

CsvFile::CsvFile(fs::path path, const std::string& columns, int keep_up_to)
    : path_(std::move(path)) {
  const std::string header = without_units(columns);
  std::string kept;
  if (keep_up_to >= 0) {
    std::ifstream before(path_);
    std::string line;
    std::getline(before, line);
    const std::ptrdiff_t commas = commas_outside_quotes(line);
    line = without_units(line);
    const bool known = (header + ",").rfind(line + ",", 0) == 0;
    std::string missing;
    for (auto more =
             std::count(header.begin() + static_cast<std::ptrdiff_t>(known ? line.size() : 0),
                        header.end(), ',');
         more > 0; --more) {
      missing += ",nan";
    }
    while (std::getline(before, line)) {
      const bool torn = before.eof();  // the end of a line is written last
      if (line.empty() || line == "\r") continue;
      int step = 0;
      const auto [end, failure] = std::from_chars(line.data(), line.data() + line.size(), step);
      if (failure != std::errc() && !torn) {
        throw FileError(path_, "", "has a row without the number of its step: " + line);
      }
      if (failure != std::errc() || step > keep_up_to) continue;
      if (torn && end == line.data() + line.size()) continue;  // its step is not known
      if (!known) throw FileError(path_, "", "has other columns than this run: name another --out");
      if (torn || commas_outside_quotes(line) != commas) {
        throw FileError(path_, fmt::format("row of step {}", step), "was cut off");
      }
      kept += line + missing + '\n';
    }
  }
  write_text_file(path_, header + '\n' + kept);  // rows that were there are never lost
  file_.reset(std::fopen(path_.c_str(), "a"));
  if (!file_) throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
}

void CsvFile::row(const std::string& line) {
  const std::string text = line + "\n";
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() ||
      std::fflush(file_.get()) != 0) {
    throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  }
}

}  // namespace bipot
