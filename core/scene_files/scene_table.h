#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/nearest_name.h"
#include "core/base/printable_text.h"
#include "core/base/types.h"
#include "core/scene_files/scene_file.h"
#include "core/scene_files/scene_keys.h"

namespace bipot {

/// A TOML table that knows its name and which keys were read: the others have no use.
class SceneTable {
 public:
  /// `path`: the name without numbers, which decides the valid keys. Refuses all others at once, so
  /// that a misspelt key is told before one that is missing.
  SceneTable(const toml::table& table, std::string name, std::string path,
             const std::string& source)
      : table_(table),
        name_(std::move(name)),
        path_(std::move(path)),
        source_(source),
        reading_(std::make_shared<Reading>()) {
    reading_->valid = keys_of_table(path_);
    if (reading_->valid.empty()) return;
    for (const auto& [key, node] : table_) {
      if (!is_valid(key.str())) fail_at(node, unknown_key_message(key.str(), reading_->valid));
    }
  }

  /// Refuses keys that were not read, also of the tables in it. Call after the last access.
  void finish() const {
    const auto& known = reading_->known;
    for (const auto& [key, node] : table_) {
      const std::string text(key.str());
      if (known.contains(text)) continue;
      fail_at(node, unknown_key_message(text, {known.begin(), known.end()}));
    }
    for (const SceneTable& part : reading_->parts) part.finish();
  }

  [[noreturn]] void fail(std::string_view key, const std::string& message) const {
    const toml::node* node = table_.get(key);
    const std::string text = fmt::format("'{}': {}", key, message);
    if (node != nullptr) fail_at(*node, text);
    // The key may be there under a name that means something else in this table.
    for (const auto& [other, there] : table_) {
      if (!reading_->known.contains(other.str()) && is_synonym(other.str(), key)) {
        fail_at(there, fmt::format("unknown key '{}' here; did you mean '{}'?", other.str(), key));
      }
    }
    fail_at(table_, text);
  }

  /// For a defect of the scene as a whole: at the line of the first key that it names, as in
  /// "forces[0]: ...", "wall 2: ..." or "[start] ...", or of a key of such a table. The key
  /// `elsewhere` was given elsewhere, in place of the file's.
  [[noreturn]] void refuse(const std::string& defect, std::string_view elsewhere) const {
    const toml::node* node = nullptr;
    for (std::size_t at = 0, end = 0; node == nullptr && at < defect.size(); at = end + 1) {
      end = std::min(defect.find_first_of(": ", at), defect.size());
      std::string named = defect.substr(at, end - at);
      if (named.starts_with('[')) named = named.substr(1, named.size() - 2);
      const char* after = defect.c_str() + std::min(end + 1, defect.size());
      if (named == "wall" && std::isdigit(*after)) {
        named = fmt::format("walls[{}]", std::atoi(after));
      }
      if (named.empty() || named == elsewhere) continue;
      node = table_.at_path(named).node();
      for (const auto& [key, part] : table_) {
        if (node == nullptr && part.is_table()) node = part.as_table()->get(named);
      }
    }
    throw SceneFileError(fmt::format("{}: {}", node ? place(*node) : source_, defect));
  }

  bool has(std::string_view key) const {
    if (!reading_->valid.empty() && !is_valid(key)) {
      throw std::logic_error(fmt::format("scene_keys.cc lacks '{}' of [{}]", key, path_));
    }
    reading_->known.emplace(key);
    return table_.contains(key);
  }

