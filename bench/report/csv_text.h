#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/file_error.h"
#include "core/base/number_text.h"

namespace bipot {

/// A field in quotes, with quotes inside doubled (RFC 4180). Ends of lines become spaces, so that a
/// line of the file is a row of the table.
std::string csv_text(std::string_view text);

/// The fields of one line without quotes: the inverse of csv_text.
std::vector<std::string> split_csv_line(std::string_view line);

/// The rows of a file with this first line, `columns` fields each. An incomplete last line, from a
/// stopped program, is left out. Throws FileError with the line.
std::vector<std::vector<std::string>> read_csv_table(const std::filesystem::path& path,
                                                     std::string_view header, std::size_t columns);

/// The same of a text that was read from `path`.
std::vector<std::vector<std::string>> csv_table_of(std::string_view text,
                                                   const std::filesystem::path& path,
                                                   std::string_view header, std::size_t columns);

/// A field as a number. Throws FileError.
template <class Number>
Number csv_number(const std::string& field, const std::filesystem::path& path) {
  const auto value = whole_number<Number>(field);
  if (!value) throw FileError(path, "", "'" + field + "' is not a number");
  return *value;
}

/// Opens such a file for further rows. A row that was cut off is removed; a new file gets the first
/// line. Throws FileError.
std::ofstream open_csv_table(const std::filesystem::path& path, std::string_view header);

}  // namespace bipot
