#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/base/file_error.h"

namespace bipot {

/// Adds a comma and the number to a line: 9 digits, nan without a sign.
void add_number(std::string& line, double x);

/// The same for several numbers, and for the components of vectors.
template <class... Values>
void add_numbers(std::string& line, const Values&... values) {
  const auto add = [&](const auto& value) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>) {
      add_number(line, value);
    } else {
      for (const double x : value) add_number(line, x);
    }
  };
  (add(values), ...);
}

/// "12,0.024": the begin of a row.
std::string step_and_time(int step, double time);

/// ",vx [m/s],vy [m/s]": a column of each axis, in D dimensions.
template <int D>
std::string columns_of_axes(std::string_view before, std::string_view after) {
  std::string columns;
  for (const char axis : std::string_view("xyz").substr(0, D)) {
    columns.append(",").append(before).append(1, axis).append(after);
  }
  return columns;
}

/// A text as one cell of a row: in quotes if it has commas or quotes.
std::string csv_cell(std::string_view text);

/// Columns as "time [s],contacts" without their units: "time,contacts".
std::string without_units(std::string_view columns);

/// units.csv: a row `file,column,unit` for each column that has a unit.
std::string unit_rows(std::string_view file, std::string_view columns);
inline constexpr const char* kUnitsHeader = "file,column,unit";

/// A CSV file whose lines are on disk as soon as they are written. Throws FileError.
class CsvFile {
 public:
  /// Begins a file with the names in `columns`, without their units. Rows of an existing file whose
  /// first number is at most `keep_up_to` are kept, if its columns are the first of these, with or
  /// without units. Columns that it lacks are nan in those rows. Such rows under other columns are
  /// not lost: FileError, as for a row without a number.
  CsvFile(std::filesystem::path path, const std::string& columns, int keep_up_to);
  void row(const std::string& line);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace bipot
