#pragma once

#include <filesystem>
#include <string>

namespace bipot {

/// Throws FileError unless `path` is an existing regular file, also at the end of links. A reader
/// of a pipe or of a device might wait for ever, one of a folder reads nothing.
void require_regular_file(const std::filesystem::path& path);

/// The bytes of a regular file, without the mark that editors and spreadsheets put before UTF-8.
/// Throws FileError.
std::string read_text_file(const std::filesystem::path& path);

}  // namespace bipot
