#include "core/linear/frontal_lu.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "core/base/large_pages.h"
#include "core/linear/block_pattern.h"
#include "core/linear/dense_turn.h"
#include "core/linear/eight_right_sides.h"
#include "core/linear/front_stack.h"
#include "core/linear/frontal_kernels.h"

extern "C" {
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*,
            const double*, const int*, const double*, const int*, const double*, double*,
            const int*);
}

namespace bipot {
namespace {

// Least diagonal pivot relative to the largest entry: below it rows are exchanged. Loose, so that
// ties and the rounding of the scales have no effect.
constexpr double kDiagonalIsGood = 0.1;
// Largest entry for which the scales of the diagonal are kept.
constexpr double kDiagonalScales = 1e3;
// Size of a factor from which fronts are prefetched: 8 MB, more than a core's own cache.
constexpr std::size_t kFetchFrom = std::size_t{1} << 20;
constexpr int kBlock = 16;  // columns that are eliminated by vectors before a matrix product

/// C = beta C - A op(B), m x n, inner size k.
void subtract_product(bool transposed, int m, int n, int k, const double* A, int lda,
                      const double* B, int ldb, double beta, double* C, int ldc, FactorStop& stop) {
  const double alpha = -1, column = 2.0 * m * k;
  const int most = FactorStop::columns_at_once(column, n);
  for (int j = 0; j < n; j += most) {
    const int columns = std::min(most, n - j);
    const double* const right = B + j * static_cast<std::ptrdiff_t>(transposed ? 1 : ldb);
    {
      const DenseTurn turn;
      dgemm_("N", transposed ? "T" : "N", &m, &columns, &k, &alpha, A, &lda, right, &ldb, &beta,
             C + j * static_cast<std::ptrdiff_t>(ldc), &ldc);
    }
    stop.count(column * columns);
  }
}
/// A front in the factor. First the panel of `rows` x `columns`, by columns, with the inverses of
/// the pivots on its diagonal. Below it the transpose of the part right of the pivots, `rows -
/// columns` x `columns`.
struct Front {
  int columns, rows;
  double* panel;
  double* upper;

