#include "bench/compare/comparison_rows.h"

#include <fmt/format.h>

#include <algorithm>

#include "bench/compare/comparison_measures.h"
#include "bench/report/csv_text.h"
#include "bench/report/labels.h"
#include "core/base/number_text.h"

namespace bipot {
namespace {

template <class Value>
ComparisonColumn row_column(std::string key, std::string name, Value Comparison::Row::*field,
                            std::string meaning, std::string (*show)(double) = nullptr) {
  const bool filter = show == nullptr && key != "message";
  ComparisonColumn made{.column = {.key = std::move(key),
                                   .name = std::move(name),
                                   .show = show,
                                   .meaning = std::move(meaning),
                                   .filter = filter}};
  made.cell = [field](const Comparison::Row& r) { return Table::Cell(r.*field); };
  made.read = [field](Comparison::Row& r, const std::string& text,
                      const std::filesystem::path& path) {
    if constexpr (std::is_same_v<Value, std::string>) {
      r.*field = text;
    } else {
      r.*field = csv_number<Value>(text, path);
    }
  };
  return made;
}

std::vector<Table::Column> columns_of_rows() {
  std::vector<Table::Column> columns;
  for (const ComparisonColumn& c : comparison_columns()) columns.push_back(c.column);
  return columns;
}

std::vector<Table::Cell> cells_of(const Comparison::Row& row) {
  std::vector<Table::Cell> cells;
  for (const ComparisonColumn& c : comparison_columns()) cells.push_back(c.cell(row));
  return cells;
}

}  // namespace

const std::vector<ComparisonColumn>& comparison_columns() {
  using Row = Comparison::Row;
  static const std::vector<ComparisonColumn> columns = {
      row_column("problem", "problem", &Row::problem, "name of the problem"),
      row_column("solver", "solver", &Row::solver, "see `bipot list solvers`"),
      row_column("tol", "tolerance", &Row::tol, "that the solver was given", tolerance_label),
      row_column("warm", "", &Row::warm, "1: from the step before, 0: from s = 0", count_label),
      row_column("contacts", "", &Row::contacts, "candidate contacts", count_label),
      row_column("dim", "", &Row::dim, "rows of a contact", count_label),
      row_column("status", "status", &Row::status, "how the solve ended"),
      row_column("iterations", "iterations", &Row::iterations, "costs differ between solvers",
                 count_label),
      row_column("repeats", "", &Row::repeats, "solves behind the times", count_label),
      row_column("total_min", "wall time", &Row::total_min,
                 "least wall time of set-up and solve [s]", seconds_label),
      row_column("setup_min", "of it set-up", &Row::setup_min, "least wall time [s]",
                 seconds_label),
      row_column("setup_median", "", &Row::setup_median, "[s]", seconds_label),
      row_column("solve_min", "", &Row::solve_min, "[s]", seconds_label),
      row_column("solve_median", "", &Row::solve_median, "[s]", seconds_label),
      row_column("cpu_min", "time", &Row::cpu_min,
                 "least CPU time of a repeat, final check included [s]", seconds_label),
      row_column("guarded", "guarded", &Row::guarded, "max(ε, η): what the tolerance bounds",
                 error_label),
      row_column("epsilon", "", &Row::epsilon, "", error_label),
      row_column("eta", "", &Row::eta, "", error_label),
      row_column("raw42", "raw (42)", &Row::raw42, "undefined where nothing slides", error_label),
      row_column("natural_map", "natural map", &Row::natural_map, "as other codes use it",
                 error_label),
      row_column("take_off", "take-off", &Row::take_off, "contacts without force", count_label),
      row_column("stick", "stick", &Row::stick, "contacts that stick", count_label),
      row_column("slip", "slip", &Row::slip, "contacts that slide", count_label),
      row_column("velocity_error", "velocity error", &Row::velocity_error,
                 "true error, energy norm, relative", error_label),
      row_column("force_error", "force error", &Row::force_error,
                 "true error of the resultant, worst body, relative", error_label),
      row_column("contact_force_error", "contact force error", &Row::contact_force_error,
                 "true error of the worst contact force, where these are unique", error_label),
      row_column("penetration_velocity", "", &Row::penetration_velocity, "[m/s]", error_label),
      row_column("penetration", "penetration", &Row::penetration,
                 "overlap added in a step, over the smallest radius", error_label),
      row_column("dissipated", "", &Row::dissipated, "[J]", value_label),
      row_column("energy_error", "energy error", &Row::energy_error,
                 "true relative error of the dissipated energy", error_label),
      row_column("answer", "", &Row::answer, "the nearest: 1 the reference, 0 none known",
                 count_label),
      row_column("commit", "", &Row::commit, "of the program that made the row"),
      row_column("message", "", &Row::message, "what the solver said"),
  };
  return columns;
}

std::string csv_header() { return csv_header(columns_of_rows()); }

std::string to_csv(const Comparison::Row& row) {
  return csv_line(columns_of_rows(), cells_of(row));
}

Table rows_table(const Comparison& comparison) {
  std::vector<const Comparison::Row*> pareto;
  for (const Comparison::Problem& p : comparison.problems) {
    for (const Comparison::Row* row : pareto_rows(p, comparison.rows)) pareto.push_back(row);
  }
  Table table{.columns = columns_of_rows(), .sortable = true};
  for (Table::Column& column : table.columns) column.filter |= column.key == "tol";
  table.columns.push_back({.name = "Pareto",
                           .meaning = "no row of the problem is both faster and more accurate",
                           .filter = true});
  const auto status =
      std::ranges::find_if(table.columns, [](const Table::Column& c) { return c.key == "status"; });
  for (const auto* rows : {&comparison.rows, &comparison.warm_rows}) {
    for (const Comparison::Row& row : *rows) {
      std::vector<Table::Cell> cells = cells_of(row);
      cells[static_cast<std::size_t>(status - table.columns.begin())].tipped(row.message);
      cells.emplace_back(std::ranges::find(pareto, &row) != pareto.end());
      table.add(std::move(cells), row.solved() ? "" : "bad");
    }
  }
  return table;
}

std::vector<Comparison::Row> read_csv_rows(const std::filesystem::path& path) {
  const auto& columns = comparison_columns();
  std::vector<Comparison::Row> rows;
  for (const std::vector<std::string>& fields :
       read_csv_table(path, csv_header(), columns.size())) {
    Comparison::Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].read(row, fields[i], path);
  }
  return rows;
}

