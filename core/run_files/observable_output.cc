#include "core/run_files/observable_output.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/base/number_text.h"
#include "core/files/atomic_file.h"
#include "core/files/input_file.h"
#include "core/observables/observables.h"

namespace bipot {
namespace {

namespace fs = std::filesystem;

/// One number of a measurement, or one of each bin of a profile.
struct Quantity {
  std::string name, unit;
  std::vector<double> values;

  std::string known_unit() const { return unit.empty() ? "1" : unit; }
};

std::string columns_of(const std::vector<Quantity>& list) {
  std::string columns;
  for (const Quantity& q : list) {
    columns += q.unit.empty() ? "," + q.name : fmt::format(",{} [{}]", q.name, q.unit);
  }
  return columns;
}

/// One measurement, in the order of the columns.
template <int D>
std::vector<Quantity> quantities(const Observables<D>& o) {
  const Mat<D> stress = o.stress.total();
  std::vector<Quantity> list = {{D == 2 ? "disks" : "spheres", "", {static_cast<double>(o.bodies)}},
                                {"rattlers", "", {static_cast<double>(o.rattlers)}},
                                {"contacts", "", {static_cast<double>(o.contacts)}},
                                {"sliding_share", "", {o.sliding_share()}},
                                {"coordination", "", {o.coordination}},
                                {"coordination_without_rattlers", "", {o.coordination_without}},
                                {"solid_fraction", "", {o.solid_fraction}},
                                {"fabric_xx", "", {o.fabric(0, 0)}},
                                {"fabric_yy", "", {o.fabric(1, 1)}},
                                {"fabric_xy", "", {o.fabric(0, 1)}},
                                {"stress_xx", "Pa", {stress(0, 0)}},
                                {"stress_yy", "Pa", {stress(1, 1)}},
                                {"stress_xy", "Pa", {0.5 * (stress(0, 1) + stress(1, 0))}},
                                {"pressure", "Pa", {o.stress.pressure()}},
                                {"shear_rate", "1/s", {o.shear_rate()}},
                                {"mean_mass", "kg", {o.mean_mass}},
                                {"inertial_number", "", {o.inertial_number()}},
                                {"friction", "", {o.friction()}}};
  if constexpr (D == 3) {
    const auto mean = [&](int k, int l) { return 0.5 * (stress(k, l) + stress(l, k)); };
    list.insert(list.end(), {{"fabric_zz", "", {o.fabric(2, 2)}},
                             {"fabric_xz", "", {o.fabric(0, 2)}},
                             {"fabric_yz", "", {o.fabric(1, 2)}},
                             {"stress_zz", "Pa", {stress(2, 2)}},
                             {"stress_xz", "Pa", {mean(0, 2)}},
                             {"stress_yz", "Pa", {mean(1, 2)}},
                             {"mean_diameter", "m", {o.mean_diameter}},
                             {"density", "kg/m3", {o.density}}});
  }
  return list;
}

template <int D>
std::string header_of(const Scene<D>& scene) {
  std::string header = "step,time [s]" + columns_of(quantities(Observables<D>{}));
  for (const FluxSurface<D>& crossing : scene.observables->crossings)
    header += fmt::format(",flux_{} [kg/s]", crossing.name);
  return header;
}

/// In the order of the columns.
template <int D>
std::vector<Quantity> quantities(const Profile<D>& p) {
  const auto each = [](const auto& list, const auto& of) {
    std::vector<double> values;
    for (const auto& entry : list) values.push_back(of(entry));
    return values;
  };
  const std::string axes = "xyz";
  std::vector<Quantity> list = {{"position", "m", p.position},
                                {"solid_fraction", "", p.solid_fraction}};
  for (int k = 0; k < D; ++k) {
    list.push_back({fmt::format("v{}", axes[to_size(k)]), "m/s",
                    each(p.velocity, [k](const Vec<D>& v) { return v[k]; })});
  }
  if constexpr (D == 2) {
    list.push_back({"spin", "rad/s", p.spin});
  } else {
    for (int k = 0; k < D; ++k) {
      list.push_back({fmt::format("spin_{}", axes[to_size(k)]), "rad/s",
                      each(p.spin, [k](const Vec3& spin) { return spin[k]; })});
    }
  }
  list.push_back({"temperature", "m2/s2", p.temperature});
  for (int k = 0; k < D; ++k) {
    for (int l = k; l < D; ++l) {
      list.push_back({fmt::format("stress_{}{}", axes[to_size(k)], axes[to_size(l)]), "Pa",
                      each(p.stress, [k, l](const Mat<D>& stress) {
                        return 0.5 * (stress(k, l) + stress(l, k));
                      })});
    }
  }
  return list;
}

template <int D>
std::string bin_columns() {
  return columns_of(quantities(Profile<D>{}));
}

constexpr const char* kForcesHeader = "step,time [s],bin,low,high,count,mean_force [N]";
constexpr const char* kProfileHeader = "step,time [s],bin";  // and bin_columns()

/// Mean and standard deviation of the defined values.
struct Sum {
  int count = 0;
  double sum = 0, squares = 0;
  void add(double x) {
    if (!std::isfinite(x)) return;
    ++count;
    sum += x;
    squares += x * x;
  }
  double mean() const { return count > 0 ? sum / count : kNaN; }
  double deviation() const {
    return count > 0 ? std::sqrt(std::max(0.0, squares / count - mean() * mean())) : kNaN;
  }
};

std::vector<std::vector<double>> rows_from(const NumberTable& table, double starts) {
  std::vector<std::vector<double>> rows = table.rows;
  const std::size_t time = table.column("time");
  std::erase_if(rows, [&](const std::vector<double>& row) { return !(row[time] >= starts); });
  return rows;
}

/// Ratios of means, not means of ratios: tau/P and the inertial number are those of the mean stress
/// and the mean shear rate.
template <int D>
void write_means(const fs::path& folder, double starts) {
  const NumberTable table = read_number_table(folder / "observables.csv");
  const auto rows = rows_from(table, starts);
  std::string text = "quantity,mean,deviation,measurements\n";
  std::map<std::string, double> means;
  for (std::size_t k = 2; k < table.names.size(); ++k) {
    Sum sum;
    for (const auto& row : rows) sum.add(row[k]);
    means[table.names[k]] = sum.mean();
    text += table.names[k];
    add_numbers(text, sum.mean(), sum.deviation());
    text += fmt::format(",{}\n", sum.count);
  }
  const char axes[] = {'x', 'y', 'z'};
  Mat<D> stress;
  for (int k = 0; k < D; ++k) {
    for (int l = k; l < D; ++l) {
      stress(k, l) = stress(l, k) = means[fmt::format("stress_{}{}", axes[k], axes[l])];
    }
  }
  const auto add_ratio = [&](const char* name, double ratio) {
    text += name;
    add_number(text, ratio);
    text += fmt::format(",nan,{}\n", rows.size());
  };
  add_ratio("friction_of_mean_stress", stress_ratio<D>(stress));
  const double inertial =
      means["shear_rate"] *
      (D == 2 ? std::sqrt(means["mean_mass"] / means["pressure"])
              : means["mean_diameter"] * std::sqrt(means["density"] / means["pressure"]));
  add_ratio("inertial_number_of_means", inertial);
  write_text_file(folder / "observables_mean.csv", text);
}

template <int D>
void write_profile_means(const fs::path& folder, double starts) {
  const NumberTable table = read_number_table(folder / "profile.csv");
  std::map<int, std::vector<Sum>> bins;
  const std::size_t bin = table.column("bin"), first = table.column("position");
  for (const auto& row : rows_from(table, starts)) {
    std::vector<Sum>& sums = bins[static_cast<int>(row[bin])];
    sums.resize(row.size() - first);
    for (std::size_t k = first; k < row.size(); ++k) sums[k - first].add(row[k]);
  }
  std::string text = without_units("bin" + bin_columns<D>()) + "\n";
  for (const auto& [number, sums] : bins) {
    text += fmt::format("{}", number);
    for (const Sum& sum : sums) add_number(text, sum.mean());
    text += "\n";
  }
  write_text_file(folder / "profile_mean.csv", text);
}

void write_force_means(const fs::path& folder, double starts) {
  const NumberTable table = read_number_table(folder / "forces.csv");
  const std::size_t bin = table.column("bin"), low = table.column("low"),
                    high = table.column("high"), count = table.column("count");
  struct Bin {
    double low = 0, high = 0, count = 0;
  };
  std::map<int, Bin> bins;
  double total = 0;
  for (const auto& row : rows_from(table, starts)) {
    Bin& b = bins[static_cast<int>(row[bin])];
    b.low = row[low];
    b.high = row[high];
    b.count += row[count];
    total += row[count];
  }
  std::string text = "bin,low,high,count,density\n";
  for (const auto& [number, b] : bins) {
    text += fmt::format("{}", number);
    const double density = total > 0 ? b.count / total / (b.high - b.low) : kNaN;
    add_numbers(text, b.low, b.high, b.count, density);
    text += "\n";
  }
  write_text_file(folder / "forces_mean.csv", text);
}

template <int D>
void write_profile_rows(const State<D>& state, const Scene<D>& scene, CsvFile& file) {
  const std::vector<Quantity> list =
      quantities<D>(observe_profile<D>(state, scene.step, *scene.observables));
  for (std::size_t b = 0; b < list.front().values.size(); ++b) {
    std::string row = step_and_time(state.step, state.time) + fmt::format(",{}", b);
    for (const Quantity& q : list) add_number(row, q.values[b]);
    file.row(row);
  }
}

}  // namespace

std::size_t NumberTable::column(const std::string& name) const {
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (names[k] == name) return k;
  }
  throw std::out_of_range("there is no column " + name);
}

