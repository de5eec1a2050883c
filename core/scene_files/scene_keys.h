#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace bipot {

/// Keys that a table of a scene file may have, whatever else it says. `table` is its path without
/// numbers: "", "disks", "observables.lines". Empty: the table takes any key.
std::vector<std::string> keys_of_table(std::string_view table);

/// True if users may mean `key` when they type `typed`.
bool is_synonym(std::string_view typed, std::string_view key);

/// What is wrong with a key that its table does not take, as: "unknown key 'friction'; did you mean
/// 'mu'? Valid: mu, e_n". In this order it names a synonym, the table that takes such a key, and the
/// nearest of `valid`. Words for what is not modelled get a sentence.
std::string unknown_key_message(std::string_view typed, const std::vector<std::string>& valid);

}  // namespace bipot
