#include "bench/compare/comparison_rows.h"

#include <fmt/format.h>

#include <cstdlib>
#include <map>
#include <utility>

#include "bench/report/csv_text.h"

namespace bipot {
namespace {

ComparisonColumn text_column(std::string_view name, std::string ComparisonRow::*field,
                             std::string_view explanation) {
  return {name, explanation, [field](const ComparisonRow& r) { return r.*field; },
          [field](ComparisonRow& r, const std::string& t) { r.*field = t; }, true};
}

ComparisonColumn number_column(std::string_view name, double ComparisonRow::*field,
                               std::string_view explanation) {
  return {name, explanation,
          [field](const ComparisonRow& r) { return fmt::format("{}", r.*field); },
          [field](ComparisonRow& r, const std::string& t) {
            r.*field = std::strtod(t.c_str(), nullptr);
          },
          false};
}

ComparisonColumn count_column(std::string_view name, int ComparisonRow::*field,
                              std::string_view explanation) {
  return {name,
          explanation,
          [field](const ComparisonRow& r) { return std::to_string(r.*field); },
          [field](ComparisonRow& r, const std::string& t) {
            r.*field = static_cast<int>(std::strtol(t.c_str(), nullptr, 10));
          },
          false,
          true};
}

}  // namespace

const std::vector<ComparisonColumn>& comparison_columns() {
  using Row = ComparisonRow;
  static const std::vector<ComparisonColumn> columns = {
      text_column("problem", &Row::problem, "name of the problem"),
      text_column("solver", &Row::solver, "name of the solver, see `bipot list solvers`"),
      number_column("tol", &Row::tol, "tolerance that the solver was given"),
      count_column("warm", &Row::warm, "1: started from the step before, 0: from s = 0"),
      count_column("contacts", &Row::contacts, "number of candidate contacts"),
      count_column("dim", &Row::dim, "rows of a contact: 1 without friction, 2 in 2D, 3"),
      text_column("status", &Row::status, "how the solve ended"),
      count_column("iterations", &Row::iterations, "solver's own count; costs differ between them"),
      count_column("repeats", &Row::repeats, "solves behind the times"),
      number_column("total_min", &Row::total_min, "least wall time of set-up and solve [s]"),
      number_column("setup_min", &Row::setup_min, "least wall time of the set-up [s]"),
      number_column("setup_median", &Row::setup_median, "median wall time of the set-up [s]"),
      number_column("solve_min", &Row::solve_min, "least wall time of the iteration [s]"),
      number_column("solve_median", &Row::solve_median, "median wall time of the iteration [s]"),
      number_column(
          "cpu_min", &Row::cpu_min,
          "least CPU time of a repeat, final check included [s]; the time of the reports"),
      number_column("guarded", &Row::guarded, "max(epsilon, eta): what the tolerance bounds"),
      number_column("epsilon", &Row::epsilon, "guarded error in the law of contact, energy ratio"),
      number_column("eta", &Row::eta, "natural map in energy"),
      number_column("raw42", &Row::raw42,
                    "the error in the law without guards; nan where nothing slides"),
      number_column("natural_map", &Row::natural_map,
                    "relative natural map, as other codes use it"),
      count_column("take_off", &Row::take_off, "contacts without force"),
      count_column("stick", &Row::stick, "contacts that stick"),
      count_column("slip", &Row::slip, "contacts that slide"),
      number_column("velocity_error", &Row::velocity_error,
                    "true error of the velocities, energy norm, relative"),
      number_column("force_error", &Row::force_error,
                    "true error of the resultant force, worst body, relative"),
      number_column("contact_force_error", &Row::contact_force_error,
                    "true error of the worst contact force, where these are unique"),
      number_column("penetration_velocity", &Row::penetration_velocity,
                    "largest approach velocity left [m/s]"),
      number_column("penetration", &Row::penetration,
                    "overlap added in a step, fraction of the smallest radius"),
      number_column("dissipated", &Row::dissipated, "energy taken out of the free motion [J]"),
      number_column("energy_error", &Row::energy_error, "true relative error of that energy"),
      count_column("answer", &Row::answer,
                   "exact answer that the errors are distances to: 1 the reference, 2, ... others"),
      text_column("commit", &Row::commit, "version of the program that made the row"),
      text_column("message", &Row::message, "what the solver said"),
  };
  return columns;
}

std::string csv_header() {
  std::string line;
  for (const ComparisonColumn& column : comparison_columns()) {
    if (!line.empty()) line += ',';
    line += column.name;
  }
  return line;
}

std::string to_csv(const ComparisonRow& row) {
  std::string line;
  bool first = true;
  for (const ComparisonColumn& column : comparison_columns()) {
    if (!first) line += ',';
    first = false;
    line += column.text ? csv_text(column.write(row)) : column.write(row);
  }
  return line;
}

std::vector<ComparisonRow> read_csv_rows(const std::filesystem::path& path) {
  const auto& columns = comparison_columns();
  std::vector<ComparisonRow> rows;
  for (const std::vector<std::string>& fields :
       read_csv_table(path, csv_header(), columns.size())) {
    ComparisonRow& row = rows.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].read(row, fields[i]);
  }
  return rows;
}

std::string history_csv_header() { return "problem,solver,tol,iteration,seconds,epsilon,eta"; }

std::string to_csv(const History& history) {
  std::string text;
  for (const HistoryPoint& p : history.points) {
    text += fmt::format("{},{},{},{},{:.6g},{},{}\n", csv_text(history.problem),
                        csv_text(history.solver), history.tol, p.iteration, p.seconds, p.epsilon,
                        p.eta);
  }
  return text;
}

std::vector<History> read_csv_histories(const std::filesystem::path& path) {
  std::vector<History> histories;
  // By problem and solver; where a solve was begun again its first iteration comes again.
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (const std::vector<std::string>& fields : read_csv_table(path, history_csv_header(), 7)) {
    const double tol = std::strtod(fields[2].c_str(), nullptr);
    const HistoryPoint point{static_cast<int>(std::strtol(fields[3].c_str(), nullptr, 10)),
                             std::strtod(fields[4].c_str(), nullptr),
                             std::strtod(fields[5].c_str(), nullptr),
                             std::strtod(fields[6].c_str(), nullptr)};
    const auto [place, fresh] = places.try_emplace({fields[0], fields[1]}, histories.size());
    if (fresh) histories.push_back({fields[0], fields[1], tol, {}});
    History& history = histories[place->second];
    if (tol > history.tol) continue;
    const bool again = !history.points.empty() && point.iteration == history.points[0].iteration;
    if (tol < history.tol || again) history.points.clear();
    history.tol = tol;
    history.points.push_back(point);
  }
  return histories;
}

}  // namespace bipot
