#pragma once

#include <vector>

#include "core/base/types.h"

namespace bipot {

/// A matrix B that differs from a factored one, B0, in the columns of some slots J:
///
///     z = B0⁻¹ g,   Z = B0⁻¹ [the new columns in J],   w = (Z_J)⁻¹ z_J,
///     x = B⁻¹ g:    x_J = w,   x = z - Z w elsewhere,
///
/// the Schur complement update of a simplex basis (Bisschop and Meeraus 1977). Columns of Z are
/// kept when they leave: a column that returns costs no solve with B0. If a slot's own column
/// returns, the slot leaves J. This keeps J smaller than a product form.
class ExchangedColumns {
 public:
  /// Nothing exchanged, nothing kept. `keys`: columns have keys 0 to keys - 1.
  void clear(int rows, int keys);

  int exchanged() const { return static_cast<int>(slots_.size()); }
  /// True if B should be factored again before another exchange.
  bool full() const;

  /// Number of the column `key` among those kept, -1 if it is not.
  int find(int key) const { return number_[to_size(key)]; }
  /// Keeps z = B0⁻¹ of the column `key`, which is not kept yet, and returns its number. z may
  /// receive the memory of a former one.
  int keep(int key, Vector& z);
  /// max |z| of a column kept.
  double size(int number) const { return size_[to_size(number)]; }

  /// Entry `slot` of B⁻¹ times a column kept.
  double entry(int number, int slot) const;
  /// Entry `slot` of B⁻¹ times the original column of B0 in `slot`, which is in J.
  double own_entry(int slot) const;
  /// Puts a kept column into `slot`, or its own column of B0 (number -1). False: singular.
  [[nodiscard]] bool exchange(int slot, int number);
  /// z = B0⁻¹ g becomes B⁻¹ g. No allocation.
  void apply(Vector& z) const;

 private:
  /// Entry of a column kept.
  double at(int number, int slot) const { return kept_[to_size(number)][slot]; }
  bool factor();
  bool border();
  void solve_small(double* w) const;

  int rows_ = 0;
  int most_kept_ = 0;
  std::vector<Vector> kept_;  // by number, and room for later ones; or:
  std::vector<int> number_;   // of each key
  std::vector<int> keys_;     // of each number
  std::vector<double> size_;
  std::vector<int> slots_, at_;     // J and the number of the column in each of its slots
  std::vector<int> position_;       // of each slot in J, -1
  std::vector<double> small_, lu_;  // Z_J by columns of kMostExchanged rows, and its factor
  std::vector<int> swap_;           // rows exchanged by the pivoting
  mutable std::vector<double> w_;   // scratch
  mutable std::vector<const double*> used_;
};

}  // namespace bipot
