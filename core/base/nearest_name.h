#pragma once

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

}  // namespace bipot
