#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/criterion/contact_error.h"

namespace bipot {

/// Members keep their order of insertion. A number that is not finite is written as null.
using Json = nlohmann::ordered_json;

/// The members of an array: show(x) for each x. (As a parameter Json may be declared alone here.)
template <class Range, class Show, class Member = Json>
std::vector<Member> json_list(const Range& range, const Show& show) {
  std::vector<Member> list;
  for (const auto& x : range) list.push_back(show(x));
  return list;
}

/// Adds epsilon, eta, epsilon_raw, natural_map and worst_contact (of the larger one of epsilon and
/// eta; null without one).
void add_error(Json& json, const ContactError& error);

/// The text on one line, or indented. Bytes that are not UTF-8 are replaced.
std::string json_text(const Json& json, int indent = -1);

/// The number, NaN for null.
double number_or_nan(const Json& json);

/// Refuses a destination that cannot be written, before the work. An existing file is not changed,
/// a new one is removed again. No effect for "" and "-". Throws FileError.
void require_writable(const std::string& destination);

/// A file and the option that names it.
struct NamedFile {
  std::string option, path;
};
/// Throws std::invalid_argument if a file is written over one that is read, or over another that is
/// written. Empty paths and "-" are none.
void require_apart(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read);

/// Writes to the file, or to standard output for "-". Throws FileError.
void write_json(const Json& json, const std::string& destination);

}  // namespace bipot