  int height() const { return rows - columns; }
  double* column(int j) const { return panel + static_cast<std::ptrdiff_t>(j) * rows; }
  double* right_of(int j) const { return upper + static_cast<std::ptrdiff_t>(j) * height(); }
};

/// Prefetches numbers: fronts are too short for the hardware to predict the next.
void fetch(const double* begin, const double* end) {
  constexpr std::ptrdiff_t kLine = 64 / sizeof(double);
  for (; begin < end; begin += kLine) __builtin_prefetch(begin, 0, 2);
}

/// Eliminates the columns begin .. end - 1 of a panel, of whose rows the first `columns` may be
/// exchanged, as exchange[] tells; the inverse of a pivot takes its place. Largest multiplier in
/// the rows below the pivots'; a negative number: no pivot.
double eliminate_columns(const Front& f, int begin, int end, int* exchange) {
  double factors[kBlock], largest = 0;
  for (int j = begin; j < end; ++j) {
    double* column = f.column(j);
    // The rows begin .. j - 1 of U.
    solve_unit_lower(j - begin, f.column(begin) + begin, f.rows, column + begin);
    std::copy_n(column + begin, j - begin, factors);
    subtract_columns(f.rows - j, j - begin, factors, f.column(begin) + j, f.rows, column + j);
    int pivot = j;
    for (int i = j + 1; i < f.columns; ++i) {
      if (std::abs(column[i]) > std::abs(column[pivot])) pivot = i;
    }
    if (std::abs(column[j]) >= kDiagonalIsGood * std::abs(column[pivot])) pivot = j;
    exchange[j] = pivot;
    if (pivot != j) {
      for (int k = 0; k < f.columns; ++k) std::swap(f.column(k)[j], f.column(k)[pivot]);
      std::swap_ranges(f.right_of(j), f.right_of(j) + f.height(), f.right_of(pivot));
    }
    const double inverse = 1 / column[j];
    if (!(std::abs(inverse) > 0) || !std::isfinite(inverse)) return -1;
    for (int i = j + 1; i < f.columns; ++i) column[i] *= inverse;
    const double size = scale_column(f.height(), inverse, column + f.columns);
    if (!(size <= largest)) largest = size;
    column[j] = inverse;
  }
  return largest;
}

/// Eliminates the columns of a front. Returns the largest multiplier in the rows below the pivots';
/// a negative number: no pivot.
double eliminate(const Front& f, int* exchange, FactorStop& stop) {
  double factors[kBlock], largest = 0;
  for (int begin = 0; begin < f.columns; begin += kBlock) {
    const int end = std::min(begin + kBlock, f.columns);
    const double size = eliminate_columns(f, begin, end, exchange);
    if (size < 0) return -1;
    if (!(size <= largest)) largest = size;
    // The same for the part right of the pivots, whose columns are rows of the front.
    for (int k = begin + 1; f.height() > 0 && k < end; ++k) {
      for (int j = begin; j < k; ++j) factors[j - begin] = f.column(j)[k];
      subtract_columns(f.height(), k - begin, factors, f.right_of(begin), f.height(),
                       f.right_of(k));
    }
    const int rest = f.columns - end;
    if (rest == 0) continue;
    for (int k = end; k < f.columns; ++k) {
      double* other = f.column(k);
      solve_unit_lower(end - begin, f.column(begin) + begin, f.rows, other + begin);
    }
    subtract_product(false, f.rows - end, rest, end - begin, f.column(begin) + end, f.rows,
                     f.column(end) + begin, f.rows, 1, f.column(end) + end, f.rows, stop);
    if (f.height() > 0) {
      subtract_product(true, f.height(), rest, end - begin, f.right_of(begin), f.height(),
                       f.column(begin) + end, f.rows, 1, f.right_of(end), f.height(), stop);
    }
  }
  return largest;
}

/// Adds the part of a child's contribution (n x n) that belongs to the pivots of the front. Returns
/// the number of the child's rows that are pivots.
void add_to_pivots(const FrontStack<double>::Child& child, const Front& f) {
  const double* block = child.block;
  const int n = child.rows;
  const int* const place = child.place;
  for (int j = 0; j < n; ++j, block += n) {
    if (j < child.pivots) {
      double* column = f.column(place[j]);
      for (int i = 0; i < n; ++i) column[place[i]] += block[i];
    } else {
      for (int i = 0; i < child.pivots; ++i) f.right_of(place[i])[place[j] - f.columns] += block[i];
    }
  }
}

/// Adds the rest to the front's own contribution.
void add_to_contribution(const FrontStack<double>::Child& child, const Front& f,
                         double* contribution) {
  const int n = child.rows;
  const int* const place = child.place;
  for (int j = child.pivots; j < n; ++j) {
    const double* from = child.block + static_cast<std::ptrdiff_t>(j) * n;
    double* to =
        contribution + static_cast<std::ptrdiff_t>(place[j] - f.columns) * f.height() - f.columns;
    for (int i = child.pivots; i < n; ++i) to[place[i]] += from[i];
  }
}

/// The power of two next to 1 / sqrt(size) by exponents; empty if size is zero or not finite.
double inverse_root(double size) {
  constexpr int kDigits = std::numeric_limits<double>::digits - 1, kBias = 1023;
  const auto bits = std::bit_cast<std::uint64_t>(size) >> kDigits;
  // Exponents of 0 and of 0x7ff, or a sign: zero, subnormal, not finite, negative.
  const bool usual = bits > 0 && bits < 0x7ff;
  if (!usual && !(size > 0 && std::isfinite(size))) return 0;
  const int exponent = usual ? static_cast<int>(bits) - kBias : std::ilogb(size);
  const int half = (exponent + 1) >> 1;  // towards minus infinity
  return std::bit_cast<double>(static_cast<std::uint64_t>(kBias - half) << kDigits);
}

}  // namespace

/// Positions of the entry (j, i) for each entry (i, j) of a matrix of symmetric pattern, and of the
/// diagonal.
struct StoredPositions {
  std::vector<int> transposed, diagonal;

