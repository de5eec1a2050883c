#pragma once

#include <cstddef>
#include <initializer_list>
#include <iosfwd>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace bipot {

/// A JSON value; members of objects keep the order in which they came. nlohmann-json reads and
/// writes the text. It is large, and each literal makes its templates anew, so it stays in json.cc.
class Json {
 public:
  /// The text is no JSON, a member is missing, a value is not of the kind that is asked for.
  struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  Json() = default;
  Json(std::nullptr_t) {}
  Json(bool truth);
  Json(int integer);
  Json(long integer);
  Json(unsigned integer);
  Json(unsigned long integer);
  Json(double number);  ///< null where it is not finite: JSON has no NaN
  Json(const char* text);
  Json(std::string_view text);
  Json(std::string text);
  Json(const std::vector<std::string>& texts);
  Json(const std::vector<std::vector<std::string>>& rows);
  Json(const std::vector<double>& numbers);
  Json(const std::map<std::string, std::string>& members);
  /// {{"key", value}, ...} is an object, any other list an array.
  Json(std::initializer_list<Json> list);
  static Json array();
  static Json object();

  /// Throws Error.
  static Json parse(std::istream& in);
  static Json parse(const std::string& text);
  /// On one line, or indented. What is not UTF-8 in a text is replaced.
  std::string dump(int indent = -1) const;

  bool is_null() const { return kind_ == Kind::kNull; }
  bool is_number() const { return kind_ == Kind::kInteger || kind_ == Kind::kNumber; }
  /// bool, int, std::size_t, double, std::string, or a vector of numbers, texts or rows of texts.
  /// Throws Error where the value is something else.
  template <class T>
  T get() const;

  std::size_t size() const { return values_.size(); }
  bool empty() const { return values_.empty(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }
  bool contains(std::string_view key) const;
  /// Of an object or an array. Throws Error when there is no such entry.
  const Json& at(std::string_view key) const;
  const Json& at(std::size_t index) const;
  const Json& operator[](std::string_view key) const { return at(key); }
  const Json& operator[](std::size_t index) const { return at(index); }
  /// The member, or `otherwise` where the object has none.
  Json value(std::string_view key, const Json& otherwise) const;

  /// The member, made null where there is none; null becomes an object. The reference ends with the
  /// next member that is made: a["x"] = a["y"] = ... would write into what was.
  Json& operator[](std::string_view key);
  Json& operator[](std::size_t index);
  /// Null becomes an array.
  void push_back(Json value);
  /// Sets the members of another object.
  void update(const Json& object);

  /// Integers equal numbers of the same value.
  friend bool operator==(const Json& a, const Json& b);

 private:
  enum class Kind { kNull, kBool, kInteger, kNumber, kText, kArray, kObject };
  friend struct JsonText;

  void require(Kind kind) const;

  Kind kind_ = Kind::kNull;
  long integer_ = 0;  // a truth too
  double number_ = 0;
  std::string text_;
  std::vector<Json> values_;       // of an array or an object
  std::vector<std::string> keys_;  // of an object
};

template <>
bool Json::get() const;
template <>
int Json::get() const;
template <>
std::size_t Json::get() const;
template <>
double Json::get() const;
template <>
std::string Json::get() const;
template <>
std::vector<double> Json::get() const;
template <>
std::vector<std::string> Json::get() const;
template <>
std::vector<std::vector<std::string>> Json::get() const;

}  // namespace bipot
