#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "core/run_files/csv_file.h"
#include "core/run_files/frame_entries.h"
#include "core/run_files/run_layout.h"

namespace bipot {
namespace {

template <int D, class Get>
std::vector<double> of_bodies(const std::vector<Body<D>>& bodies, const Get& get) {
  std::vector<double> values;
  for (const Body<D>& body : bodies) values.push_back(get(body));
  return values;
}

template <int D>
void write_flows(Hdf5File& file, const std::string& group, bool inlets,
                 const std::vector<GateFlow<D>>& flows) {
  std::vector<int> count, waiting;
  std::vector<double> mass, energy, momentum, last;
  for (const GateFlow<D>& flow : flows) {
    count.push_back(flow.count);
    waiting.push_back(flow.waiting);
    mass.push_back(flow.mass);
    energy.push_back(flow.energy);
    momentum.insert(momentum.end(), flow.momentum.begin(), flow.momentum.end());
    last.push_back(flow.last_mass);
  }
  file.write(group + "/count", count);
  if (inlets) file.write(group + "/waiting", waiting);
  file.write(group + "/mass", mass);
  file.write_attribute(group + "/mass", "unit", "kg");
  file.write(group + "/energy", energy);
  file.write_attribute(group + "/energy", "unit", "J");
  file.write_rows(group + "/momentum", momentum, D);
  file.write_attribute(group + "/momentum", "unit", "kg m/s");
  file.write(group + "/last_mass", last);
  file.write_attribute(group + "/last_mass", "unit", "kg");
}

template <int D>
std::vector<GateFlow<D>> read_flows(const Hdf5File& file, const std::string& group, bool inlets) {
  const std::vector<int> count = file.read_ints(group + "/count");
  const std::size_t n = count.size();
  const auto waiting = inlets ? file.read_ints(group + "/waiting", n) : std::vector<int>(n, 0);
  const auto mass = file.read_doubles(group + "/mass", n);
  const auto energy = file.read_doubles(group + "/energy", n);
  const auto momentum = file.read_doubles(group + "/momentum", D * n);
  const auto last = file.read_doubles(group + "/last_mass", n);
  std::vector<GateFlow<D>> flows(n);
  for (std::size_t k = 0; k < n; ++k) {
    flows[k] = {.count = count[k],
                .mass = mass[k],
                .energy = energy[k],
                .momentum = Eigen::Map<const Vec<D>>(momentum.data() + D * k),
                .waiting = waiting[k],
                .last_mass = last[k]};
  }
  return flows;
}

void add_columns(std::string& line, std::initializer_list<double> values) {
  for (const double x : values) add_number(line, x);
}

}  // namespace

template <int D>
void write_population(Hdf5File& frame, const State<D>& state) {
  const std::vector<Body<D>>& bodies = state.bodies;
  frame.write("/bodies/number", state.population.numbers);
  const auto write = [&](const std::string& name, const char* unit, double Body<D>::*member) {
    frame.write(name, of_bodies<D>(bodies, [&](const Body<D>& b) { return b.*member; }));
    frame.write_attribute(name, "unit", unit);
  };
  write("/bodies/radius", "m", &Body<D>::radius);
  write("/bodies/mass", "kg", &Body<D>::mass);
  write("/bodies/inertia", "kg m2", &Body<D>::inertia);
  std::vector<int> material, wall, points(bodies.size());
  for (const Body<D>& b : bodies) {
    material.push_back(b.material);
    wall.push_back(b.wall);
  }
  std::iota(points.begin(), points.end(), 0);
  frame.write("/bodies/material", material);
  frame.write("/bodies/wall", wall);
  frame.write("/bodies/points", points);
  write_flows<D>(frame, "/outlets", false, state.population.outlets);
  write_flows<D>(frame, "/inlets", true, state.population.inlets);
}

template <int D>
bool read_population(const Hdf5File& frame, std::vector<Body<D>>& bodies,
                     Population<D>& population) {
  const std::string bodies_at = bodies_group(frame);
  const std::string number = bodies_at + "number";
  if (!frame.exists(number)) return false;
  population.numbers = frame.read_ints(number);
  const std::size_t n = population.numbers.size();
  const bool increases =
      std::adjacent_find(population.numbers.begin(), population.numbers.end(),
                         [](int a, int b) { return a >= b; }) == population.numbers.end();
  if (!increases || (n > 0 && population.numbers.front() < 0)) {
    throw FileError(frame.path(), number, "not increasing from 0 on");
  }
  const auto radius = frame.read_doubles(bodies_at + "radius", n);
  const auto mass = frame.read_doubles(bodies_at + "mass", n);
  const auto inertia = frame.read_doubles(bodies_at + "inertia", n);
  const auto material = frame.read_ints(bodies_at + "material", n);
  const auto wall = frame.read_ints(bodies_at + "wall", n);
  bodies.assign(n, {});
  for (std::size_t k = 0; k < n; ++k) {
    bodies[k].radius = radius[k];
    bodies[k].mass = mass[k];
    bodies[k].inertia = inertia[k];
    bodies[k].material = material[k];
    bodies[k].wall = wall[k];
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
    line += fmt::format(",{0}_count,{0}_mass [kg],{0}_flux [kg/s],{0}_energy [J]", name);
    for (const char* axis : {"x", "y", "z"}) {
      if (D == 3 || *axis != 'z') line += fmt::format(",{}_momentum_{} [kg m/s]", name, axis);
    }
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
  std::string line = fmt::format("{}", state.step);
  add_number(line, state.time);
  line += fmt::format(",{}", state.bodies.size());
  double inside = 0;
  for (const Body<D>& body : state.bodies) inside += body.mass;
  add_columns(line, {inside});
  const auto add = [&](const GateFlow<D>& flow) {
    fmt::format_to(std::back_inserter(line), ",{}", flow.count);
    add_columns(line, {flow.mass, flow.last_mass / scene.step, flow.energy});
    for (int k = 0; k < D; ++k) add_columns(line, {flow.momentum[k]});
  };
  for (const GateFlow<D>& flow : state.population.outlets) add(flow);
  for (const GateFlow<D>& flow : state.population.inlets) {
    add(flow);
    fmt::format_to(std::back_inserter(line), ",{}", flow.waiting);
  }
  return line;
}

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
