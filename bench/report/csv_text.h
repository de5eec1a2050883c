#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bipot {

/// A field in quotes, those inside it doubled (RFC 4180). Ends of line become spaces, so that a
/// line of the file is a row of the table.
std::string csv_text(std::string_view text);

/// The fields of one line, quotes taken off: csv_text backwards.
std::vector<std::string> split_csv_line(std::string_view line);

/// The rows of a file with that first line, `columns` fields each. A last line without its end was
/// being written when its program was stopped: left out. Throws FileError with the line.
std::vector<std::vector<std::string>> read_csv_table(const std::filesystem::path& path,
                                                     std::string_view header, std::size_t columns);

}  // namespace bipot