  StoredPositions() = default;
  explicit StoredPositions(const SparseMatrix& A) : transposed(to_size(A.nonZeros())) {
    const int n = static_cast<int>(A.cols());
    std::vector<int> next(A.outerIndexPtr(), A.outerIndexPtr() + n);
    diagonal.reserve(to_size(n));
    for (int j = 0; j < n; ++j) {
      diagonal.push_back(value_position(A, j, j));
      for (int k = A.outerIndexPtr()[j]; k < A.outerIndexPtr()[j + 1]; ++k) {
        transposed[to_size(next[to_size(A.innerIndexPtr()[k])]++)] = k;
      }
    }
  }
};

namespace {

/// A compressed matrix of symmetric pattern, line by line.
class StoredMatrix final : public FrontalLU::MatrixByLines {
 public:
  StoredMatrix(const SparseMatrix& A, const StoredPositions& positions)
      : start_(A.outerIndexPtr()),
        row_(A.innerIndexPtr()),
        value_(A.valuePtr()),
        positions_(positions) {}

  double diagonal(int j) const override { return value_[positions_.diagonal[to_size(j)]]; }
  void add_column(int j, FrontalLU::Line& to) const override {
    for (int k = start_[j]; k < start_[j + 1]; ++k) to.add(row_[k], value_[k]);
  }
  void add_row(int i, FrontalLU::Line& to) const override {
    const int* const transposed = positions_.transposed.data();
    for (int k = start_[i]; k < start_[i + 1]; ++k) {
      if (to.takes(row_[k])) to.add(row_[k], value_[transposed[k]]);
    }
  }

 private:
  const int* start_;
  const int* row_;
  const double* value_;
  const StoredPositions& positions_;
};

}  // namespace

struct FrontalLU::Impl {
  std::shared_ptr<const FrontalTree> tree;
  std::vector<double> factor;
  std::vector<double> stack;  // contributions
  std::vector<double> scale;  // by column of A
  std::vector<int> place;     // of each column of A in the tree's order
  std::vector<int> position;  // of the same in a front, -1: eliminated
  StoredPositions positions;  // of a stored A
  std::vector<int> exchange;
  FactorStop stop;
  int sign = 0;  // 0: no factor
  double largest = 0;
  std::vector<double> x, below;
  // Rows of kRightSides numbers; made where they are needed first.
  std::vector<double, LargePageAllocator<double>> several, several_below;

  Front front(int s) {
    const FrontalTree& t = *tree;
    double* panel = factor.data() + t.node_start[to_size(s)];
    return {t.columns(s), t.rows(s), panel,
            panel + static_cast<std::ptrdiff_t>(t.columns(s)) * t.rows(s)};
  }

  bool fetches() const { return tree->factor_size >= kFetchFrom; }
  /// What the pass forward, the pass backward reads of a front, where there is one.
  void fetch_forward(int s) {
    if (!fetches() || s >= tree->num_fronts()) return;
    const Front f = front(s);
    fetch(f.panel, f.upper);
  }
  void fetch_backward(int s) {
    if (!fetches() || s < 0) return;
    const Front f = front(s);
    for (int j = 0; j < f.columns; ++j) fetch(f.column(j), f.column(j) + j + 1);
    fetch(f.upper, f.upper + static_cast<std::ptrdiff_t>(f.columns) * f.height());
  }

