#include <numeric>
#include <vector>

#include "core/motion/periodic_state.h"
#include "core/run_files/frame_entries.h"
#include "core/scene/wall_pieces.h"

namespace bipot {

void write_cell_definition(Hdf5File& file, const PeriodicCell& cell) {
  std::vector<int> motion;
  std::vector<double> stress, mass;
  for (int k = 0; k < 3; ++k) {
    motion.push_back(static_cast<int>(cell.side(k).motion));
    stress.push_back(cell.side(k).stress);
    mass.push_back(cell.side(k).mass);
  }
  file.write("/cell/periodic", std::vector<int>{cell.in_x ? 1 : 0, cell.in_y ? 1 : 0});
  file.write("/cell/motion", motion);
  file.write("/cell/stress", stress);
  file.write_attribute("/cell/stress", "unit", "Pa");
  file.write("/cell/mass", mass);
  file.write_attribute("/cell/mass", "unit", "kg");
}

template <int D>
void write_cell(Hdf5File& frame, const State<D>& inside) {
  const PeriodicCell& cell = inside.cell;
  std::vector<double> lengths, speeds;
  for (int k = 0; k < 3; ++k) {
    lengths.push_back(cell.side(k).length);
    speeds.push_back(cell.side(k).speed);
  }
  frame.write("/cell/lengths", lengths);
  frame.write_attribute("/cell/lengths", "unit", "m");
  frame.write("/cell/speeds", speeds);
  frame.write_attribute("/cell/speeds", "unit", "m/s");
  std::vector<double> lines;
  for (const auto& [a, b] : cell_outline(cell, view_box(inside.bodies, inside.walls))) {
    lines.insert(lines.end(), a.begin(), a.end());
    lines.insert(lines.end(), b.begin(), b.end());
  }
  std::vector<int> points(lines.size() / D);
  std::iota(points.begin(), points.end(), 0);
  frame.write("/cell/points", points);
  frame.write_rows("/cell/segment", lines, D);
  std::vector<double> places;
  for (const Body<D>& d : inside.bodies) places.insert(places.end(), d.x.begin(), d.x.end());
  frame.write_rows("/bodies/x_in_cell", places, D);
  frame.write_attribute("/bodies/x_in_cell", "unit", "m");
}

template void write_cell(Hdf5File&, const State<2>&);
template void write_cell(Hdf5File&, const State<3>&);

}  // namespace bipot
