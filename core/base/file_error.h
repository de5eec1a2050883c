#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace bipot {

/// A file cannot be read or written, or its content is refused: "path: place: reason".
struct FileError : std::runtime_error {
  FileError(const std::filesystem::path& path, std::string_view place, std::string_view reason)
      : std::runtime_error(path.string() + ": " +
                           (place.empty() ? std::string() : std::string(place) + ": ") +
                           std::string(reason)) {}
};

}  // namespace bipot
