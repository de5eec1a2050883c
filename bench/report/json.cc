#include "bench/report/json.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

namespace bipot {

Json::Json(bool truth) : kind_(Kind::kBool), integer_(truth ? 1 : 0) {}
Json::Json(int integer) : Json(static_cast<long>(integer)) {}
Json::Json(long integer) : kind_(Kind::kInteger), integer_(integer) {}
Json::Json(unsigned integer) : Json(static_cast<long>(integer)) {}
Json::Json(unsigned long integer) : Json(static_cast<long>(integer)) {}
Json::Json(double number) : kind_(std::isfinite(number) ? Kind::kNumber : Kind::kNull) {
  if (kind_ == Kind::kNumber) number_ = number;
}
Json::Json(const char* text) : kind_(Kind::kText), text_(text) {}
Json::Json(std::string_view text) : kind_(Kind::kText), text_(text) {}
Json::Json(std::string text) : kind_(Kind::kText), text_(std::move(text)) {}
Json::Json(const std::vector<std::string>& texts)
    : kind_(Kind::kArray), values_(texts.begin(), texts.end()) {}
Json::Json(const std::vector<std::vector<std::string>>& rows)
    : kind_(Kind::kArray), values_(rows.begin(), rows.end()) {}
Json::Json(const std::vector<double>& numbers)
    : kind_(Kind::kArray), values_(numbers.begin(), numbers.end()) {}
Json::Json(const std::map<std::string, std::string>& members) : kind_(Kind::kObject) {
  for (const auto& [key, value] : members) (*this)[key] = value;
}
Json::Json(std::initializer_list<Json> list) {
  const bool pairs = std::all_of(list.begin(), list.end(), [](const Json& entry) {
    return entry.kind_ == Kind::kArray && entry.size() == 2 &&
           entry.values_.front().kind_ == Kind::kText;
  });
  kind_ = pairs ? Kind::kObject : Kind::kArray;
  for (const Json& entry : list) {
    if (pairs) {
      (*this)[entry.values_.front().text_] = entry.values_.back();
    } else {
      values_.push_back(entry);
    }
  }
}
Json Json::array() {
  Json json;
  json.kind_ = Kind::kArray;
  return json;
}
Json Json::object() {
  Json json;
  json.kind_ = Kind::kObject;
  return json;
}

void Json::require(Kind kind) const {
  static constexpr const char* kNames[] = {"null", "a truth value", "an integer", "a number",
                                           "text", "an array",      "an object"};
  if (kind_ != kind) {
    throw Error(std::string("expected ") + kNames[static_cast<int>(kind)] + ", found " +
                kNames[static_cast<int>(kind_)]);
  }
}

template <>
bool Json::get() const {
  require(Kind::kBool);
  return integer_ != 0;
}
template <>
int Json::get() const {
  require(Kind::kInteger);
  return static_cast<int>(integer_);
}
template <>
std::size_t Json::get() const {
  require(Kind::kInteger);
  if (integer_ < 0) throw Error("expected a number of at least 0, found " + dump());
  return static_cast<std::size_t>(integer_);
}
template <>
double Json::get() const {
  if (kind_ == Kind::kInteger) return static_cast<double>(integer_);
  require(Kind::kNumber);
  return number_;
}
template <>
std::string Json::get() const {
  require(Kind::kText);
  return text_;
}

namespace {

template <class T>
std::vector<T> vector_of(const Json& array) {
  std::vector<T> values;
  for (const Json& value : array) values.push_back(value.get<T>());
  return values;
}

}  // namespace

template <>
std::vector<std::string> Json::get() const {
  require(Kind::kArray);
  return vector_of<std::string>(*this);
}
template <>
std::vector<std::vector<std::string>> Json::get() const {
  require(Kind::kArray);
  return vector_of<std::vector<std::string>>(*this);
}
template <>
std::vector<double> Json::get() const {
  require(Kind::kArray);
  return vector_of<double>(*this);
}

bool Json::contains(std::string_view key) const {
  return std::find(keys_.begin(), keys_.end(), key) != keys_.end();
}
const Json& Json::at(std::string_view key) const {
  require(Kind::kObject);
  const auto found = std::find(keys_.begin(), keys_.end(), key);
  if (found == keys_.end()) throw Error("there is no member \"" + std::string(key) + "\"");
  return values_[static_cast<std::size_t>(found - keys_.begin())];
}
const Json& Json::at(std::size_t index) const {
  require(Kind::kArray);
  if (index >= size()) throw Error("the array has no entry " + std::to_string(index));
  return values_[index];
}
Json Json::value(std::string_view key, const Json& otherwise) const {
  return contains(key) ? at(key) : otherwise;
}
Json& Json::operator[](std::string_view key) {
  if (kind_ == Kind::kNull) kind_ = Kind::kObject;
  require(Kind::kObject);
  const auto found = std::find(keys_.begin(), keys_.end(), key);
  if (found != keys_.end()) return values_[static_cast<std::size_t>(found - keys_.begin())];
  keys_.emplace_back(key);
  return values_.emplace_back();
}
Json& Json::operator[](std::size_t index) { return const_cast<Json&>(std::as_const(*this)[index]); }
void Json::push_back(Json value) {
  if (kind_ == Kind::kNull) kind_ = Kind::kArray;
  require(Kind::kArray);
  values_.push_back(std::move(value));
}
void Json::update(const Json& object) {
  object.require(Kind::kObject);
  for (std::size_t i = 0; i < object.size(); ++i) (*this)[object.keys_[i]] = object.values_[i];
}

bool operator==(const Json& a, const Json& b) {
  if (a.is_number() && b.is_number() && a.kind_ != b.kind_) {
    return a.get<double>() == b.get<double>();
  }
  return a.kind_ == b.kind_ && a.integer_ == b.integer_ && a.number_ == b.number_ &&
         a.text_ == b.text_ && a.keys_ == b.keys_ && a.values_ == b.values_;
}

/// Between the two trees.
struct JsonText {
  static nlohmann::ordered_json to_library(const Json& from) {
    switch (from.kind_) {
      case Json::Kind::kNull:
        return nullptr;
      case Json::Kind::kBool:
        return from.integer_ != 0;
      case Json::Kind::kInteger:
        return from.integer_;
      case Json::Kind::kNumber:
        return from.number_;
      case Json::Kind::kText:
        return from.text_;
      case Json::Kind::kArray: {
        auto array = nlohmann::ordered_json::array();
        for (const Json& value : from.values_) array.push_back(to_library(value));
        return array;
      }
      case Json::Kind::kObject:
        break;
    }
    auto object = nlohmann::ordered_json::object();
    for (std::size_t i = 0; i < from.size(); ++i) {
      object[from.keys_[i]] = to_library(from.values_[i]);
    }
    return object;
  }

  static Json from_library(const nlohmann::ordered_json& from) {
    if (from.is_null()) return nullptr;
    if (from.is_boolean()) return from.get<bool>();
    if (from.is_number_integer()) return from.get<long>();
    if (from.is_number()) return from.get<double>();
    if (from.is_string()) return from.get<std::string>();
    Json json = from.is_array() ? Json::array() : Json::object();
    for (auto it = from.begin(); it != from.end(); ++it) {
      if (from.is_object()) json.keys_.push_back(it.key());
      json.values_.push_back(from_library(*it));
    }
    return json;
  }
};

Json Json::parse(std::istream& in) {
  try {
    return JsonText::from_library(nlohmann::ordered_json::parse(in));
  } catch (const nlohmann::json::exception& e) {
    throw Error(e.what());
  }
}

Json Json::parse(const std::string& text) {
  std::istringstream in(text);
  return parse(in);
}

std::string Json::dump(int indent) const {
  return JsonText::to_library(*this).dump(indent, ' ', false,
                                          nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace bipot
