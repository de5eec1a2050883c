#include "bench/page/page_curves.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <string_view>

#include "bench/report/csv_text.h"
#include "core/base/file_error.h"
#include "core/base/number_text.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// "file column" and the unit of each column that units.csv names; older runs have none.
std::map<std::string, std::string> read_units(const fs::path& folder) {
  std::map<std::string, std::string> units;
  std::ifstream file(folder / "units.csv");
  for (std::string line; std::getline(file, line);) {
    const auto cells = split_csv_line(line);
    if (cells.size() == 3) units[fs::path(cells[0]).stem().string() + " " + cells[1]] = cells[2];
  }
  return units;
}

std::string_view without_unit(std::string_view name) {
  return name.substr(0, std::min(name.find(" ["), name.size()));
}

/// Tables in the order in which their words appear. Words of the ledger are left out.
std::vector<CurveTable> read_table(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::vector<CurveTable> tables;
  if (!file || !std::getline(file, line)) return tables;
  const std::vector<std::string> names = split_csv_line(line);
  std::map<std::string, std::size_t, std::less<>> table_of;
  std::size_t word = names.size();  // column of words, if there is one
  std::vector<double> row;
  while (std::getline(file, line)) {
    const auto cells = split_csv_line(line);
    if (cells.size() != names.size() || file.eof()) continue;  // the run was killed in this line
    if (tables.empty()) {
      for (std::size_t k = 0; k < cells.size(); ++k) {
        if (word == names.size() && !whole_number<double>(cells[k])) word = k;
      }
    }
    row.clear();
    for (std::size_t k = 0; k < cells.size(); ++k) {
      if (k != word) row.push_back(whole_number<double>(cells[k]).value_or(kNaN));
    }
    const bool names_part = word < cells.size() && path.stem() != "ledger";
    const std::string part = names_part ? cells[word] : std::string();
    auto found = table_of.find(part);
    if (found == table_of.end()) {
      found = table_of.emplace(part, tables.size()).first;
      CurveTable table{.file = path.stem().string(), .part = part};
      for (std::size_t k = 0; k < names.size(); ++k) {
        if (k != word) table.names.push_back(names[k]);
      }
      table.columns.resize(table.names.size());
      if (table.column("time") == nullptr) throw FileError(path, "", "has no column 'time'");
      tables.push_back(std::move(table));
    }
    for (std::size_t k = 0; k < row.size(); ++k) tables[found->second].columns[k].push_back(row[k]);
  }
  return tables;
}

}  // namespace

const std::vector<double>* CurveTable::column(const std::string& name) const {
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (without_unit(names[k]) == name) return &columns[k];
  }
  return nullptr;
}

std::vector<CurveTable> read_curves(const fs::path& folder) {
  std::vector<CurveTable> tables;
  const std::map<std::string, std::string> units = read_units(folder);
  for (const char* file : {"ledger.csv", "walls.csv", "observables.csv", "gates.csv"}) {
    for (CurveTable& table : read_table(folder / file)) {
      for (std::string& name : table.names) {
        const auto unit = units.find(table.file + " " + name);
        if (unit != units.end()) name += " [" + unit->second + "]";
      }
      tables.push_back(std::move(table));
    }
  }
  return tables;
}

CurveTable thinned_curves(const CurveTable& table, std::size_t points) {
  const std::size_t rows = table.columns.empty() ? 0 : table.columns.front().size();
  if (rows <= points) return table;
  CurveTable thin{.file = table.file, .part = table.part, .names = table.names};
  const std::size_t stretches = points / 2;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const std::vector<double>& column = table.columns[c];
    const std::string_view name = without_unit(table.names[c]);
    const bool axis = name == "time" || name == "step";
    std::vector<double> values;
    for (std::size_t s = 0; s < stretches; ++s) {
      const auto begin = column.begin() + static_cast<std::ptrdiff_t>(s * rows / stretches);
      const auto end = column.begin() + static_cast<std::ptrdiff_t>((s + 1) * rows / stretches);
      if (axis) {
        values.insert(values.end(), {*begin, *(end - 1)});
        continue;
      }
      auto low = begin, high = begin;  // a number, where the stretch has one
      for (auto at = begin; at != end; ++at) {
        if (*at < *low || std::isnan(*low)) low = at;
        if (*at > *high || std::isnan(*high)) high = at;
      }
      if (high < low) std::swap(low, high);
      values.insert(values.end(), {*low, *high});
    }
    thin.columns.push_back(std::move(values));
  }
  return thin;
}

}  // namespace bipot