  void analyse(const SymmetricPattern& pattern);
  bool scale_by_diagonal(const FrontalLU::MatrixByLines& A);
  bool scale_by_largest(const FrontalLU::MatrixByLines& A);
  bool look_at_entries(const FrontalLU::MatrixByLines& A, double most, double* sizes);
  bool assemble(const FrontalLU::MatrixByLines& A, double most, int s, const Front& f);
  bool run(const FrontalLU::MatrixByLines& A, double most);
  template <int kSides>
  void substitute_forward(double* all, double* beside);
  template <int kSides>
  void substitute_backward(double* all, double* beside);
};

void FrontalLU::Impl::analyse(const SymmetricPattern& pattern) {
  sign = 0;
  if (tree && tree->is_of(pattern)) return;
  positions = {};
  tree = nullptr;
  auto made = FrontalTree::of(pattern);
  const std::size_t n = to_size(made->size());
  factor.clear();
  scale.resize(n);
  place.resize(n);
  position.resize(n);
  exchange.resize(n);
  x.resize(n);
  below.resize(n);
  for (std::size_t k = 0; k < n; ++k) place[to_size(made->order[k])] = static_cast<int>(k);
  tree = std::move(made);
}

/// True if all scaled entries are numbers up to `most`. `sizes`, if given, is raised to the largest
/// of each row and column.
bool FrontalLU::Impl::look_at_entries(const FrontalLU::MatrixByLines& A, double most,
                                      double* sizes) {
  FrontalLU::Line line;
  line.scales_ = scale.data();
  line.largest_ = sizes;
  line.most_ = most;
  for (int j = 0; j < tree->size(); ++j) {
    line.line_ = j;
    line.scale_ = scale[to_size(j)];
    A.add_column(j, line);
  }
  return line.within_;
}

/// Powers of two near 1 / sqrt of the diagonal, which change with the units of rows and columns as
/// A does. False: there are none.
bool FrontalLU::Impl::scale_by_diagonal(const FrontalLU::MatrixByLines& A) {
  for (int j = 0; j < tree->size(); ++j) {
    scale[to_size(j)] = inverse_root(std::abs(A.diagonal(j)));
    if (scale[to_size(j)] == 0) return false;
  }
  return true;
}

/// The same for the largest entry in row or column. False: a row of zeros, or an entry is not
/// finite.
bool FrontalLU::Impl::scale_by_largest(const FrontalLU::MatrixByLines& A) {
  std::fill(scale.begin(), scale.end(), 1.0);
  std::vector<double> sizes(scale.size(), 0.0);
  if (!look_at_entries(A, std::numeric_limits<double>::max(), sizes.data())) return false;
  std::transform(sizes.begin(), sizes.end(), scale.begin(), inverse_root);
  return std::find(scale.begin(), scale.end(), 0.0) == scale.end();
}

/// Adds the entries that the front takes. False: one is larger than `most`, or NaN.
bool FrontalLU::Impl::assemble(const FrontalLU::MatrixByLines& A, double most, int s,
                               const Front& f) {
  const FrontalTree& t = *tree;
  std::fill(f.panel, f.upper + static_cast<std::ptrdiff_t>(f.columns) * f.height(), 0.0);
  const int begin = t.first[to_size(s)];
  const int* const own = t.order.data() + begin;
  for (int k = 0; k < f.columns; ++k) position[to_size(own[k])] = k;
  const int* const below_rows = t.below.data() + t.below_start[to_size(s)];
  for (int k = 0; k < f.height(); ++k) {
    position[to_size(t.order[to_size(below_rows[k])])] = f.columns + k;
  }
  FrontalLU::Line line;
  line.position_ = position.data();
  line.scales_ = scale.data();
  line.most_ = most;
  for (int j = 0; j < f.columns; ++j) {
    const int column = own[j];
    line.scale_ = scale[to_size(column)];
    line.least_ = 0;
    line.value_ = f.column(j);
    A.add_column(column, line);
    if (f.height() == 0) continue;
    line.least_ = f.columns;
    line.value_ = f.right_of(j) - f.columns;
    A.add_row(column, line);
  }
  for (int k = 0; k < f.columns; ++k) position[to_size(own[k])] = -1;
  return line.within_;
}

/// Eliminates all fronts, children before parents. False: a pivot is zero or not finite, or a
/// scaled entry is larger than `most`.
bool FrontalLU::Impl::run(const FrontalLU::MatrixByLines& A, double most) {
  const FrontalTree& t = *tree;
  FrontStack<double> contributions(t, stack);
  int minus = 0;
  largest = 0;
  for (int s = 0; s < t.num_fronts(); ++s) {
    const Front f = front(s);
    if (!assemble(A, most, s, f)) return false;
    const std::vector<FrontStack<double>::Child>& children = contributions.enter(s);
    for (const FrontStack<double>::Child& child : children) add_to_pivots(child, f);
    int* own_exchange = exchange.data() + t.first[to_size(s)];
    const double multiplier = eliminate(f, own_exchange, stop);
    if (!(multiplier >= 0)) return false;
    largest = std::max(largest, multiplier);
    for (int j = 0; j < f.columns; ++j) {
      minus += (f.column(j)[j] < 0) != (own_exchange[j] != j);
    }
    const int h = f.height();
    const std::size_t size = to_size(h) * to_size(h);
    if (h > 0) {
      double* own = contributions.own();
      subtract_product(true, h, h, f.columns, f.panel + f.columns, f.rows, f.upper, h, 0.0, own, h,
                       stop);
      for (const FrontStack<double>::Child& child : children) add_to_contribution(child, f, own);
      if (!children.empty()) std::memmove(contributions.bottom(), own, sizeof(double) * size);
    }
    contributions.leave(s, size);
  }
  if (!std::isfinite(largest)) return false;
  sign = minus % 2 == 0 ? 1 : -1;
  return true;
}

FrontalLU::FrontalLU() : impl_(std::make_unique<Impl>()) {}
FrontalLU::~FrontalLU() = default;
FrontalLU::FrontalLU(FrontalLU&&) noexcept = default;
FrontalLU& FrontalLU::operator=(FrontalLU&&) noexcept = default;

void FrontalLU::stop_by(FactorStop stop) { impl_->stop = std::move(stop); }

void FrontalLU::analyse(const SymmetricPattern& pattern) { impl_->analyse(pattern); }

bool FrontalLU::factor(const MatrixByLines& A) {
  Impl& f = *impl_;
  if (!f.tree) throw std::logic_error("FrontalLU::factor without an analysis");
  f.sign = 0;
  f.factor.resize(f.tree->factor_size);
  f.stack.resize(f.tree->stack_size);
  const bool by_diagonal = f.scale_by_diagonal(A);
  if (by_diagonal && f.run(A, kDiagonalScales)) return true;
  // A pivot alone is no reason for other scales.
  if (by_diagonal && f.look_at_entries(A, kDiagonalScales, nullptr)) return false;
  return f.scale_by_largest(A) && f.run(A, kInfinity);
}

bool FrontalLU::factor(const SparseMatrix& A) {
  Impl& f = *impl_;
  f.analyse(A);
  if (f.positions.diagonal.empty()) f.positions = StoredPositions(A);
  return factor(StoredMatrix(A, f.positions));
}

/// `all`: rows of kSides numbers, one right side or kRightSides of them. `beside`: as many rows.
template <int kSides>
void FrontalLU::Impl::substitute_forward(double* all, double* beside) {
  const FrontalTree& t = *tree;
  for (int s = 0; s < t.num_fronts(); ++s) {
    const Front f = front(s);
    double* own = all + t.first[to_size(s)] * kSides;
    // A right side of few numbers stays away from most fronts.
    const int numbers = f.columns * kSides;
    if (std::all_of(own, own + numbers, [](double value) { return value == 0; })) continue;
    fetch_forward(s + 1);
    const int* swaps = exchange.data() + t.first[to_size(s)];
    for (int j = 0; j < f.columns; ++j) {
      if (swaps[j] == j) continue;
      std::swap_ranges(own + j * kSides, own + (j + 1) * kSides, own + swaps[j] * kSides);
    }
    const int h = f.height();
    if constexpr (kSides == 1) {
      solve_unit_lower(f.columns, f.panel, f.rows, own);
    } else {
      solve_unit_lower_of_eight(f.columns, f.panel, f.rows, own);
    }
    if (h == 0) continue;
    std::fill_n(beside, h * kSides, 0.0);
    if constexpr (kSides == 1) {
      subtract_columns(h, f.columns, own, f.panel + f.columns, f.rows, beside);
    } else {
      subtract_columns_of_eight(h, f.columns, f.panel + f.columns, f.rows, own, beside);
    }
    const int* rows = t.below.data() + t.below_start[to_size(s)];
    for (int i = 0; i < h; ++i) {
      for (int c = 0; c < kSides; ++c) all[rows[i] * kSides + c] += beside[i * kSides + c];
    }
  }
}

template <int kSides>
void FrontalLU::Impl::substitute_backward(double* all, double* beside) {
  const FrontalTree& t = *tree;
  for (int s = t.num_fronts() - 1; s >= 0; --s) {
    const Front f = front(s);
    fetch_backward(s - 1);
    double* own = all + t.first[to_size(s)] * kSides;
    const int h = f.height();
    const int* rows = t.below.data() + t.below_start[to_size(s)];
    for (int i = 0; i < h; ++i) std::copy_n(all + rows[i] * kSides, kSides, beside + i * kSides);
    if constexpr (kSides == 1) {
      if (h > 0) subtract_products(h, f.columns, f.upper, h, beside, own);
      solve_upper(f.columns, f.panel, f.rows, own);
    } else {
      if (h > 0) subtract_products_of_eight(h, f.columns, f.upper, h, beside, own);
      solve_upper_of_eight(f.columns, f.panel, f.rows, own);
    }
  }
}

void FrontalLU::solve(const Columns& B, Vector* solution) const {
  Impl& f = *impl_;
  const std::size_t count = B.start.size() - 1;
  if (f.sign == 0) throw std::logic_error("FrontalLU::solve without a factor");
  if (count > kRightSides) throw std::logic_error("FrontalLU::solve for too many right sides");
  const FrontalTree& t = *f.tree;
  f.several.assign(to_size(t.size()) * kRightSides, 0.0);
  f.several_below.resize(f.several.size());
  for (std::size_t c = 0; c < count; ++c) {
    for (std::size_t k = to_size(B.start[c]); k < to_size(B.start[c + 1]); ++k) {
      const std::size_t j = to_size(B.row[k]);
      f.several[to_size(f.place[j]) * kRightSides + c] = B.value[k] * f.scale[j];
    }
    solution[c].resize(t.size());
  }
  f.substitute_forward<kRightSides>(f.several.data(), f.several_below.data());
  f.substitute_backward<kRightSides>(f.several.data(), f.several_below.data());
  // Row by row of the solutions: a line of several is read once and whole.
  double* x[kRightSides];
  for (std::size_t c = 0; c < count; ++c) x[c] = solution[c].data();
  for (std::size_t j = 0; j < to_size(t.size()); ++j) {
    const double* row = f.several.data() + to_size(f.place[j]) * kRightSides;
    for (std::size_t c = 0; c < count; ++c) x[c][j] = row[c] * f.scale[j];
  }
}

void FrontalLU::solve(const Vector& b, Vector& solution) const {
  Impl& f = *impl_;
  if (f.sign == 0) throw std::logic_error("FrontalLU::solve without a factor");
  const FrontalTree& t = *f.tree;
  for (int k = 0; k < t.size(); ++k) {
    const std::size_t j = to_size(t.order[to_size(k)]);
    f.x[to_size(k)] = b[t.order[to_size(k)]] * f.scale[j];
  }
  f.substitute_forward<1>(f.x.data(), f.below.data());
  f.substitute_backward<1>(f.x.data(), f.below.data());
  solution.resize(t.size());
  for (int j = 0; j < t.size(); ++j) {
    const std::size_t k = to_size(f.place[to_size(j)]);
    solution[j] = f.x[k] * f.scale[to_size(j)];
  }
}

int FrontalLU::determinant_sign() const {
  if (impl_->sign == 0) throw std::logic_error("FrontalLU::determinant_sign without a factor");
  return impl_->sign;
}

double FrontalLU::largest_multiplier() const { return impl_->largest; }

std::size_t FrontalLU::num_entries() const { return impl_->tree ? impl_->tree->factor_size : 0; }

}  // namespace bipot
