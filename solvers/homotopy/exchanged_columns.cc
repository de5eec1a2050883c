#include "solvers/homotopy/exchanged_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/instruction_sets.h"

namespace bipot {
namespace {

// Largest number of differing columns: beyond it products cost more than a factorisation.
constexpr int kMostExchanged = 64;
// Columns kept before B is factored again, except those of one more solve for several.
constexpr int kMostKept = 128;
// Large ones: as many as fit into so many bytes, but so many at least.
constexpr int kBytesKept = 16 << 20, kLeastKept = 48;
constexpr std::size_t kStride = kMostExchanged;
// Limit for a row added to a factor without exchanges: beyond it the factor is recomputed.
constexpr double kLargestAdded = 100;

/// x -= weight[0] column[0] + weight[1] column[1] + ..., for `count` columns of n entries. Each
/// entry subtracts one after the other. Hence vectors of two, four or eight lanes give the same
/// bits, and the widest of the machine are used. 16 flops for each load and store of x.
BIPOT_CLONES("avx512f", "avx2", "default")
void subtract_columns(double* __restrict x, const double* const* column, const double* weight,
                      int count, int n) {
  int k = 0;
  for (; k + 8 <= count; k += 8, column += 8, weight += 8) {
    const double* const __restrict a = column[0], * const __restrict b = column[1], * const __restrict c = column[2], * const __restrict d = column[3], * const __restrict e = column[4], * const __restrict f = column[5], * const __restrict g = column[6], * const __restrict h = column[7];
    const double wa = weight[0], wb = weight[1], wc = weight[2], wd = weight[3], we = weight[4],
                 wf = weight[5], wg = weight[6], wh = weight[7];
    for (int i = 0; i < n; ++i) {
      double sum = x[i];
      sum -= wa * a[i];
      sum -= wb * b[i];
      sum -= wc * c[i];
      sum -= wd * d[i];
      sum -= we * e[i];
      sum -= wf * f[i];
      sum -= wg * g[i];
      sum -= wh * h[i];
      x[i] = sum;
    }
  }
  for (; k + 2 <= count; k += 2, column += 2, weight += 2) {
    const double* const __restrict a = column[0], * const __restrict b = column[1];
    const double wa = weight[0], wb = weight[1];
    for (int i = 0; i < n; ++i) {
      double sum = x[i];
      sum -= wa * a[i];
      sum -= wb * b[i];
      x[i] = sum;
    }
  }
  for (; k < count; ++k, ++column, ++weight) {
    const double* const __restrict a = column[0];
    const double wa = weight[0];
    for (int i = 0; i < n; ++i) x[i] -= wa * a[i];
  }
}

}  // namespace

void ExchangedColumns::clear(int rows, int keys) {
  if (rows_ != rows || to_size(keys) != number_.size()) {
    rows_ = rows;
    const int fit = kBytesKept / (std::max(rows, 1) * static_cast<int>(sizeof(double)));
    most_kept_ = std::clamp(fit, kLeastKept, kMostKept);
    number_.assign(to_size(keys), -1);
    position_.assign(to_size(rows), -1);
    kept_.clear();
    small_.resize(kStride * kStride);
    lu_.resize(kStride * kStride);
    w_.resize(kStride);
    used_.resize(kStride);
    swap_.resize(kStride);
  }
  for (const int key : keys_) number_[to_size(key)] = -1;
  for (const int slot : slots_) position_[to_size(slot)] = -1;
  keys_.clear();
  size_.clear();
  slots_.clear();
  at_.clear();
}

bool ExchangedColumns::full() const {
  return exchanged() >= kMostExchanged || static_cast<int>(keys_.size()) >= most_kept_;
}

int ExchangedColumns::keep(int key, Vector& z) {
  const auto number = static_cast<int>(keys_.size());
  size_.push_back(z.lpNorm<Eigen::Infinity>());
  if (kept_.size() <= keys_.size()) kept_.emplace_back();
  kept_[keys_.size()].swap(z);
  keys_.push_back(key);
  number_[to_size(key)] = number;
  return number;
}

double ExchangedColumns::entry(int number, int slot) const {
  const std::size_t count = slots_.size();
  for (std::size_t i = 0; i < count; ++i) w_[i] = at(number, slots_[i]);
  solve_small(w_.data());
  if (const int here = position_[to_size(slot)]; here >= 0) return w_[to_size(here)];
  double value = at(number, slot);
  for (std::size_t j = 0; j < count; ++j) value -= w_[j] * at(at_[j], slot);
  return value;
}

double ExchangedColumns::own_entry(int slot) const {
  const std::size_t here = to_size(position_[to_size(slot)]);
  std::fill_n(w_.begin(), slots_.size(), 0.0);
  w_[here] = 1;  // B0⁻¹ of that column is e_slot
  solve_small(w_.data());
  return w_[here];
}

bool ExchangedColumns::exchange(int slot, int number) {
  int& position = position_[to_size(slot)];
  if (number < 0) {
    if (position < 0) return true;
    // The last one of J takes its place.
    const std::size_t last = slots_.size() - 1, here = to_size(position);
    if (here != last) {
      slots_[here] = slots_[last];
      at_[here] = at_[last];
      position_[to_size(slots_[here])] = position;
      for (std::size_t i = 0; i <= last; ++i) {
        small_[here * kStride + i] = small_[last * kStride + i];
      }
      for (std::size_t j = 0; j < last; ++j)
        small_[j * kStride + here] = small_[j * kStride + last];
    }
    slots_.pop_back();
    at_.pop_back();
    position = -1;
    return factor();
  }
  const bool is_new = position < 0;
  if (is_new) {
    position = exchanged();
    slots_.push_back(slot);
    at_.push_back(number);
    for (std::size_t j = 0; j + 1 < slots_.size(); ++j) {
      small_[j * kStride + to_size(position)] = at(at_[j], slot);
    }
  } else {
    at_[to_size(position)] = number;
  }
  double* const mine = &small_[to_size(position) * kStride];
  for (std::size_t i = 0; i < slots_.size(); ++i) mine[i] = at(number, slots_[i]);
  return (is_new && border()) || factor();
}

/// Extends the factor by a last row and column without exchanges. False: the multipliers are too
/// large.
bool ExchangedColumns::border() {
  const std::size_t n = slots_.size() - 1;
  double* const column = &lu_[n * kStride];
  std::copy_n(&small_[n * kStride], n + 1, column);
  for (std::size_t k = 0; k < n; ++k) std::swap(column[k], column[swap_[k]]);
  for (std::size_t k = 0; k < n; ++k) {
    const double* const l = &lu_[k * kStride];
    for (std::size_t i = k + 1; i < n; ++i) column[i] -= l[i] * column[k];
  }
  for (std::size_t j = 0; j < n; ++j) {
    const double* const u = &lu_[j * kStride];
    double multiplier = small_[j * kStride + n];
    for (std::size_t i = 0; i < j; ++i) multiplier -= u[i] * w_[i];
    multiplier /= u[j];
    if (!(std::abs(multiplier) <= kLargestAdded)) return false;
    w_[j] = multiplier;
    column[n] -= multiplier * column[j];
  }
  for (std::size_t j = 0; j < n; ++j) lu_[j * kStride + n] = w_[j];
  swap_[n] = static_cast<int>(n);
  return std::abs(column[n]) > 0;
}

/// Z_J = P L U by columns, with row exchanges for the largest pivot.
bool ExchangedColumns::factor() {
  const std::size_t n = slots_.size();
  for (std::size_t j = 0; j < n; ++j) {
    std::copy_n(&small_[j * kStride], n, &lu_[j * kStride]);
  }
  for (std::size_t k = 0; k < n; ++k) {
    double* const pivots = &lu_[k * kStride];
    std::size_t row = k;
    for (std::size_t i = k + 1; i < n; ++i) {
      if (std::abs(pivots[i]) > std::abs(pivots[row])) row = i;
    }
    swap_[k] = static_cast<int>(row);
    if (!(std::abs(pivots[row]) > 0)) return false;
    if (row != k) {
      for (std::size_t j = 0; j < n; ++j) std::swap(lu_[j * kStride + k], lu_[j * kStride + row]);
    }
    const double inverse = 1 / pivots[k];
    for (std::size_t i = k + 1; i < n; ++i) pivots[i] *= inverse;
    for (std::size_t j = k + 1; j < n; ++j) {
      double* const other = &lu_[j * kStride];
      const double factor = other[k];
      if (factor == 0) continue;
      for (std::size_t i = k + 1; i < n; ++i) other[i] -= factor * pivots[i];
    }
  }
  return true;
}

void ExchangedColumns::solve_small(double* w) const {
  const std::size_t n = slots_.size();
  for (std::size_t k = 0; k < n; ++k) std::swap(w[k], w[swap_[k]]);
  for (std::size_t k = 0; k < n; ++k) {
    const double* const l = &lu_[k * kStride];
    for (std::size_t i = k + 1; i < n; ++i) w[i] -= l[i] * w[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    const double* const u = &lu_[k * kStride];
    w[k] /= u[k];
    for (std::size_t i = 0; i < k; ++i) w[i] -= u[i] * w[k];
  }
}

void ExchangedColumns::apply(Vector& z) const {
  const std::size_t count = slots_.size();
  for (std::size_t i = 0; i < count; ++i) {
    w_[i] = z[slots_[i]];
    used_[i] = kept_[to_size(at_[i])].data();
  }
  solve_small(w_.data());
  subtract_columns(z.data(), used_.data(), w_.data(), static_cast<int>(count), rows_);
  for (std::size_t i = 0; i < count; ++i) z[slots_[i]] = w_[i];
}

}  // namespace bipot
