#include "core/scene_files/position_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>

#include "core/base/nearest_name.h"
#include "core/base/number_text.h"
#include "core/files/input_file.h"
#include "core/scene_files/scene_file.h"

namespace bipot {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto drop = [](char c) { return std::isspace(static_cast<unsigned char>(c)) || c == '"'; };
  while (!text.empty() && drop(text.front())) text.remove_prefix(1);
  while (!text.empty() && drop(text.back())) text.remove_suffix(1);
  return text;
}

/// Between commas, semicolons or tabs; of a line without them, between blanks.
std::vector<std::string_view> cells_of(std::string_view line) {
  const bool by_blanks = line.find_first_of(",;\t") == std::string_view::npos;
  if (by_blanks) line = trimmed(line);
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = line.find_first_of(by_blanks ? " " : ",;\t");
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return cells;
    line.remove_prefix(end + 1);
    if (by_blanks) line = trimmed(line);
  }
}

[[noreturn]] void refuse_line(const std::filesystem::path& path, int line, const std::string& why) {
  throw SceneFileError(fmt::format("{}:{}: {}", path.string(), line, why));
}

}  // namespace

std::vector<PositionRow> read_positions(const std::filesystem::path& path, int dim) {
  std::istringstream file(read_text_file(path));
  std::string text;
  std::getline(file, text);
  std::vector<std::string> head;
  std::string_view names = text;
  if (names.starts_with('#')) names.remove_prefix(1);  // as numpy.savetxt writes it
  for (const std::string_view cell : cells_of(names)) {
    head.emplace_back(cell);
    for (char& c : head.back()) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  struct Column {
    const char* name;
    double* (*place)(PositionRow&);
    bool required;
    std::size_t at;
  };
  std::vector<Column> columns = {
      {"x", [](PositionRow& r) { return &r.x[0]; }, true, 0},
      {"y", [](PositionRow& r) { return &r.x[1]; }, true, 0},
      {"radius", [](PositionRow& r) { return &r.radius; }, true, 0},
      {"vx", [](PositionRow& r) { return &r.v[0]; }, false, 0},
      {"vy", [](PositionRow& r) { return &r.v[1]; }, false, 0},
  };
  if (dim == 3) {
    columns.insert(columns.end(),
                   {{"z", [](PositionRow& r) { return &r.x[2]; }, true, 0},
                    {"vz", [](PositionRow& r) { return &r.v[2]; }, false, 0},
                    {"spin_x", [](PositionRow& r) { return &r.spin[0]; }, false, 0},
                    {"spin_y", [](PositionRow& r) { return &r.spin[1]; }, false, 0},
                    {"spin_z", [](PositionRow& r) { return &r.spin[2]; }, false, 0}});
  } else {
    columns.push_back({"spin", [](PositionRow& r) { return &r.spin[2]; }, false, 0});
  }
  const std::vector<std::string> of_others =
      dim == 3 ? std::vector<std::string>{"spin"}
               : std::vector<std::string>{"z", "vz", "spin_x", "spin_y", "spin_z"};
  for (const std::string& other : of_others) {
    if (std::find(head.begin(), head.end(), other) == head.end()) continue;
    refuse_line(path, 1,
                fmt::format("has a column {}: {}", other,
                            dim == 3 ? "spheres have spin_x, spin_y and spin_z"
                                     : "spheres need [[spheres]]"));
  }
  std::vector<std::string> optional;
  for (const Column& column : columns) {
    if (!column.required) optional.emplace_back(column.name);
  }
  for (const std::string& name : head) {
    if (std::ranges::any_of(columns, [&](const Column& c) { return name == c.name; })) continue;
    if (name.size() < 3 || nearest_name(name, optional).empty()) continue;  // of another kind
    refuse_line(path, 1, unknown_name_message("column", name, optional));
  }
  for (Column& column : columns) {
    const auto it = std::find(head.begin(), head.end(), column.name);
    column.at = static_cast<std::size_t>(it - head.begin());
    if (std::count(it, head.end(), column.name) > 1) {
      refuse_line(path, 1, fmt::format("has two columns '{}'", column.name));
    }
    if (it == head.end() && column.required) {
      refuse_line(path, 1,
                  fmt::format("no column '{}' among {}", column.name, fmt::join(head, ", ")));
    }
  }
  std::erase_if(columns, [&](const Column& column) { return column.at == head.size(); });
  std::vector<PositionRow> rows;
  for (int line = 2; std::getline(file, text); ++line) {
    if (trimmed(text).empty()) continue;
    const std::vector<std::string_view> cells = cells_of(text);
    if (cells.size() != head.size()) {
      refuse_line(path, line,
                  fmt::format("{} columns, the head has {}", cells.size(), head.size()));
    }
    PositionRow& row = rows.emplace_back();
    for (const Column& column : columns) {
      const std::string_view cell = cells[column.at];
      const auto value = printed_number(cell);
      if (!value || !std::isfinite(*value)) {
        refuse_line(path, line, fmt::format("{}: '{}' is no finite number", column.name, cell));
      }
      *column.place(row) = *value;
    }
    if (!(row.radius > 0)) {
      refuse_line(path, line, fmt::format("radius: {} is not positive", row.radius));
    }
  }
  return rows;
}

}  // namespace bipot
