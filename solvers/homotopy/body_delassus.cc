#include "solvers/homotopy/body_delassus.h"

#include <algorithm>
#include <numeric>

namespace bipot {

bool BodyDelassus::serves(const ContactProblem& p) {
  if (!p.has_velocities() || p.dim > 2 || p.A.nonZeros() != p.A.cols()) return false;
  for (int k = 0; k < p.A.cols(); ++k) {
    if (p.A.outerIndexPtr()[k] != k || p.A.innerIndexPtr()[k] != k) return false;
  }
  return true;
}

BodyDelassus::BodyDelassus(const ContactProblem& p, const Vector& scale)
    : problem_(p), scale_(scale), contacts_(p) {}

void BodyDelassus::find_neighbours(int i) const {
  neighbours_.assign(1, i);
  for (int column = i * problem_.dim; column < (i + 1) * problem_.dim; ++column) {
    for (SparseMatrix::InnerIterator it(problem_.H, column); it; ++it) {
      if (it.value() == 0) continue;
      const auto first = contacts_.contact.begin() + contacts_.start[to_size(it.row())];
      const auto end = contacts_.contact.begin() + contacts_.start[to_size(it.row()) + 1];
      neighbours_.insert(neighbours_.end(), first, end);
    }
  }
  std::sort(neighbours_.begin(), neighbours_.end());
  neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
}

/// Products are formed before the division, and the two scales together, so that (j, i) has the
/// bits of (i, j).
double BodyDelassus::entry(int row, int column) const {
  const double* const mass = problem_.A.valuePtr();
  SparseMatrix::InnerIterator a(problem_.H, row), b(problem_.H, column);
  double sum = 0;
  while (a && b) {
    if (a.row() == b.row()) {
      sum += a.value() * b.value() / mass[a.row()];
      ++a;
      ++b;
    } else if (a.row() < b.row()) {
      ++a;
    } else {
      ++b;
    }
  }
  return sum * (scale_[row] * scale_[column]);
}

const std::vector<BodyDelassus::Block>& BodyDelassus::blocks(int i) const {
  if (i == last_) return blocks_;
  last_ = i;
  find_neighbours(i);
  blocks_.clear();
  const int d = problem_.dim;
  for (const int j : neighbours_) {
    Block& block = blocks_.emplace_back(Block{j, {{0, 0}, {0, 0}}});
    for (int a = 0; a < d; ++a) {
      for (int b = 0; b < d; ++b) block.at[a][b] = entry(j * d + a, i * d + b);
    }
  }
  return blocks_;
}

BodyPattern BodyDelassus::body_pattern() const {
  std::vector<int> all(to_size(problem_.num_dofs()));
  std::iota(all.begin(), all.end(), 0);
  return {problem_, contacts_, all};
}

}  // namespace bipot
