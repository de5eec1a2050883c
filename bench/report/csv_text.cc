#include "bench/report/csv_text.h"

#include <fmt/format.h>

#include "core/files/input_file.h"

namespace bipot {

std::string csv_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + '"';
}

std::vector<std::string> split_csv_line(std::string_view line) {
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

std::vector<std::vector<std::string>> read_csv_table(const std::filesystem::path& path,
                                                     std::string_view header, std::size_t columns) {
  return csv_table_of(read_text_file(path), path, header, columns);
}

std::vector<std::vector<std::string>> csv_table_of(std::string_view text,
                                                   const std::filesystem::path& path,
                                                   std::string_view header, std::size_t columns) {
  std::vector<std::vector<std::string>> rows;
  std::size_t begin = 0;
  for (int number = 1;; ++number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string::npos) break;
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + 1;
    if (number == 1) {
      if (line != header) {
        throw FileError(path, "line 1", fmt::format("expected the names {}", header));
      }
      continue;
    }
    rows.push_back(split_csv_line(line));
    if (rows.back().size() != columns) {
      throw FileError(path, fmt::format("line {}", number),
                      fmt::format("{} fields, expected {}", rows.back().size(), columns));
    }
  }
  return rows;
}

std::ofstream open_csv_table(const std::filesystem::path& path, std::string_view header) {
  namespace fs = std::filesystem;
  if (fs::exists(path)) {
    const std::string whole = read_text_file(path);
    if (const std::size_t end = whole.rfind('\n'); end + 1 != whole.size()) {
      // The mark of UTF-8 may stand before the text.
      fs::resize_file(path, fs::file_size(path) - (whole.size() - (end + 1)));
    }
  }
  const bool fresh = !fs::exists(path) || fs::file_size(path) == 0;
  std::ofstream file(path, std::ios::app);
  if (fresh) file << header << std::endl;
  if (!file) throw FileError(path, "", "cannot be written");
  return file;
}

}  // namespace bipot
