#include "core/linear/frontal_tree.h"

#include <cholmod.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <numeric>
#include <utility>

#include "core/linear/supernodes.h"

namespace bipot {
namespace {

constexpr std::size_t kTreesKept = 4;
constexpr std::size_t kBytesKept = std::size_t{1} << 21;  // three trees of 6000 contacts
constexpr std::size_t kBytesOfEntry = 8;                  // a tree takes 6 for one of A
constexpr int kMetisFrom = 4000;                          // groups of columns; AMD is quicker below

/// The trees of the last patterns, the latest first.
struct KeptTrees {
  std::mutex mutex;
  std::array<std::shared_ptr<const FrontalTree>, kTreesKept> tree;

  /// Drops the oldest trees if all of them and `more` bytes would take too much.
  void make_room(std::size_t more) {
    for (auto& kept : tree) {
      if (!kept) continue;
      more += kept->num_bytes();
      if (more > kBytesKept) kept = nullptr;
    }
  }
};
KeptTrees& kept_trees() {
  static KeptTrees kept;
  return kept;
}

/// CHOLMOD's workspace, for orders and counts. (Its supernodal part is under another licence.)
struct CholmodSession {
  cholmod_common common;
  CholmodSession() {
    cholmod_l_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.nmethods = 1;
    common.postorder = 1;
    common.supernodal = CHOLMOD_SIMPLICIAL;
  }
  ~CholmodSession() { cholmod_l_finish(&common); }
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;
};

/// The upper triangle of a symmetric pattern, as CHOLMOD reads it.
struct UpperPattern {
  std::vector<SuiteSparse_long> start{0};
  std::vector<SuiteSparse_long> row;

