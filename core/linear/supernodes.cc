#include "core/linear/supernodes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>
#include <utility>

#include "core/base/lists.h"
#include "core/linear/frontal_tree.h"

namespace bipot {
namespace {

/// Fronts of at most so many columns may store so large a part of zeros.
struct ZeroLimit {
  double columns, part;
};
constexpr double kAlwaysJoined = 4;  // columns
// Fewer zeros than in the source: this saves memory and time on packings of disks.
constexpr std::array<ZeroLimit, 3> kZeroLimits = {{{16, 0.3}, {48, 0.05}, {kInfinity, 0.02}}};

/// Columns of a front, rows of its first column, and zeros that it stores.
struct FrontSize {
  double columns = 0, rows = 0, zeros = 0;
};

/// The front of a child and its parent. Rows of the child are among those of the parent.
FrontSize joined(const FrontSize& child, const FrontSize& parent) {
  const double zeros = child.columns * (child.columns + parent.rows - child.rows);
  return {child.columns + parent.columns, child.columns + parent.rows, parent.zeros + zeros};
}

bool has_few_zeros(const FrontSize& front, const FrontSize& parent) {
  if (front.columns <= kAlwaysJoined || front.zeros == parent.zeros) return true;
  const double stored =
      front.columns * (front.columns + 1) / 2 + front.columns * (front.rows - front.columns);
  return std::any_of(kZeroLimits.begin(), kZeroLimits.end(), [&](const ZeroLimit& limit) {
    return front.columns <= limit.columns && front.zeros < limit.part * stored;
  });
}

/// f(row) for the entries above the diagonal of a column, in new numbers.
template <typename F>
void for_rows_above(const SymmetricPattern& A, const std::vector<int>& order,
                    const std::vector<int>& place, int column, F f) {
  const int old = order[to_size(column)];
  for (int k = A.start[old]; k < A.start[old + 1]; ++k) {
    const int row = place[to_size(A.row[k])];
    if (row < column) f(row);
  }
}

/// Parent of each column in the elimination tree, -1: none. Paths are shortened on the way.
std::vector<int> elimination_tree(const SymmetricPattern& A, const std::vector<int>& order,
                                  const std::vector<int>& place) {
  std::vector<int> parent(to_size(A.size), -1), ancestor(to_size(A.size), -1);
  for (int column = 0; column < A.size; ++column) {
    for_rows_above(A, order, place, column, [&](int row) {
      while (row != column) {
        const int next = ancestor[to_size(row)];
        ancestor[to_size(row)] = column;
        if (next < 0) {
          parent[to_size(row)] = column;
          return;
        }
        row = next;
      }
    });
  }
  return parent;
}

/// Fronts of columns with the same rows, of which each but the first has one child: its neighbour.
std::vector<int> fundamental_fronts(const std::vector<int>& parent,
                                    const std::vector<std::int64_t>& entries) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> children(parent.size(), 0), first;
  for (const int p : parent) {
    if (p >= 0) ++children[to_size(p)];
  }
  for (int j = 0; j < n; ++j) {
    const bool follows = j > 0 && parent[to_size(j) - 1] == j && children[to_size(j)] == 1 &&
                         entries[to_size(j) - 1] == entries[to_size(j)] + 1;
    if (!follows) first.push_back(j);
  }
  first.push_back(n);
  return first;
}

/// The front of each column.
std::vector<int> front_of_columns(const std::vector<int>& first) {
  std::vector<int> front(to_size(first.back()));
  for (std::size_t s = 0; s + 1 < first.size(); ++s) {
    std::fill(front.begin() + first[s], front.begin() + first[s + 1], static_cast<int>(s));
  }
  return front;
}

/// Joins fronts with the one behind them, from the last to the first, where it is their parent.
std::vector<int> joined_fronts(const std::vector<int>& first, const std::vector<int>& parent,
                               const std::vector<std::int64_t>& entries) {
  const int fronts = static_cast<int>(first.size()) - 1;
  const std::vector<int> front_of = front_of_columns(first);
  std::vector<FrontSize> size(to_size(fronts));
  std::vector<int> begin(to_size(fronts));  // the front that has this one's columns
  std::iota(begin.begin(), begin.end(), 0);
  for (int s = fronts - 1; s >= 0; --s) {
    FrontSize& own = size[to_size(s)];
    own.columns = first[to_size(s) + 1] - first[to_size(s)];
    own.rows = static_cast<double>(entries[to_size(first[to_size(s)])]);
    const int above = parent[to_size(first[to_size(s) + 1]) - 1];
    if (above < 0) continue;
    int holder = front_of[to_size(above)];
    while (begin[to_size(holder)] != holder) {
      holder = begin[to_size(holder)] = begin[to_size(begin[to_size(holder)])];
    }
    if (holder != s + 1) continue;
    const FrontSize& next = size[to_size(holder)];
    FrontSize both = joined(own, next);
    if (!has_few_zeros(both, next)) continue;
    if (both.columns <= kAlwaysJoined) both.zeros = next.zeros;  // those of small fronts are free
    own = both;
    begin[to_size(holder)] = s;
  }
  std::vector<int> kept;
  for (int s = 0; s < fronts; ++s) {
    if (begin[to_size(s)] == s) kept.push_back(first[to_size(s)]);
  }
  kept.push_back(first.back());
  return kept;
}

}  // namespace

Supernodes supernodes(const SymmetricPattern& A, const std::vector<int>& order,
                      const std::vector<std::int64_t>& entries) {
  std::vector<int> place(order.size());
  for (int k = 0; k < A.size; ++k) place[to_size(order[to_size(k)])] = k;
  const std::vector<int> parent = elimination_tree(A, order, place);
  std::vector<int> first = joined_fronts(fundamental_fronts(parent, entries), parent, entries);
  const std::vector<int> front_of = front_of_columns(first);

  // Row k is in the fronts on the paths from its entries up to its own front.
  std::vector<int> visited(first.size() - 1);
  Lists<> below = make_lists(static_cast<int>(visited.size()), [&](const auto& put) {
    std::fill(visited.begin(), visited.end(), -1);
    for (int row = 0; row < A.size; ++row) {
      visited[to_size(front_of[to_size(row)])] = row;
      for_rows_above(A, order, place, row, [&](int column) {
        for (int s = front_of[to_size(column)]; visited[to_size(s)] != row;
             s = front_of[to_size(parent[to_size(first[to_size(s) + 1]) - 1])]) {
          visited[to_size(s)] = row;
          put(s, row);
        }
      });
    }
  });
  return {std::move(first), std::move(below.start), std::move(below.items)};
}

}  // namespace bipot
