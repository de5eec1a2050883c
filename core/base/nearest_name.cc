#include "core/base/nearest_name.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>

namespace bipot {
namespace {

/// Number of insertions, deletions, substitutions and swaps of neighbours (optimal string
/// alignment).
int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> before(b.size() + 1), row(b.size() + 1), next(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    next[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      next[j] = std::min({row[j] + 1, next[j - 1] + 1, row[j - 1] + (a[i - 1] != b[j - 1])});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) next[j] = std::min(next[j], before[j - 2] + 1);
    }
    std::swap(before, row);
    std::swap(row, next);
  }
  return row.back();
}

}  // namespace

std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates) {
  const auto best = std::min_element(candidates.begin(), candidates.end(),
                                     [&](const std::string& a, const std::string& b) {
                                       return edit_distance(name, a) < edit_distance(name, b);
                                     });
  if (best == candidates.end()) return {};
  const int longest = static_cast<int>(std::max(name.size(), best->size()));
  return edit_distance(name, *best) <= std::max(longest / 3, 1) ? *best : std::string{};
}

std::string unknown_name_message(std::string_view kind, std::string_view name,
                                 const std::vector<std::string>& candidates) {
  if (candidates.empty()) return fmt::format("unknown {} '{}'; none is allowed here", kind, name);
  const std::string nearest = nearest_name(name, candidates);
  return fmt::format("unknown {} '{}'{} Valid: {}", kind, name,
                     nearest.empty() ? "." : fmt::format("; did you mean '{}'?", nearest),
                     fmt::join(candidates, ", "));
}

void require_name(std::string_view kind, std::string_view name,
                  const std::vector<std::string>& candidates) {
  if (std::find(candidates.begin(), candidates.end(), name) == candidates.end()) {
    throw std::invalid_argument(unknown_name_message(kind, name, candidates));
  }
}

}  // namespace bipot
