#pragma once

namespace bipot {

/// Coulomb's law of one contact, d <= 2, as a piecewise linear manifold: each cell is a cone with d
/// free parameters, and the cells join along their faces.
///
///     cell        columns (parameters)              s                          u
///     take-off    opening u_n >= 0, sliding u_t     0                          (u_n, u_t)
///     slip +      plus a >= 0, sliding u_t >= 0     a (1, -mu)                 (0, u_t)
///     slip -      minus a >= 0, sliding u_t <= 0    a (1, +mu)                 (0, u_t)
///     stick       plus a >= 0, minus b >= 0         a (1, -mu) + b (1, mu)     0
///     smooth      plus a >= 0, sliding u_t          a (1, 0)                   (0, u_t)
///
/// A contact without friction has the cells take-off and smooth alone; for d = 1 it has no sliding.
enum class Cell : unsigned char { kTakeOff, kSlipPlus, kSlipMinus, kStick, kSmooth };
enum class Column : unsigned char { kOpening, kSliding, kPlus, kMinus };

/// Impulses, as opposed to velocities.
inline bool is_impulse(Column column) {
  return column == Column::kPlus || column == Column::kMinus;
}

/// +1: the parameter must be >= 0, -1: <= 0, 0: free.
inline int bound_of(Cell cell, Column column) {
  if (column != Column::kSliding) return 1;
  return cell == Cell::kSlipPlus ? 1 : cell == Cell::kSlipMinus ? -1 : 0;
}

/// The other side of a face: the cell, the entering column and the sign of its growth.
struct Crossing {
  Cell cell;
  Column enters;
  int growth;
};

/// The neighbour of `cell` at the face where the parameter of `leaving` is zero. `slip` is u_t,
/// which decides where take-off ends.
inline Crossing cross(Cell cell, Column leaving, double slip, bool friction) {
  switch (cell) {
    case Cell::kTakeOff:
      if (!friction) return {Cell::kSmooth, Column::kPlus, 1};
      return slip >= 0 ? Crossing{Cell::kSlipPlus, Column::kPlus, 1}
                       : Crossing{Cell::kSlipMinus, Column::kMinus, 1};
    case Cell::kSlipPlus:
      if (leaving == Column::kPlus) return {Cell::kTakeOff, Column::kOpening, 1};
      return {Cell::kStick, Column::kMinus, 1};
    case Cell::kSlipMinus:
      if (leaving == Column::kMinus) return {Cell::kTakeOff, Column::kOpening, 1};
      return {Cell::kStick, Column::kPlus, 1};
    case Cell::kStick:
      if (leaving == Column::kMinus) return {Cell::kSlipPlus, Column::kSliding, 1};
      return {Cell::kSlipMinus, Column::kSliding, -1};
    case Cell::kSmooth:
      break;
  }
  return {Cell::kTakeOff, Column::kOpening, 1};
}

}  // namespace bipot
