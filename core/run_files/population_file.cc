#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "core/files/hdf5_columns.h"
#include "core/run_files/csv_file.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

template <int D>
void write_flows(Hdf5File& file, const std::string& group, bool inlets,
                 const std::vector<GateFlow<D>>& flows) {
  write_column(file, group + "/count", "", flows, &GateFlow<D>::count);
  if (inlets) write_column(file, group + "/waiting", "", flows, &GateFlow<D>::waiting);
  write_column(file, group + "/mass", "kg", flows, &GateFlow<D>::mass);
  write_column(file, group + "/energy", "J", flows, &GateFlow<D>::energy);
  write_column(file, group + "/momentum", "kg m/s", flows, &GateFlow<D>::momentum);
  write_column(file, group + "/last_mass", "kg", flows, &GateFlow<D>::last_mass);
}

template <int D>
std::vector<GateFlow<D>> read_flows(const Hdf5File& file, const std::string& group, bool inlets) {
  std::vector<GateFlow<D>> flows(file.size(group + "/count"));
  read_column(file, group + "/count", flows, &GateFlow<D>::count);
  if (inlets) read_column(file, group + "/waiting", flows, &GateFlow<D>::waiting);
  read_column(file, group + "/mass", flows, &GateFlow<D>::mass);
  read_column(file, group + "/energy", flows, &GateFlow<D>::energy);
  read_column(file, group + "/momentum", flows, &GateFlow<D>::momentum);
  read_column(file, group + "/last_mass", flows, &GateFlow<D>::last_mass);
  return flows;
}

}  // namespace

template <int D>
void write_body_constants(Hdf5File& file, const std::vector<Body<D>>& bodies, bool any_glued) {
  write_column(file, "/bodies/radius", "m", bodies, &Body<D>::radius);
  write_column(file, "/bodies/mass", "kg", bodies, &Body<D>::mass);
  write_column(file, "/bodies/inertia", "kg m2", bodies, &Body<D>::inertia);
  write_column(file, "/bodies/material", "", bodies, &Body<D>::material);
  if (any_glued) write_column(file, "/bodies/wall", "", bodies, &Body<D>::wall);
  write_point_numbers(file, "/bodies/points", bodies.size());
}

template <int D>
void read_body_constants(const Hdf5File& file, std::vector<Body<D>>& bodies) {
  const std::string at = bodies_group(file);
  bodies.assign(file.size(at + "radius"), {});
  read_column(file, at + "radius", bodies, &Body<D>::radius);
  read_column(file, at + "mass", bodies, &Body<D>::mass);
  read_column(file, at + "inertia", bodies, &Body<D>::inertia);
  read_column(file, at + "material", bodies, &Body<D>::material);
  read_optional_column(file, at + "wall", bodies, &Body<D>::wall);
}

template <int D>
void write_population(Hdf5File& frame, const State<D>& state) {
  frame.write("/bodies/number", state.population.numbers);
  write_body_constants(frame, state.bodies, true);
  write_flows<D>(frame, "/outlets", false, state.population.outlets);
  write_flows<D>(frame, "/inlets", true, state.population.inlets);
}

template <int D>
bool read_population(const Hdf5File& frame, std::vector<Body<D>>& bodies,
                     Population<D>& population) {
  const std::string number = bodies_group(frame) + "number";
  if (!frame.exists(number)) return false;
  population.numbers = frame.read_ints(number);
  const bool increases =
      std::adjacent_find(population.numbers.begin(), population.numbers.end(),
                         [](int a, int b) { return a >= b; }) == population.numbers.end();
  if (!increases || (!population.numbers.empty() && population.numbers.front() < 0)) {
    throw FileError(frame.path(), number, "not increasing from 0 on");
  }
  read_body_constants(frame, bodies);
  if (bodies.size() != population.numbers.size()) {
    throw FileError(frame.path(), number, "not one of each body");
  }
  population.outlets = read_flows<D>(frame, "/outlets", false);
  population.inlets = read_flows<D>(frame, "/inlets", true);
  return true;
}

template <int D>
void write_no_body(Hdf5File& file, const Vec<D>& x) {
  const std::vector<double> zeros(6, 0.0);
  const auto rows = [&](const char* name, std::span<const double> values) {
    file.write_rows(std::string("/no_body/") + name, values, values.size());
  };
  rows("x", std::span<const double>(x.data(), to_size(D)));
  rows("x_in_cell", std::span<const double>(x.data(), to_size(D)));
  rows("v", std::span(zeros).first(3));
  rows("stress", zeros);
  if (D == 2) {
    file.write("/no_body/spin", 0.0);
    file.write("/no_body/angle", 0.0);
  } else {
    rows("spin", std::span(zeros).first(3));
  }
  for (const char* name : {"radius", "mass", "pressure"}) {
    file.write(std::string("/no_body/") + name, 0.0);
  }
  file.write("/no_body/material", 0);
  file.write("/no_body/cluster", -1);
  file.write("/no_body/points", 0);
}

template <int D>
std::string gates_header(const Scene<D>& scene) {
  std::string line = fmt::format("step,time [s],{}s,mass [kg]", kBodyName<D>);
  const auto add = [&](const std::string& name) {
    line += fmt::format(",{0}_count,{0}_mass [kg],{0}_flux [kg/s],{0}_energy [J]", name) +
            columns_of_axes<D>(name + "_momentum_", " [kg m/s]");
  };
  for (const Outlet<D>& outlet : scene.outlets) add(outlet.name);
  for (const Inlet<D>& inlet : scene.inlets) {
    add(inlet.name);
    line += fmt::format(",{}_waiting", inlet.name);
  }
  return line;
}

template <int D>
std::string gates_row(const Scene<D>& scene, const State<D>& state) {
  std::size_t count = state.clusters.bodies.size();
  double inside = 0;
  for (const Body<D>& body : state.bodies) {
    if (body.cluster < 0 && body.wall < 0) ++count;
    inside += body.mass;
  }
  for (const Cluster<D>& cluster : state.clusters.bodies) inside += cluster.mass;
  std::string line = step_and_time(state.step, state.time) + fmt::format(",{}", count);
  add_number(line, inside);
  const auto add = [&](const GateFlow<D>& flow) {
    fmt::format_to(std::back_inserter(line), ",{}", flow.count);
    add_numbers(line, flow.mass, flow.last_mass / scene.step, flow.energy, flow.momentum);
  };
  for (const GateFlow<D>& flow : state.population.outlets) add(flow);
  for (const GateFlow<D>& flow : state.population.inlets) {
    add(flow);
    fmt::format_to(std::back_inserter(line), ",{}", flow.waiting);
  }
  return line;
}

template void write_body_constants(Hdf5File&, const std::vector<Disk>&, bool);
template void write_body_constants(Hdf5File&, const std::vector<Sphere>&, bool);
template void read_body_constants(const Hdf5File&, std::vector<Disk>&);
template void read_body_constants(const Hdf5File&, std::vector<Sphere>&);
template void write_population(Hdf5File&, const State<2>&);
template void write_population(Hdf5File&, const State<3>&);
template bool read_population(const Hdf5File&, std::vector<Disk>&, Population<2>&);
template bool read_population(const Hdf5File&, std::vector<Sphere>&, Population<3>&);
template void write_no_body<2>(Hdf5File&, const Vec2&);
template void write_no_body<3>(Hdf5File&, const Vec3&);
template std::string gates_header(const Scene<2>&);
template std::string gates_header(const Scene<3>&);
template std::string gates_row(const Scene<2>&, const State<2>&);
template std::string gates_row(const Scene<3>&, const State<3>&);

}  // namespace bipot