  cholmod_sparse view() {
    cholmod_sparse A{};
    A.nrow = A.ncol = start.size() - 1;
    A.nzmax = row.size();
    A.p = start.data();
    A.i = row.data();
    A.stype = 1;
    A.itype = CHOLMOD_LONG;
    A.xtype = CHOLMOD_PATTERN;
    A.dtype = CHOLMOD_DOUBLE;
    A.sorted = A.packed = 1;
    return A;
  }
};

/// Groups of consecutive columns with the same pattern: the first column of each, and the end.
std::vector<int> equal_columns(const SymmetricPattern& A) {
  const int* const start = A.start;
  const int* const row = A.row;
  std::vector<int> groups{0};
  for (int j = 1; j < A.size; ++j) {
    if (!std::equal(row + start[j - 1], row + start[j], row + start[j], row + start[j + 1])) {
      groups.push_back(j);
    }
  }
  groups.push_back(A.size);
  return groups;
}

/// A fill-reducing order of the groups, column by column, new to old.
std::vector<SuiteSparse_long> fill_reducing_columns(const SymmetricPattern& A,
                                                    const std::vector<int>& groups) {
  const int nodes = static_cast<int>(groups.size()) - 1;
  std::vector<int> group_of(to_size(A.size));
  for (int g = 0; g < nodes; ++g) {
    for (int j = groups[to_size(g)]; j < groups[to_size(g) + 1]; ++j) group_of[to_size(j)] = g;
  }
  UpperPattern graph;
  for (int g = 0; g < nodes; ++g) {
    int last = -1;
    const int j = groups[to_size(g)];
    for (int k = A.start[j]; k < A.start[j + 1]; ++k) {
      const int other = group_of[to_size(A.row[k])];
      if (other > g) break;
      if (other != last) graph.row.push_back(other);
      last = other;
    }
    graph.start.push_back(static_cast<SuiteSparse_long>(graph.row.size()));
  }
  CholmodSession session;
  session.common.method[0].ordering = nodes >= kMetisFrom ? CHOLMOD_METIS : CHOLMOD_AMD;
  cholmod_sparse view = graph.view();
  cholmod_factor* analysis = cholmod_l_analyze(&view, &session.common);
  std::vector<SuiteSparse_long> order;
  if (analysis == nullptr) throw std::bad_alloc();
  order.reserve(to_size(A.size));
  for (int k = 0; k < nodes; ++k) {
    const auto g = to_size(static_cast<const SuiteSparse_long*>(analysis->Perm)[k]);
    for (int j = groups[g]; j < groups[g + 1]; ++j) order.push_back(j);
  }
  cholmod_l_free_factor(&analysis, &session.common);
  return order;
}

}  // namespace

bool FrontalTree::is_of(const SymmetricPattern& A) const {
  if (size() != A.size) return false;
  const int* const start = A.start;
  const int* const row = A.row;
  for (std::size_t g = 0; g + 1 < pattern_.first.size(); ++g) {
    for (int j = pattern_.first[g]; j < pattern_.first[g + 1]; ++j) {
      const int *next = row + start[j], *const end = row + start[j + 1];
      for (int k = pattern_.start[g]; k < pattern_.start[g + 1]; ++k) {
        const std::size_t group = to_size(pattern_.group[to_size(k)]);
        for (int i = pattern_.first[group]; i < pattern_.first[group + 1]; ++i) {
          if (next == end || *next++ != i) return false;
        }
      }
      if (next != end) return false;
    }
  }
  return true;
}

std::size_t FrontalTree::num_bytes() const {
  const auto bytes = [](const auto&... list) {
    return (... + (list.capacity() * sizeof(list[0])));
  };
  return bytes(order, first, below_start, below, children, node_start, pattern_.first,
               pattern_.start, pattern_.group);
}

std::shared_ptr<const FrontalTree> FrontalTree::of(const SymmetricPattern& A) {
  KeptTrees& kept = kept_trees();
  const auto find = [&] {
    const auto found = std::find_if(kept.tree.begin(), kept.tree.end(),
                                    [&](const auto& tree) { return tree && tree->is_of(A); });
    if (found == kept.tree.end()) return std::shared_ptr<const FrontalTree>();
    std::rotate(kept.tree.begin(), found, found + 1);
    return kept.tree.front();
  };
  {
    const std::lock_guard<std::mutex> lock(kept.mutex);
    if (auto tree = find()) return tree;
    // Before the analysis, which needs memory of its own.
    kept.make_room(kBytesOfEntry * to_size(A.entries()));
  }
  auto made = analyse(A);
  const std::lock_guard<std::mutex> lock(kept.mutex);
  if (!find()) {
    kept.make_room(made->num_bytes());
    std::rotate(kept.tree.begin(), kept.tree.end() - 1, kept.tree.end());
    kept.tree.front() = made;
  }
  return made;
}

void FrontalTree::forget() {
  KeptTrees& kept = kept_trees();
  const std::lock_guard<std::mutex> lock(kept.mutex);
  kept.tree.fill(nullptr);
}

std::shared_ptr<const FrontalTree> FrontalTree::analyse(const SymmetricPattern& A) {
  auto tree = std::make_shared<FrontalTree>();
  Pattern& pattern = tree->pattern_;
  pattern.first = equal_columns(A);
  pattern.start.assign(1, 0);
  for (std::size_t g = 0; g + 1 < pattern.first.size(); ++g) {
    const int* const start = A.start + pattern.first[g];
    for (int k = start[0], group = -1; k < start[1]; ++k) {
      if (group >= 0 && A.row[k] < pattern.first[to_size(group) + 1]) continue;
      const auto after = std::upper_bound(pattern.first.begin(), pattern.first.end(), A.row[k]);
      group = static_cast<int>(after - pattern.first.begin()) - 1;
      pattern.group.push_back(group);
    }
    pattern.start.push_back(static_cast<int>(pattern.group.size()));
  }
  pattern.group.shrink_to_fit();
  std::vector<SuiteSparse_long> order = fill_reducing_columns(A, pattern.first);
  UpperPattern upper;
  upper.row.reserve(to_size(A.entries() + A.size) / 2);
  for (int j = 0; j < A.size; ++j) {
    for (int k = A.start[j]; k < A.start[j + 1] && A.row[k] <= j; ++k) {
      upper.row.push_back(A.row[k]);
    }
    upper.start.push_back(static_cast<SuiteSparse_long>(upper.row.size()));
  }
  CholmodSession session;
  session.common.method[0].ordering = CHOLMOD_GIVEN;
  cholmod_sparse view = upper.view();
  cholmod_factor* L = cholmod_l_analyze_p(&view, order.data(), nullptr, 0, &session.common);
  if (L == nullptr) throw std::bad_alloc();
  const auto* perm = static_cast<const SuiteSparse_long*>(L->Perm);
  const auto* counts = static_cast<const SuiteSparse_long*>(L->ColCount);
  tree->order.assign(perm, perm + A.size);
  Supernodes fronts = supernodes(A, tree->order, {counts, counts + A.size});
  cholmod_l_free_factor(&L, &session.common);
  tree->first = std::move(fronts.first);
  tree->below_start = std::move(fronts.below_start);
  tree->below = std::move(fronts.below);
  tree->measure();
  return tree;
}

void FrontalTree::place_rows(int front, int* position) const {
  const int begin = first[to_size(front)], own = columns(front);
  for (int k = 0; k < own; ++k) position[begin + k] = k;
  const int* const list = below.data() + below_start[to_size(front)];
  for (int k = 0; k < height(front); ++k) position[list[k]] = own + k;
}

void FrontalTree::place_child(int child, int parent, int* to) const {
  const int begin = first[to_size(parent)], end = first[to_size(parent) + 1];
  const int* const rows = below.data() + below_start[to_size(child)];
  const int* const list = below.data() + below_start[to_size(parent)];
  int at = 0;
  for (int k = 0; k < height(child); ++k) {
    if (rows[k] < end) {
      to[k] = rows[k] - begin;
    } else {
      while (list[at] != rows[k]) ++at;
      to[k] = end - begin + at;
    }
  }
}

/// Sets parents and sizes of the factor and of the stack.
void FrontalTree::measure() {
  const int fronts = num_fronts();
  std::vector<int> front_of(to_size(size()));
  for (int s = 0; s < fronts; ++s) {
    for (int j = first[to_size(s)]; j < first[to_size(s) + 1]; ++j) front_of[to_size(j)] = s;
  }
  children.assign(to_size(fronts), 0);
  node_start.assign(1, 0);
  std::vector<std::size_t> blocks;  // numbers in the contributions on the stack
  std::size_t held = 0;
  for (int s = 0; s < fronts; ++s) {
    const std::size_t front = to_size(s);
    const int columns = first[front + 1] - first[front];
    const int* own = below.data() + below_start[front];
    const int height = below_start[front + 1] - below_start[front];
    node_start.push_back(node_start.back() +
                         static_cast<std::int64_t>(columns) * (columns + 2 * height));
    const std::size_t block = to_size(height) * to_size(height);
    stack_size = std::max(stack_size, held + block);
    for (int k = 0; k < children[front]; ++k) {
      held -= blocks.back();
      blocks.pop_back();
    }
    held += block;
    blocks.push_back(block);
    if (height == 0) continue;
    ++children[to_size(front_of[to_size(own[0])])];
  }
  factor_size = to_size(node_start.back());
}

}  // namespace bipot
