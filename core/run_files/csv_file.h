#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "core/base/file_error.h"

namespace bipot {

/// A CSV file whose lines are on disk as soon as they are written. Throws FileError.
class CsvFile {
 public:
  /// Begins a file with `header`. Rows of an existing file whose first number is at most
  /// `keep_up_to` are kept. Columns that only the new header has are nan in those rows.
  CsvFile(std::filesystem::path path, const std::string& header, int keep_up_to);
  void row(const std::string& line);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace bipot
