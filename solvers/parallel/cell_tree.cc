#include "solvers/parallel/cell_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/base/number_buffer.h"

namespace bipot {

CellTree::CellTree(std::span<const Vec3> points, std::span<const double> weights, int cells)
    : cells_(cells) {
  if (cells < 1) throw std::invalid_argument("a partition needs at least one cell");
  if (points.size() != weights.size()) {
    throw std::invalid_argument("a partition needs one weight a point");
  }
  double total = 0;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!points[k].allFinite() || !(weights[k] >= 0) || !std::isfinite(weights[k])) {
      throw std::invalid_argument("a partition needs finite places and weights >= 0");
    }
    total += weights[k];
  }
  const std::vector<double> even(total > 0 ? 0 : points.size(), 1.0);
  std::vector<int> chosen(points.size());
  std::iota(chosen.begin(), chosen.end(), 0);
  root_ = cut(points, total > 0 ? weights : std::span<const double>(even), chosen, 0, cells);
}

int CellTree::cut(std::span<const Vec3> points, std::span<const double> weights,
                  std::span<int> chosen, int first_cell, int cells) {
  if (cells == 1) return ~first_cell;
  const int left_cells = cells / 2;
  const int number = static_cast<int>(cuts_.size());
  cuts_.emplace_back();
  std::size_t split = 0;
  Cut made;
  if (!chosen.empty()) {
    Vec3 low = points[to_size(chosen.front())], high = low;
    for (const int k : chosen) {
      low = low.cwiseMin(points[to_size(k)]);
      high = high.cwiseMax(points[to_size(k)]);
    }
    (high - low).maxCoeff(&made.axis);
    const auto place = [&](std::size_t k) { return points[to_size(chosen[k])][made.axis]; };
    std::sort(chosen.begin(), chosen.end(), [&](int a, int b) {
      const double x = points[to_size(a)][made.axis], y = points[to_size(b)][made.axis];
      return x < y || (x == y && a < b);
    });
    double total = 0;
    for (const int k : chosen) total += weights[to_size(k)];
    const double wanted = total * left_cells / cells;
    // Among the gaps between two coordinates, the one nearest to the wanted share; all points to
    // the right if they have the same coordinate.
    double left = 0, nearest = kInfinity;
    made.at = place(0);
    for (std::size_t k = 0; k + 1 < chosen.size(); ++k) {
      left += weights[to_size(chosen[k])];
      const double middle = 0.5 * (place(k) + place(k + 1));
      const bool between = place(k) < middle && middle <= place(k + 1);
      if (!between || !(std::abs(left - wanted) < nearest)) continue;
      nearest = std::abs(left - wanted);
      made.at = middle;
      split = k + 1;
    }
  }
  made.left = cut(points, weights, chosen.subspan(0, split), first_cell, left_cells);
  made.right =
      cut(points, weights, chosen.subspan(split), first_cell + left_cells, cells - left_cells);
  cuts_[to_size(number)] = made;
  return number;
}

std::vector<double> CellTree::to_numbers() const {
  Buffer numbers;
  append(numbers, cells_, root_);
  for (const Cut& c : cuts_) append(numbers, c.axis, c.at, c.left, c.right);
  return numbers;
}

CellTree CellTree::from_numbers(std::span<const double> numbers) {
  constexpr std::size_t kHead = 2, kOfCut = 4;
  if (numbers.size() < kHead || (numbers.size() - kHead) % kOfCut != 0) {
    throw std::invalid_argument("these numbers are no tree of cells");
  }
  CellTree tree;
  tree.cells_ = static_cast<int>(numbers[0]);
  tree.root_ = static_cast<int>(numbers[1]);
  const int cuts = static_cast<int>((numbers.size() - kHead) / kOfCut);
  // A cut leads to a later one or to a cell, so that every search ends in a cell.
  const auto leads_on = [&](int from, int to) {
    return to >= 0 ? to > from && to < cuts : ~to < tree.cells_;
  };
  bool sound = tree.cells_ >= 1 && leads_on(-1, tree.root_);
  for (int k = 0; k < cuts; ++k) {
    const double* of = numbers.data() + kHead + kOfCut * to_size(k);
    const Cut c{static_cast<int>(of[0]), of[1], static_cast<int>(of[2]), static_cast<int>(of[3])};
    sound &= c.axis >= 0 && c.axis < 3 && leads_on(k, c.left) && leads_on(k, c.right);
    tree.cuts_.push_back(c);
  }
  if (!sound) throw std::invalid_argument("these numbers are no tree of cells");
  return tree;
}

int CellTree::cell_of(const Vec3& point) const {
  int at = root_;
  while (at >= 0) {
    const Cut& c = cuts_[to_size(at)];
    at = point[c.axis] < c.at ? c.left : c.right;
  }
  return ~at;
}

double imbalance(std::span<const double> weights) {
  double largest = 0, total = 0;
  for (const double w : weights) {
    largest = std::max(largest, w);
    total += w;
  }
  return total > 0 ? largest * static_cast<double>(weights.size()) / total : 1;
}

}  // namespace bipot
