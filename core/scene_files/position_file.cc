#include "core/scene_files/position_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>

#include "core/base/types.h"
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

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t end = 0; end != std::string_view::npos; line.remove_prefix(end + 1)) {
    end = line.find_first_of(",;\t");
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) break;
  }
  return cells;
}

[[noreturn]] void refuse_line(const std::filesystem::path& path, int line, const std::string& why) {
  throw SceneFileError(fmt::format("{}:{}: {}", path.string(), line, why));
}

}  // namespace

std::vector<PositionRow> read_positions(const std::filesystem::path& path, int dim) {
  std::istringstream file(read_text_file(path));
  std::string text;
  std::getline(file, text);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);  // the mark that spreadsheets write
  std::vector<std::string> head;
  for (const std::string_view cell : cells_of(text)) {
    head.emplace_back(cell);
    for (char& c : head.back()) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  constexpr const char* kNames[] = {"x", "y", "z", "radius"};
  std::array<std::size_t, 4> column{};
  for (std::size_t k = 0; k < 4; ++k) {
    const auto it = std::find(head.begin(), head.end(), kNames[k]);
    column[k] = to_size(static_cast<int>(it - head.begin()));
    const bool found = it != head.end();
    if (k == 2 && dim == 2) {
      if (found) refuse_line(path, 1, "has a column z: spheres need [[spheres]]");
      continue;
    }
    if (!found) {
      refuse_line(path, 1,
                  fmt::format("no column '{}' among {}", kNames[k], fmt::join(head, ", ")));
    }
  }
  std::vector<PositionRow> rows;
  for (int line = 2; std::getline(file, text); ++line) {
    if (trimmed(text).empty()) continue;
    const std::vector<std::string_view> cells = cells_of(text);
    if (cells.size() != head.size()) {
      refuse_line(path, line,
                  fmt::format("{} columns, the head has {}", cells.size(), head.size()));
    }
    PositionRow& row = rows.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      if (k == 2 && dim == 2) continue;
      const std::string_view cell = cells[column[k]];
      const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), row[k]);
      if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(row[k])) {
        refuse_line(path, line, fmt::format("{}: '{}' is no finite number", kNames[k], cell));
      }
    }
    if (!(row[3] > 0)) refuse_line(path, line, fmt::format("radius: {} is not positive", row[3]));
  }
  return rows;
}

}  // namespace bipot
