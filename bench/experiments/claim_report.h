#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiments/claim.h"
#include "bench/report/build_info.h"
#include "bench/report/document.h"
#include "bench/report/json_output.h"

namespace bipot {

/// A report of `bipot paper` or `bipot validate`.
struct ClaimReport {
  /// An item of a report, run now or kept from an earlier run into the same folder.
  struct Item {
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
    Findings result;

    int checks() const;  ///< claims with `holds`
    int held() const;    ///< of them, those that hold
  };
  std::string command;      ///< of the last run
  std::vector<Item> items;  ///< in the order of the page
  std::string title, introduction;
  bool complete = true;  ///< false: stopped before items were begun that it does not name
};
std::string to_string(ClaimReport::Item::Status status);

/// The page: an overview, a section for each item, and how it was made.
Document to_document(const ClaimReport& report);

/// Everything, charts' points included. NaN is null.
Json to_json(const ClaimReport& report);
/// The items that to_json wrote; empty if there is no file. Throws FileError for any other file.
std::vector<ClaimReport::Item> read_items(const std::filesystem::path& file);

/// Writes index.html and the JSON under this name; write_figures makes the files of charts. Throws
/// FileError.
void write_report(const std::filesystem::path& folder, const std::string& json_name,
                  const ClaimReport& report);

}  // namespace bipot
