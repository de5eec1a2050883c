#include "bench/problems/observable_charts.h"

#include <algorithm>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "core/run_files/observable_output.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

using Charts = std::vector<std::pair<std::string, Chart>>;  // each with the name of its files

Chart::Series column_over(const NumberTable& table, const std::string& x, const std::string& y,
                          const std::string& name, int style) {
  Chart::Series series{.name = name, .style = style};
  series.kind =
      table.rows.size() > 60 ? Chart::Series::Kind::kLine : Chart::Series::Kind::kLinePoints;
  const std::size_t at_x = table.column(x), at_y = table.column(y);
  for (const auto& row : table.rows) series.points.push_back({.x = row[at_x], .y = row[at_y]});
  return series;
}

Chart over_time(const NumberTable& rows, const std::string& title,
                const std::vector<std::pair<std::string, std::string>>& columns) {
  Chart chart{.title = title, .x = {.label = "time [s]"}};
  for (const auto& [column, name] : columns) {
    chart.series.push_back(
        column_over(rows, "time", column, name, static_cast<int>(chart.series.size())));
  }
  return chart;
}

bool has_column(const NumberTable& table, const std::string& name) {
  return std::find(table.names.begin(), table.names.end(), name) != table.names.end();
}

void add_profile(const fs::path& folder, const ProfileChoice& choice, Charts& charts) {
  const std::string across = std::string(1, "xyz"[choice.axis]) + " [m]";
  const NumberTable profile = read_number_table(folder / "profile_mean.csv");
  Chart velocity{.title = "mean velocity across the bins", .x = {.label = across}};
  velocity.y.label = "velocity [m/s]";
  const bool space = has_column(profile, "vz");
  for (const char axis : std::string(space ? "xyz" : "xy")) {
    velocity.series.push_back(column_over(profile, "position", std::string("v") + axis,
                                          std::string("along ") + axis,
                                          static_cast<int>(velocity.series.size())));
  }
  charts.emplace_back("observables_velocity", velocity);
  Chart stress{.title = "mean stress across the bins", .x = {.label = across}};
  stress.y.label = "stress [Pa]";
  for (const std::string component : {"xx", "yy", "zz", "xy", "xz", "yz"}) {
    if (!has_column(profile, "stress_" + component)) continue;  // in 2D
    stress.series.push_back(column_over(profile, "position", "stress_" + component, component,
                                        static_cast<int>(stress.series.size())));
  }
  charts.emplace_back("observables_stress", stress);
  Chart fraction{.title = "mean solid fraction across the bins", .x = {.label = across}};
  fraction.y.label = "solid fraction";
  fraction.series = {column_over(profile, "position", "solid_fraction", "solid fraction", 0)};
  fraction.key = Chart::Key::kNone;
  charts.emplace_back("observables_fraction", fraction);
}

void add_forces(const fs::path& folder, Charts& charts) {
  const NumberTable forces = read_number_table(folder / "forces_mean.csv");
  Chart chart{.title = "distribution of normal forces", .x = {.label = "force / mean force"}};
  chart.y = {.label = "probability density", .kind = Chart::Axis::Kind::kLog};
  Chart::Series series{.name = "density"};
  const std::size_t low = forces.column("low"), high = forces.column("high"),
                    density = forces.column("density");
  // The last bin holds all larger forces: it has no width, so no density.
  for (std::size_t k = 0; k + 1 < forces.rows.size(); ++k) {
    const auto& row = forces.rows[k];
    // An empty bin cannot be shown on a logarithmic axis.
    if (row[density] > 0)
      series.points.push_back({.x = 0.5 * (row[low] + row[high]), .y = row[density]});
  }
  chart.series = {series};
  chart.key = Chart::Key::kNone;
  charts.emplace_back("observables_forces", chart);
}

}  // namespace

void write_observable_charts(const fs::path& folder, const std::optional<ProfileChoice>& profile,
                             bool draw) {
  const NumberTable rows = read_number_table(folder / "observables.csv");
  Charts charts;
  charts.emplace_back("observables_state",
                      over_time(rows, "state of the packing",
                                {{"coordination", "coordination"},
                                 {"coordination_without_rattlers", "without rattlers"},
                                 {"solid_fraction", "solid fraction"},
                                 {"sliding_share", "share of sliding contacts"}}));
  charts.emplace_back("observables_flow",
                      over_time(rows, "state of flow",
                                {{"friction", "τ/P"}, {"inertial_number", "inertial number"}}));
  std::vector<std::pair<std::string, std::string>> fluxes;
  for (const std::string& name : rows.names) {
    if (name.rfind("flux_", 0) == 0) fluxes.emplace_back(name, name.substr(5));
  }
  if (!fluxes.empty()) {
    Chart chart = over_time(
        rows, has_column(rows, "stress_zz") ? "flux through faces" : "flux through lines", fluxes);
    chart.y.label = "flux [kg/s]";
    charts.emplace_back("observables_flux", chart);
  }
  if (profile && fs::exists(folder / "profile_mean.csv")) add_profile(folder, *profile, charts);
  add_forces(folder, charts);
  for (const auto& [name, chart] : charts) {
    draw ? write_chart_files(folder, name, chart) : write_chart_data(folder, name, chart);
    if (!draw) fs::remove(folder / (name + ".svg"));  // of an earlier part
  }
}

}  // namespace bipot
