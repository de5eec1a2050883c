#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/base/file_error.h"
#include "core/problem_files/problem_file.h"

/// Any bytes as a problem file: a problem that validates, or a FileError that names the file.
inline int read_fuzzed_problem(const std::uint8_t* data, std::size_t size) {
  static const std::filesystem::path kPath =
      std::filesystem::temp_directory_path() / ("bipot_fuzz_" + std::to_string(getpid()));
  std::FILE* file = std::fopen(kPath.c_str(), "wb");
  if (file == nullptr || std::fwrite(data, 1, size, file) != size) std::abort();
  std::fclose(file);
  try {
    const bipot::ProblemFile read = bipot::read_problem(kPath);
    if (!bipot::validate(read.problem).empty()) std::abort();
  } catch (const bipot::FileError& e) {
    if (std::string(e.what()).find(kPath.string()) == std::string::npos) std::abort();
  }
  return 0;
}
