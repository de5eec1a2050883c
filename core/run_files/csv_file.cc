#include "core/run_files/csv_file.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <utility>
#include <vector>

namespace bipot {

namespace fs = std::filesystem;

CsvFile::CsvFile(fs::path path, const std::string& header, int keep_up_to)
    : path_(std::move(path)) {
  std::vector<std::string> kept;
  if (keep_up_to >= 0) {
    std::ifstream before(path_);
    std::string line;
    std::getline(before, line);
    const bool known = (header + ",").rfind(line + ",", 0) == 0;
    std::string missing;
    for (auto more =
             std::count(header.begin() + static_cast<std::ptrdiff_t>(known ? line.size() : 0),
                        header.end(), ',');
         more > 0; --more) {
      missing += ",nan";
    }
    while (known && std::getline(before, line)) {
      int step = 0;
      const auto [end, failure] = std::from_chars(line.data(), line.data() + line.size(), step);
      if (failure == std::errc() && step <= keep_up_to) kept.push_back(line + missing);
    }
  }
  file_.reset(std::fopen(path_.c_str(), "w"));
  if (!file_) throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  row(header);
  for (const std::string& line : kept) row(line);
}

void CsvFile::row(const std::string& line) {
  const std::string text = line + "\n";
  if (std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() ||
      std::fflush(file_.get()) != 0) {
    throw FileError(path_, "", std::string("cannot write: ") + std::strerror(errno));
  }
}

}  // namespace bipot
