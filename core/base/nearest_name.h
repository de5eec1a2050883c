#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace bipot {

/// The candidate nearest to `name` by edit distance (swaps of neighbours count once). Empty if none
/// is near: more than a third of the longer word, and more than one letter, would have to change.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates);

/// Message as: "unknown solver 'pgz'; did you mean 'pgs'? Valid: pgs, uzawa". Without a near
/// candidate it proposes none.
std::string unknown_name_message(std::string_view kind, std::string_view name,
                                 const std::vector<std::string>& candidates);

/// Throws std::invalid_argument with that message unless `name` is one of the candidates.
void require_name(std::string_view kind, std::string_view name,
                  const std::vector<std::string>& candidates);

/// The names of a table's entries.
template <class Table>
std::vector<std::string> names_of(const Table& table) {
  std::vector<std::string> names;
  for (const auto& entry : table) names.emplace_back(entry.name);
  return names;
}

/// The first entry of that name. Throws as require_name.
template <class Table>
auto& find_named(std::string_view kind, std::string_view name, Table& table) {
  for (auto& entry : table) {
    if (entry.name == name) return entry;
  }
  throw std::invalid_argument(unknown_name_message(kind, name, names_of(table)));
}

}  // namespace bipot