  std::optional<double> maybe_number(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    return number_of(key, *table_.get(key));
  }
  double number(std::string_view key, double fallback) const {
    return maybe_number(key).value_or(fallback);
  }
  double number(std::string_view key) const {
    if (!has(key)) fail(key, "is missing");
    return *maybe_number(key);
  }
  double positive(std::string_view key) const {
    const double x = number(key);
    if (!(x > 0)) fail(key, fmt::format("expected a positive number, got {}", x));
    return x;
  }
  std::optional<double> maybe_positive(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    return positive(key);
  }
  int integer(std::string_view key, int fallback) const {
    if (!has(key)) return fallback;
    const auto value = table_.get(key)->value_exact<std::int64_t>();
    if (!value) fail(key, "expected an integer");
    if (*value < std::numeric_limits<int>::min() || *value > std::numeric_limits<int>::max()) {
      fail(key, fmt::format("{} is out of range", *value));
    }
    return static_cast<int>(*value);
  }
  int natural(std::string_view key) const {
    if (!has(key)) fail(key, "is missing");
    const int value = integer(key, 0);
    if (value < 0) fail(key, fmt::format("expected a non-negative integer, got {}", value));
    return value;
  }
  bool boolean(std::string_view key, bool fallback) const {
    if (!has(key)) return fallback;
    const auto value = table_.get(key)->value_exact<bool>();
    if (!value) fail(key, "expected true or false");
    return *value;
  }
  std::string word(std::string_view key, std::string_view fallback) const {
    if (!has(key)) return std::string(fallback);
    const auto value = table_.get(key)->value_exact<std::string>();
    if (!value) fail(key, "expected a string");
    return printable(*value);
  }
  std::string one_of(std::string_view key, std::string_view fallback,
                     const std::vector<std::string>& choices) const {
    std::string value = word(key, fallback);
    index_of(key, "value", value, choices);
    return value;
  }
  /// The place of what a key names among all that have names; `kind`: what they are.
  std::size_t index_of(std::string_view key, std::string_view kind, const std::string& name,
                       const std::vector<std::string>& names) const {
    const auto it = std::find(names.begin(), names.end(), name);
    if (it == names.end()) fail(key, unknown_name_message(kind, name, names));
    return to_size(it - names.begin());
  }
  /// The key `name`, which becomes a column of a table.
  std::string column_name(const std::string& fallback) const {
    std::string name = word("name", fallback);
    const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
      return std::isalnum(c) != 0 || c == '_' || c == '-';
    });
    if (!plain || name.empty()) fail("name", "expected letters, digits, _ and - alone");
    return name;
  }
  /// The keys `starts` and `stops`; without them the times stay.
  void read_period(double& starts, double& stops) const {
    starts = number("starts", starts);
    if (!(starts >= 0)) fail("starts", "expected a number >= 0");
    stops = number("stops", stops);
    if (!(stops > starts)) fail("stops", "must be later than starts");
  }
  template <int D>
  std::optional<Vec<D>> maybe_vec(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    const std::vector<double> values = numbers(key);
    if (values.size() != D) {
      fail(key, fmt::format("expected {} numbers, got {}{}", D, values.size(),
                            D == 2 && values.size() == 3 ? "; a scene in space has dim = 3" : ""));
    }
    return Vec<D>(values.data());
  }
  template <int D>
  Vec<D> vec(std::string_view key) const {
    if (!has(key)) fail(key, "is missing");
    return *maybe_vec<D>(key);
  }
  /// The unit vector along that of the key.
  template <int D>
  Vec<D> direction(std::string_view key) const {
    const Vec<D> x = vec<D>(key);
    if (!(x.norm() > 0)) fail(key, "must not be zero");
    return x.normalized();
  }
  /// Zero without the key.
  template <int D>
  Vec<D> vec_or_zero(std::string_view key) const {
    return maybe_vec<D>(key).value_or(Vec<D>::Zero());
  }
  /// The key `spin`: a number in 2D, a vector in 3D; zero without it.
  template <int D>
  Spin<D> spin() const {
    if constexpr (D == 2) {
      return number("spin", 0);
    } else {
      return vec_or_zero<3>("spin");
    }
  }
  std::vector<double> numbers(std::string_view key) const {
    std::vector<double> values;
    if (!has(key)) return values;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, "expected an array of numbers");
    for (const toml::node& node : *array) values.push_back(number_of(key, node));
    return values;
  }
  std::vector<std::string> words(std::string_view key) const {
    std::vector<std::string> values;
    if (!has(key)) return values;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, "expected an array of strings");
    for (const toml::node& node : *array) {
      const auto value = node.value_exact<std::string>();
      if (!value) fail(key, "expected an array of strings");
      values.push_back(printable(*value));
    }
    return values;
  }
  /// An array of rows with `columns` numbers each.
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t columns) const {
    std::vector<std::vector<double>> result;
    if (!has(key)) return result;
    const std::string expected = fmt::format("expected an array of rows of {} numbers", columns);
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, expected);
    for (const toml::node& node : *array) {
      const toml::array* row = node.as_array();
      if (row == nullptr || row->size() != columns) fail(key, expected);
      result.emplace_back();
      for (const toml::node& number : *row) result.back().push_back(number_of(key, number));
    }
    return result;
  }
  std::optional<SceneTable> table(std::string_view key) const {
    if (!has(key)) return std::nullopt;
    const toml::table* table = table_.get(key)->as_table();
    if (table == nullptr) fail(key, "expected a table");
    const std::string name = child(name_, key);
    for (const SceneTable& part : reading_->parts) {
      if (part.name_ == name) return part;
    }
    return reading_->parts.emplace_back(*table, name, child(path_, key), source_);
  }
  std::vector<SceneTable> tables(std::string_view key) const {
    std::vector<SceneTable> result;
    if (!has(key)) return result;
    const toml::array* array = table_.get(key)->as_array();
    if (array == nullptr) fail(key, fmt::format("expected an array of tables: [[{}]]", key));
    for (const toml::node& node : *array) {
      const toml::table* table = node.as_table();
      if (table == nullptr) fail(key, "expected an array of tables");
      result.emplace_back(*table, fmt::format("{}[{}]", child(name_, key), result.size()),
                          child(path_, key), source_);
    }
    for (const SceneTable& part : result) reading_->parts.push_back(part);
    return result;
  }
  /// Every key with its value as text, for parameters of a solver.
  std::map<std::string, std::string> texts() const {
    std::map<std::string, std::string> result;
    for (const auto& [key, node] : table_) {
      reading_->known.emplace(key.str());
      if (const auto word = node.value_exact<std::string>()) {
        result[std::string(key.str())] = *word;
      } else if (const auto number = node.value<double>()) {
        result[std::string(key.str())] = fmt::format("{}", *number);
      } else {
        fail_at(node, "expected a string or a number");
      }
    }
    return result;
  }
  bool is_array(std::string_view key) const { return has(key) && table_.get(key)->is_array(); }
  const std::string& name() const { return name_; }
  /// The folder of the scene's file, to which paths in it are relative.
  std::filesystem::path folder() const { return std::filesystem::path(source_).parent_path(); }

 private:
  static std::string child(const std::string& parent, std::string_view key) {
    return parent.empty() ? std::string(key) : fmt::format("{}.{}", parent, key);
  }
  bool is_valid(std::string_view key) const {
    return std::find(reading_->valid.begin(), reading_->valid.end(), key) != reading_->valid.end();
  }
  double number_of(std::string_view key, const toml::node& node) const {
    const bool numeric = node.is_integer() || node.is_floating_point();
    const std::optional<double> value = numeric ? node.value<double>() : std::nullopt;
    if (!value || !std::isfinite(*value)) fail(key, "expected a finite number");
    return *value;
  }
  std::string place(const toml::node& node) const {
    const auto line = node.source().begin.line;  // 0: the file as a whole
    return line > 0 ? fmt::format("{}:{}", source_, line) : source_;
  }
  [[noreturn]] void fail_at(const toml::node& node, const std::string& message) const {
    throw SceneFileError(
        fmt::format("{}: [{}] {}", place(node), name_.empty() ? "top level" : name_, message));
  }

  const toml::table& table_;
  std::string name_, path_;
  const std::string& source_;
  /// Copies of a table share it.
  struct Reading {
    std::vector<std::string> valid;  // keys; empty: any
    std::set<std::string, std::less<>> known;
    std::vector<SceneTable> parts;  // tables in this one that have been asked for
  };
  std::shared_ptr<Reading> reading_;
};

}  // namespace bipot
