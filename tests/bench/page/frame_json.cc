// frame_json RUN STEP: the bodies and contacts of a frame's HDF5 file as JSON, for browser_test.py.

#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>

#include "core/files/hdf5_file.h"
#include "core/run_files/run_reader.h"

namespace bipot {
namespace {

template <int D>
void print(const std::filesystem::path& run, int step, double time_step) {
  const State<D> state = read_state<D>(run, step);
  nlohmann::json frame{{"step", state.step}, {"time", state.time}};
  const int bodies = static_cast<int>(state.bodies.size());
  const std::vector<int>& numbers = state.population.numbers;
  const auto number = [&](int k) {
    return numbers.empty() || k >= bodies ? k : numbers[to_size(k)];
  };
  for (int k = 0; k < bodies; ++k) {
    const Body<D>& body = state.bodies[to_size(k)];
    frame["bodies"].push_back({{"number", number(k)},
                               {"x", std::vector<double>(body.x.begin(), body.x.end())},
                               {"radius", body.radius},
                               {"speed", body.v.norm()}});
  }
  for (const ContactOutcome<D>& c : state.contacts) {
    frame["contacts"].push_back({{"i", number(c.contact.i)},
                                 {"j", number(c.contact.j)},
                                 {"wall", c.contact.j >= bodies},
                                 {"force_n", c.s_n / time_step},
                                 {"force_t", magnitude(c.s_t) / time_step},
                                 {"n", std::vector<double>(c.contact.n.begin(), c.contact.n.end())},
                                 {"status", static_cast<int>(c.status)}});
  }
  std::cout << frame << "\n";
}

}  // namespace
}  // namespace bipot

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  try {
    const bipot::Hdf5File file(std::filesystem::path(argv[1]) / "run.h5",
                               bipot::Hdf5File::Mode::kRead);
    const double time_step = file.read_double("/time_step");
    if (file.exists("/dimensions")) {
      bipot::print<3>(argv[1], std::atoi(argv[2]), time_step);
    } else {
      bipot::print<2>(argv[1], std::atoi(argv[2]), time_step);
    }
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
  return 0;
}
