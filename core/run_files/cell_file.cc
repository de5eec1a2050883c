#include <vector>

#include "core/files/hdf5_columns.h"
#include "core/motion/periodic_state.h"
#include "core/run_files/frame_entries.h"
#include "core/scene/wall_pieces.h"

namespace bipot {

void write_cell_definition(Hdf5File& file, const PeriodicCell& cell) {
  const std::vector<CellSide> sides = {cell.width, cell.height, cell.offset};
  file.write("/cell/periodic", std::vector<int>{cell.in_x ? 1 : 0, cell.in_y ? 1 : 0});
  write_column(file, "/cell/motion", "", sides, &CellSide::motion);
  write_column(file, "/cell/stress", "Pa", sides, &CellSide::stress);
  write_column(file, "/cell/mass", "kg", sides, &CellSide::mass);
}

template <int D>
void write_cell(Hdf5File& frame, const State<D>& inside) {
  const PeriodicCell& cell = inside.cell;
  const std::vector<CellSide> sides = {cell.width, cell.height, cell.offset};
  write_column(frame, "/cell/lengths", "m", sides, &CellSide::length);
  write_column(frame, "/cell/speeds", "m/s", sides, &CellSide::speed);
  Hdf5Column lines;
  for (const auto& [a, b] : cell_outline(cell, view_box(inside.bodies, inside.walls))) {
    lines.add(a);
    lines.add(b);
  }
  write_point_numbers(frame, "/cell/points", lines.values().size() / D);
  frame.write_rows("/cell/segment", lines.values(), D);
  write_column(frame, "/bodies/x_in_cell", "m", inside.bodies, &Body<D>::x);
}

template void write_cell(Hdf5File&, const State<2>&);
template void write_cell(Hdf5File&, const State<3>&);

}  // namespace bipot
