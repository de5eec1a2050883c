#include "bench/compare/comparison_store.h"

#include <fmt/format.h>

#include <cctype>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/compare/comparison_rows.h"
#include "bench/report/csv_text.h"
#include "bench/report/json_output.h"
#include "core/base/file_error.h"
#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "core/problem_files/fclib_file.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

std::string key_of(const std::string& problem, const std::string& solver, double tol, bool warm) {
  return fmt::format("{}|{}|{}|{}", problem, solver, tol, warm);
}

std::string key_of(const Comparison::Row& row) {
  return key_of(row.problem, row.solver, row.tol, row.warm != 0);
}

/// A problem's name as a file name.
std::string file_stem(const std::string& name) {
  std::string stem = name;
  for (char& c : stem) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' ||
                       c == '_' || c == '@' || c == '=';
    if (!plain) c = '_';
  }
  return stem;
}

/// Of which a reference is: names that differ may have the same stem.
std::string problem_of(const fs::path& reference) {
  const Json file = Json::parse(read_text_file(reference), nullptr, false);
  return file.is_object() ? file.value("problem", "") : "";
}

/// Of a problem that cannot be read. It may be mended before the comparison goes on.
bool is_unread(const Comparison::Row& row) {
  return row.dim == 0 && row.status == to_string(SolveStatus::kInvalidInput);
}

/// Limits that all rows of a folder have in common.
Json limits_json(const Comparison::Options& o) {
  return {{"time_limit", o.time_limit},
          {"reference_time_limit", o.reference_time_limit},
          {"repeat", o.repeat},
          {"min_time", o.min_time},
          {"try_all", o.try_all}};
}

}  // namespace

ComparisonStore::ComparisonStore(const Comparison::Options& options) : folder_(options.out) {
  if (folder_.empty()) return;
  std::error_code failed;
  fs::create_directories(folder_ / "references", failed);
  if (!failed) fs::create_directories(folder_ / "problems", failed);
  if (failed) throw FileError(folder_, "", failed.message());
  lock_ = std::make_unique<FolderLock>(folder_);
  const fs::path limits = folder_ / "limits.json";
  const std::string now = json_text(limits_json(options));
  if (fs::exists(limits)) {
    // Cut off: "<discarded>", which differs.
    const std::string before = json_text(Json::parse(read_text_file(limits), nullptr, false));
    if (before != now) {
      throw std::invalid_argument(
          fmt::format("{}: rows were made under {}, not {}: name another folder", folder_.string(),
                      before, now));
    }
  } else {
    write_text_file(limits, json_text(limits_json(options), 2) + '\n');
  }
  const fs::path rows = folder_ / "rows.csv", histories = folder_ / "history.csv";
  if (fs::exists(rows)) {
    for (Comparison::Row& row : read_csv_rows(rows)) {
      if (is_unread(row)) continue;
      rows_.insert_or_assign(key_of(row), std::move(row));
    }
  }
  if (fs::exists(histories)) {
    for (Comparison::History& history : read_csv_histories(histories)) {
      histories_.insert_or_assign({history.problem, history.solver}, std::move(history));
    }
  }
  rows_file_ = open_csv_table(rows, csv_header());
  history_file_ = open_csv_table(histories, history_csv_header());
}

const Comparison::Row* ComparisonStore::find(const std::string& problem, const std::string& solver,
                                             double tol, bool warm) const {
  const auto found = rows_.find(key_of(problem, solver, tol, warm));
  return found == rows_.end() ? nullptr : &found->second;
}

void ComparisonStore::append(const Comparison::Row& row, const Comparison::History& history) {
  if (!history.points.empty()) {
    Comparison::History& kept = histories_[{history.problem, history.solver}];
    if (!(kept.tol < history.tol)) kept = history;  // the tightest
  }
  if (folder_.empty() || is_unread(row)) return;
  if (!history.problem.empty()) history_file_ << to_csv(history) << std::flush;
  rows_file_ << to_csv(row) << std::endl;
  if (!rows_file_ || !history_file_) throw FileError(folder_ / "rows.csv", "", "cannot be written");
}

void ComparisonStore::finish() const {
  if (folder_.empty()) return;
  const fs::path path = folder_ / "rows.csv";
  const std::vector<Comparison::Row> lines = read_csv_rows(path);
  std::vector<const Comparison::Row*> rows;
  std::map<std::string, std::size_t> places;
  for (const Comparison::Row& row : lines) {
    const auto [place, fresh] = places.try_emplace(key_of(row), rows.size());
    if (fresh) rows.push_back(&row);
    rows[place->second] = &row;
  }
  if (rows.size() == lines.size()) return;
  std::string text = csv_header() + '\n';
  for (const Comparison::Row* row : rows) text += to_csv(*row) + '\n';
  write_text_file(path, text);
}

const Comparison::History* ComparisonStore::history(const std::string& problem,
                                                    const std::string& solver) const {
  const auto found = histories_.find({problem, solver});
  return found == histories_.end() ? nullptr : &found->second;
}

std::optional<ReferenceSolution> ComparisonStore::reference(const std::string& problem) const {
  const fs::path path = reference_path(problem);
  if (folder_.empty() || !fs::exists(path)) return std::nullopt;
  return read_reference(path);
}

void ComparisonStore::write(const ProblemSource& source, const TestProblem& problem,
                            const ReferenceSolution& reference) const {
  if (folder_.empty()) return;
  const fs::path reference_file = reference_path(source.name);
  write_reference(reference_file, source.name, reference);
  // Problems from files are not copied.
  if (fs::exists(source.target) && !source.target.ends_with(".toml")) return;
  if (problem.problem.num_contacts() == 0) return;
  write_fclib(
      folder_ / "problems" / reference_file.filename().replace_extension(".hdf5"), problem.problem,
      {.title = source.name, .description = problem.origin},
      problem.start.size() > 0 ? std::vector<Vector>{problem.start} : std::vector<Vector>{});
}

fs::path ComparisonStore::reference_path(const std::string& problem) const {
  fs::path path = folder_ / "references" / (file_stem(problem) + ".json");
  for (int k = 2; fs::exists(path) && problem_of(path) != problem; ++k) {
    path.replace_filename(fmt::format("{}~{}.json", file_stem(problem), k));
  }
  return path;
}

}  // namespace bipot