NumberTable read_number_table(const fs::path& path) {
  std::istringstream in(read_text_file(path));
  NumberTable table;
  std::string line, cell;
  std::getline(in, line);
  std::stringstream names(line);
  while (std::getline(names, cell, ',')) table.names.push_back(cell.substr(0, cell.find(" [")));
  while (std::getline(in, line)) {
    std::stringstream cells(line);
    std::vector<double> row;
    while (std::getline(cells, cell, ',')) row.push_back(number_at(cell));
    if (row.size() != table.names.size()) {
      throw FileError(path, "",
                      fmt::format("row {} has {} numbers for {} columns", table.rows.size() + 1,
                                  row.size(), table.names.size()));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

template <int D>
ObservableWriter<D>::ObservableWriter(fs::path folder, const Scene<D>& scene, int keep_up_to)
    : folder_(std::move(folder)),
      scene_(scene),
      rows_(folder_ / "observables.csv", header_of(scene), keep_up_to),
      forces_(folder_ / "forces.csv", kForcesHeader, keep_up_to) {
  if (scene.observables->profile) {
    profile_.emplace(folder_ / "profile.csv", kProfileHeader + bin_columns<D>(), keep_up_to);
  }
}

template <int D>
std::string ObservableWriter<D>::units() const {
  std::string rows = unit_rows("observables.csv", header_of(scene_));
  rows += unit_rows("forces.csv", kForcesHeader);
  if (!profile_) return rows;
  return rows + unit_rows("profile.csv", kProfileHeader + bin_columns<D>()) +
         unit_rows("profile_mean.csv", bin_columns<D>().substr(1));
}

template <int D>
void ObservableWriter<D>::step(const State<D>& state) {
  const ObservableChoice<D>& choice = *scene_.observables;
  if (state.step % choice.every != 0) return;
  std::string row = step_and_time(state.step, state.time);
  for (const Quantity& q : quantities(observe(scene_, state, choice))) add_number(row, q.values[0]);
  for (const FluxSurface<D>& crossing : choice.crossings) {
    add_number(row, mass_flux(state, crossing));
  }
  rows_.row(row);
  if (profile_) write_profile_rows<D>(state, scene_, *profile_);
  const ForceDistribution forces = observe_forces(state, scene_.step, choice);
  const double width = choice.force_limit / choice.force_bins;
  for (std::size_t b = 0; b < forces.counts.size(); ++b) {
    const double low = static_cast<double>(b) * width;
    std::string bin = step_and_time(state.step, state.time) + fmt::format(",{}", b);
    add_numbers(bin, low, low + width);
    bin += fmt::format(",{}", forces.counts[b]);
    add_number(bin, forces.mean);
    forces_.row(bin);
  }
}

template <int D>
void ObservableWriter<D>::close() const {
  const double starts = scene_.observables->starts;
  write_means<D>(folder_, starts);
  if (profile_) write_profile_means<D>(folder_, starts);
  write_force_means(folder_, starts);
}

template <int D>
std::string definition_of(const ObservableChoice<D>& choice) {
  const auto place = [](const auto& numbers) {
    return fmt::format("({})", fmt::join(numbers.data(), numbers.data() + numbers.size(), ", "));
  };
  std::string text = fmt::format("forces: {} bins to {}", choice.force_bins, choice.force_limit);
  text += choice.window ? fmt::format("; window {} {}", place(choice.window->lower),
                                      place(choice.window->upper))
                        : std::string("; no window");
  if (choice.profile) {
    const ProfileChoice& p = *choice.profile;
    text +=
        fmt::format("; profile along {}: {} bins, {} to {}", "xyz"[p.axis], p.bins, p.low, p.high);
  }
  for (const FluxSurface<D>& s : choice.crossings) {
    text += fmt::format("; flux {} ", s.name);
    if constexpr (D == 2) {
      text += place(s.a) + place(s.b);
    } else {
      text += fmt::format("{}{}{} {}{}{}", static_cast<int>(s.shape), place(s.point),
                          place(s.normal), s.radius, place(s.along), place(s.size));
    }
  }
  return text;
}

template <int D>
void write_observables(Hdf5File& file, const Scene<D>& scene, const State<D>& state) {
  const ObservableChoice<D>& choice = *scene.observables;
  for (const Quantity& q : quantities(observe(scene, state, choice))) {
    file.write("/observables/" + q.name, q.values[0], q.known_unit());
  }
  const ForceDistribution forces = observe_forces(state, scene.step, choice);
  file.write("/observables/forces/counts", forces.counts);
  file.write("/observables/forces/mean", forces.mean, "N");
  file.write("/observables/forces/limit", choice.force_limit);
  for (const FluxSurface<D>& crossing : choice.crossings) {
    file.write("/observables/flux/" + crossing.name, mass_flux(state, crossing), "kg/s");
  }
  if (!choice.profile) return;
  for (const Quantity& q : quantities<D>(observe_profile<D>(state, scene.step, choice))) {
    file.write("/observables/profile/" + q.name, q.values, q.known_unit());
  }
}

template class ObservableWriter<2>;
template class ObservableWriter<3>;
template std::string definition_of(const ObservableChoice<2>&);
template std::string definition_of(const ObservableChoice<3>&);
template void write_observables(Hdf5File&, const Scene<2>&, const State<2>&);
template void write_observables(Hdf5File&, const Scene<3>&, const State<3>&);

}  // namespace bipot
