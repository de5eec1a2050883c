#include "core/linear/frontal_cholesky.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/linear/dense_turn.h"
#include "core/linear/front_stack.h"

extern "C" {
void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);
void strsm_(const char* side, const char* uplo, const char* transa, const char* diag, const int* m,
            const int* n, const float* alpha, const float* a, const int* lda, float* b,
            const int* ldb);
void ssyrk_(const char* uplo, const char* trans, const int* n, const int* k, const float* alpha,
            const float* a, const int* lda, const float* beta, float* c, const int* ldc);
void sgemm_(const char* transa, const char* transb, const int* m, const int* n, const int* k,
            const float* alpha, const float* a, const int* lda, const float* b, const int* ldb,
            const float* beta, float* c, const int* ldc);
}

namespace bipot {
namespace {

// Of the diagonal of A: a pivot of four units in its last place has no digit.
constexpr float kSmallestPivot = 4 * std::numeric_limits<float>::epsilon();
constexpr int kColumnsAtOnce = 512;  // columns that are eliminated at once

/// Column j of a child's contribution: a lower triangle, packed by columns. Entry (i, j) is
/// packed_column(child, j)[i], i >= j.
const float* packed_column(const FrontStack<float>::Child& child, int j) {
  const std::ptrdiff_t k = j;
  return child.block + k * child.rows - k * (k + 1) / 2;
}

std::size_t packed_size(int n) { return to_size(n) * to_size(n + 1) / 2; }

/// Packs the lower triangle of a full block; the two may overlap if `to` is not behind.
void pack(const float* full, int n, float* to) {
  for (int j = 0; j < n; ++j, full += n) {
    std::memmove(to, full + j, sizeof(float) * to_size(n - j));
    to += n - j;
  }
}

/// Largest number of entries in all contributions of a tree's fronts at one time, the current one
/// in full.
std::size_t packed_stack(const FrontalTree& t) {
  std::vector<std::size_t> held;
  std::size_t top = 0, most = 0;
  for (int s = 0; s < t.num_fronts(); ++s) {
    most = std::max(most, top + to_size(t.height(s)) * to_size(t.height(s)));
    for (int k = 0; k < t.children[to_size(s)]; ++k) {
      top -= held.back();
      held.pop_back();
    }
    held.push_back(packed_size(t.height(s)));
    top += held.back();
  }
  return most;
}

void add_to_pivots(const FrontStack<float>::Child& child, int rows, float* panel) {
  for (int j = 0; j < child.pivots; ++j) {
    const float* from = packed_column(child, j);
    float* to = panel + static_cast<std::ptrdiff_t>(child.place[j]) * rows;
    for (int i = j; i < child.rows; ++i) to[child.place[i]] += from[i];
  }
}

/// Adds to the parent's own contribution, h x h, whose rows are those after its `columns` pivots.
void add_to_rest(const FrontStack<float>::Child& child, int columns, int h, float* own) {
  for (int j = child.pivots; j < child.rows; ++j) {
    const float* from = packed_column(child, j);
    float* to = own + static_cast<std::ptrdiff_t>(child.place[j] - columns) * h - columns;
    for (int i = j; i < child.rows; ++i) to[child.place[i]] += from[i];
  }
}

/// The lower part of C = beta C - A Aᵀ, `columns` of `rows`. A: k columns of `lda` numbers.
void subtract_square(int rows, int columns, int k, const float* A, int lda, float beta, float* C,
                     int ldc, FactorStop& stop) {
  const float minus = -1;
  const int most = FactorStop::columns_at_once(2.0 * rows * k, columns);
  for (int j = 0; j < columns; j += most) {
    const int n = std::min(most, columns - j), m = rows - j - n;
    float* const diagonal = C + static_cast<std::ptrdiff_t>(j) * (ldc + 1);
    {
      const DenseTurn turn;
      ssyrk_("L", "N", &n, &k, &minus, A + j, &lda, &beta, diagonal, &ldc);
      if (m > 0) {
        sgemm_("N", "T", &m, &n, &k, &minus, A + j + n, &lda, A + j, &lda, &beta, diagonal + n,
               &ldc);
      }
    }
    stop.count(2.0 * m * n * k + 1.0 * n * n * k);
  }
}

/// [T; R] of the pivots' columns, T lower triangular. `diagonal`: theirs in A. False: not positive
/// definite.
bool eliminate_columns(int columns, int rows, const float* diagonal, float* panel,
                       FactorStop& stop) {
  for (int begin = 0; begin < columns; begin += kColumnsAtOnce) {
    const int n = std::min(kColumnsAtOnce, columns - begin), below = rows - begin - n;
    float* const block = panel + static_cast<std::ptrdiff_t>(begin) * (rows + 1);
    {
      int info = 0;
      const DenseTurn turn;
      spotrf_("L", &n, block, &rows, &info);
      if (info != 0) return false;
      for (int j = 0; j < n; ++j) {
        const float root = block[static_cast<std::ptrdiff_t>(j) * (rows + 1)];
        if (!(root * root > kSmallestPivot * diagonal[begin + j] && std::isfinite(root))) {
          return false;
        }
      }
      const float one = 1;
      if (below > 0) strsm_("R", "L", "T", "N", &below, &n, &one, block, &rows, block + n, &rows);
    }
    stop.count(1.0 * below * n * n);
    const int rest = columns - begin - n;
    if (rest == 0) break;
    subtract_square(below, rest, n, block + n, rows, 1,
                    block + static_cast<std::ptrdiff_t>(n) * (rows + 1), rows, stop);
  }
  return true;
}

}  // namespace

void FrontalCholesky::analyse(const SymmetricPattern& A) {
  if (tree_ && tree_->is_of(A)) return;
  factored_ = false;
  tree_ = nullptr;
  auto tree = FrontalTree::of(A);
  std::size_t largest = 0;
  entries_ = 0;
  for (int s = 0; s < tree->num_fronts(); ++s) {
    largest = std::max(largest, to_size(tree->columns(s)) * to_size(tree->rows(s)));
    entries_ += SupernodalSolve::num_entries(tree->columns(s), tree->rows(s));
  }
  panel_.resize(largest);
  stack_.resize(packed_stack(*tree));
  permuted_.resize(to_size(tree->size()));
  place_.resize(to_size(tree->size()));
  position_.resize(to_size(tree->size()));
  for (int k = 0; k < tree->size(); ++k) place_[to_size(tree->order[to_size(k)])] = k;
  tree_ = std::move(tree);
}

bool FrontalCholesky::factor(const SparseMatrix& A) {
  analyse(A);
  const auto add = [&](int column, const Column& to) {
    for (SparseMatrix::InnerIterator it(A, column); it; ++it) {
      const int row = static_cast<int>(it.row());
      if (to.takes(row)) to.add(row, it.value());
    }
  };
  return factor(add, A.diagonal());
}

bool FrontalCholesky::factor(const AddColumn& add, const Vector& diagonal) {
  factored_ = false;
  if (!tree_) throw std::logic_error("FrontalCholesky::factor without an analysis");
  scale_ = diagonal.unaryExpr([](double d) {
    return d > 0 && std::isfinite(d) ? std::ldexp(1.0, -(std::ilogb(d) >> 1)) : 1;
  });
  return factored_ = eliminate(add);
}

/// Sets a panel to the entries that the front takes, of the lower triangle; sums are in double.
void FrontalCholesky::assemble(int front, const AddColumn& add, float* panel) {
  const FrontalTree& t = *tree_;
  const int begin = t.first[to_size(front)], columns = t.columns(front), rows = t.rows(front);
  t.place_rows(front, position_.data());
  diagonal_.resize(to_size(columns));
  column_.resize(to_size(rows));
  for (int j = 0; j < columns; ++j, panel += rows) {
    const int column = t.order[to_size(begin + j)];
    std::fill(column_.begin(), column_.end(), 0.0);
    add(column,
        {place_.data(), position_.data(), begin, column_.data(), scale_.data(), scale_[column]});
    std::transform(column_.begin(), column_.end(), panel,
                   [](double sum) { return static_cast<float>(sum); });
    diagonal_[to_size(j)] = panel[j];
  }
}

/// All fronts, children before parents.
bool FrontalCholesky::eliminate(const AddColumn& add) {
  const FrontalTree& t = *tree_;
  FrontStack<float> contributions(t, stack_);
  float* const panel = panel_.data();
  supernodes_.begin(t.num_fronts(), entries_);
  for (int s = 0; s < t.num_fronts(); ++s) {
    const int columns = t.columns(s), h = t.height(s), rows = columns + h;
    assemble(s, add, panel);
    const std::vector<FrontStack<float>::Child>& children = contributions.enter(s);
    for (const FrontStack<float>::Child& child : children) add_to_pivots(child, rows, panel);
    if (!eliminate_columns(columns, rows, diagonal_.data(), panel, stop_)) return false;
    supernodes_.add(
        {t.first[to_size(s)], columns, rows, t.below.data() + t.below_start[to_size(s)], panel});
    if (h > 0) {
      float* const own = contributions.own();
      subtract_square(h, h, columns, panel + columns, rows, 0, own, h, stop_);
      for (const FrontStack<float>::Child& child : children) add_to_rest(child, columns, h, own);
      pack(own, h, contributions.bottom());
    }
    contributions.leave(s, packed_size(h));
  }
  return true;
}

void FrontalCholesky::solve(const Vector& b, Vector& x) const {
  if (!factored_) throw std::logic_error("FrontalCholesky::solve without a factor");
  const std::vector<int>& order = tree_->order;
  const std::size_t n = order.size();
  double largest = 0;
  for (int i = 0; i < b.size(); ++i) largest = std::max(largest, std::abs(b[i] * scale_[i]));
  const double unit = largest > 0 && std::isfinite(largest) ? largest : 1;
  for (std::size_t k = 0; k < n; ++k) {
    permuted_[k] = static_cast<float>(b[order[k]] * scale_[order[k]] / unit);
  }
  supernodes_.solve(permuted_.data());
  x.resize(b.size());
  for (std::size_t k = 0; k < n; ++k) {
    x[order[k]] = unit * scale_[order[k]] * static_cast<double>(permuted_[k]);
  }
}

}  // namespace bipot