std::string history_csv_header() { return "problem,solver,tol,iteration,seconds,epsilon,eta"; }

std::string to_csv(const Comparison::History& history) {
  std::string text;
  for (const Comparison::History::Point& p : history.points) {
    text += fmt::format("{},{},{},{},{:.6g},{},{}\n", csv_text(history.problem),
                        csv_text(history.solver), history.tol, p.iteration, p.seconds, p.epsilon,
                        p.eta);
  }
  return text;
}

std::vector<Comparison::History> read_csv_histories(const std::filesystem::path& path) {
  std::vector<Comparison::History> histories;
  // By problem and solver; a repeated first iteration marks a repeated solve.
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (const std::vector<std::string>& fields : read_csv_table(path, history_csv_header(), 7)) {
    const auto number = [&](std::size_t k) { return csv_number<double>(fields[k], path); };
    const double tol = number(2);
    const Comparison::History::Point point{csv_number<int>(fields[3], path), number(4), number(5),
                                           number(6)};
    const auto [place, fresh] = places.try_emplace({fields[0], fields[1]}, histories.size());
    if (fresh) histories.push_back({fields[0], fields[1], tol, {}});
    Comparison::History& history = histories[place->second];
    if (tol > history.tol) continue;
    const bool again = !history.points.empty() && point.iteration == history.points[0].iteration;
    if (tol < history.tol || again) history.points.clear();
    history.tol = tol;
    history.points.push_back(point);
  }
  return histories;
}

}  // namespace bipot
