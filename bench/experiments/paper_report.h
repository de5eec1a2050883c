#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiments/paper_item.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"

namespace bipot {

/// An item of the report, run now or kept from an earlier run into the same folder.
struct PaperEntry {
  enum class Status {
    kNotRun,
    kDone,
    kFailed,      ///< `message` says why; there is no result
    kInterrupted  ///< stopped before it was done; there is no result
  };
  std::string name, title, command;
  Status status = Status::kNotRun;
  std::string message;
  bool quick = false;
  double wall_seconds = 0, cpu_seconds = 0;
  BuildInfo build;   ///< that ran it
  std::string date;  ///< of the run, UTC
  PaperResult result;

  int checks() const;  ///< numbers with `holds`
  int held() const;    ///< of them, those that hold
};
std::string_view to_string(PaperEntry::Status status);

struct PaperReport {
  std::string command;              ///< of the last run
  std::vector<PaperEntry> entries;  ///< in the order of the table of items
};

/// "{name}" in the paragraphs replaced by the numbers with their units; empty commands replaced by
/// `command`. Throws std::invalid_argument for a placeholder that is no number's name, two numbers
/// of one name, or a figure with neither or both of chart and file.
void complete(PaperResult& result, const std::string& command);

/// For reading: `digits` significant ones, integers whole with groups of three, "undefined" for
/// NaN, 1.5e-9, unit behind a no-break space.
std::string to_text(double value, const std::string& unit, int digits);

/// Everything, charts' points included. NaN is null.
Json to_json(const PaperReport& report);
/// The entries of a results.json of an earlier run; empty when there is none. Throws FileError for
/// a file that is something else.
std::vector<PaperEntry> read_entries(const std::filesystem::path& file);

}  // namespace bipot
