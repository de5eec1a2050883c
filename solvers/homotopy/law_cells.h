#pragma once

#include <bit>

namespace bipot {

/// Coulomb's law of one contact in the plane as a piecewise linear manifold: each cell is a cone
/// with d free parameters, its columns, and the cells join along their faces. For d = 2:
///
///     cell        columns (parameters)              s                          u
///     take-off    opening u_n >= 0, sliding u_t     0                          (u_n, u_t)
///     slip +      plus a >= 0, sliding u_t >= 0     a (1, -mu)                 (0, u_t)
///     slip -      minus a >= 0, sliding u_t <= 0    a (1, +mu)                 (0, u_t)
///     stick       plus a >= 0, minus b >= 0         a (1, -mu) + b (1, mu)     0
///
/// Without friction sliding is free in slip +, and slip - and stick do not occur; for d = 1 there
/// is no sliding. With rolling friction (d = 3) the impulses are combinations of the four rays
/// (1, ∓mu, ∓mu_r), and sliding and rolling each have the sign of the rays present. A contact that
/// slides and rolls has one ray, one that does either has the two rays of a face of the cone. The
/// cone itself has four faces and is two cells, cut along the rays kPlus and kMinusBack.
enum class Column : unsigned char {
  kOpening,
  kSliding,
  kRolling,
  kPlus,       ///< (1, -mu, -mu_r)
  kMinus,      ///< (1, +mu, -mu_r)
  kPlusBack,   ///< (1, -mu, +mu_r)
  kMinusBack,  ///< (1, +mu, +mu_r)
};
inline constexpr int kColumns = 7;

/// A bit for each column. Columns beyond d do not count.
enum class Cell : unsigned char {
  kTakeOff = 0b0111,
  kSlipPlus = 0b1110,
  kSlipMinus = 0b10110,
  kStick = 0b11100,
};
inline bool has(Cell cell, Column column) {
  return (static_cast<unsigned>(cell) >> static_cast<unsigned>(column) & 1U) != 0;
}

/// Impulses, as opposed to velocities.
inline bool is_impulse(Column column) { return column >= Column::kPlus; }
/// Bit k: the ray is at +mu (k = 0) or +mu_r (k = 1), where the velocity is negative.
inline unsigned sides(Column ray) {
  return static_cast<unsigned>(ray) - static_cast<unsigned>(Column::kPlus);
}
inline Column ray(unsigned sides) {
  return static_cast<Column>(static_cast<unsigned>(Column::kPlus) + sides);
}
/// A bit for each ray of a cell, by its sides().
inline unsigned rays(Cell cell) {
  return static_cast<unsigned>(cell) >> static_cast<unsigned>(Column::kPlus);
}

/// +1: the parameter must be >= 0, -1: <= 0, 0: free. `friction`: of the column's row.
inline int bound_of(Cell cell, Column column, bool friction) {
  if (column == Column::kOpening || is_impulse(column)) return 1;
  if (has(cell, Column::kOpening) || !friction) return 0;
  const auto first = static_cast<unsigned>(std::countr_zero(rays(cell)));
  return (first >> (column == Column::kSliding ? 0 : 1) & 1U) != 0 ? -1 : 1;
}

/// The other side of a face: the cell, the entering column and the sign of its growth.
struct Crossing {
  Cell cell;
  Column enters;
  int growth;
};

/// The neighbour of `cell` at the face where the parameter of `leaving` is zero. `slip`: the sides
/// of the velocities, which decide where take-off ends.
inline Crossing cross(Cell cell, Column leaving, unsigned slip) {
  const unsigned rest = static_cast<unsigned>(cell) & ~(1U << static_cast<unsigned>(leaving));
  const auto enter = [&](Column column, int growth = 1) {
    return Crossing{static_cast<Cell>(rest | 1U << static_cast<unsigned>(column)), column, growth};
  };
  if (leaving == Column::kOpening) return enter(ray(slip));
  const unsigned left = rays(static_cast<Cell>(rest));
  if (left == 0) return enter(Column::kOpening);
  const auto first = static_cast<unsigned>(std::countr_zero(left));
  const auto last = static_cast<unsigned>(std::bit_width(left)) - 1;
  // From a face of the cone, whose rays agree in `side`, outwards.
  const auto slide = [&](unsigned side) {
    return enter(side == 1 ? Column::kSliding : Column::kRolling, (first & side) != 0 ? -1 : 1);
  };
  if (first == last) {
    return is_impulse(leaving) ? slide(sides(leaving) ^ first)
                               : enter(ray(first ^ (leaving == Column::kSliding ? 1U : 2U)));
  }
  if (!is_impulse(leaving)) return enter(ray(first == 0 ? 3 : 0));
  const unsigned differ = first ^ last;
  return differ == 3 ? enter(ray(sides(leaving) ^ 3)) : slide(differ ^ 3);
}

}  // namespace bipot
