#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/types.h"
#include "core/files/hdf5_file.h"

namespace bipot {

// Datasets: a value of each item of a list. The value is a member, or what a
// function says of an item: to read, a reference. Numbers make a column, vectors rows, and so do
// quaternions: w, x, y, z.

/// Collects one column of numbers, or several, row by row.
class Hdf5Column {
 public:
  explicit Hdf5Column(std::size_t reserve = 0) { values_.reserve(reserve); }
  void add(double x) { values_.push_back(x); }
  template <int D>
  void add(const Eigen::Matrix<double, D, 1>& x) {
    values_.insert(values_.end(), x.begin(), x.end());
  }
  std::span<const double> values() const { return values_; }

 private:
  std::vector<double> values_;
};

/// Type of the value of an item.
template <class At, class Item>
using ColumnValue = std::remove_cvref_t<std::invoke_result_t<const At&, Item&>>;
template <class Value>
inline constexpr bool kWholeNumbers = std::is_integral_v<Value> || std::is_enum_v<Value>;

/// `unit`: not that of whole numbers. Throws FileError.
template <class Item, class At>
void write_column(Hdf5File& file, const std::string& name, const char* unit,
                  const std::vector<Item>& items, const At& at) {
  using Value = ColumnValue<At, const Item>;
  if constexpr (kWholeNumbers<Value>) {
    std::vector<int> column;
    column.reserve(items.size());
    for (const Item& item : items) column.push_back(static_cast<int>(std::invoke(at, item)));
    file.write(name, column);
  } else if constexpr (std::is_same_v<Value, double>) {
    Hdf5Column column(items.size());
    for (const Item& item : items) column.add(std::invoke(at, item));
    file.write(name, column.values(), unit);
  } else if constexpr (std::is_same_v<Value, Eigen::Quaterniond>) {
    write_column(file, name, unit, items, [&](const Item& item) {
      const Value& q = std::invoke(at, item);
      return Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
    });
  } else {
    constexpr std::size_t kWidth = Value::RowsAtCompileTime;
    Hdf5Column column(kWidth * items.size());
    for (const Item& item : items) column.add(std::invoke(at, item));
    file.write_rows(name, column.values(), kWidth, unit);
  }
}

/// Sets the value of each item. Throws FileError, also for an enumerator that is not one of 0 to
/// `last`.
template <class Item, class At>
void read_column(const Hdf5File& file, const std::string& name, std::vector<Item>& items,
                 const At& at, int last = 0) {
  using Value = ColumnValue<At, Item>;
  const std::size_t count = items.size();
  if constexpr (kWholeNumbers<Value>) {
    const std::vector<int> column = file.read_ints(name, count);
    for (std::size_t k = 0; k < count; ++k) {
      if (std::is_enum_v<Value> && (column[k] < 0 || column[k] > last)) {
        throw FileError(file.path(), name,
                        fmt::format("{} is not one of 0 to {}", column[k], last));
      }
      std::invoke(at, items[k]) = static_cast<Value>(column[k]);
    }
  } else if constexpr (std::is_same_v<Value, double>) {
    const std::vector<double> column = file.read_doubles(name, count);
    for (std::size_t k = 0; k < count; ++k) std::invoke(at, items[k]) = column[k];
  } else if constexpr (std::is_same_v<Value, Eigen::Quaterniond>) {
    const std::vector<double> rows = file.read_doubles(name, 4 * count);
    for (std::size_t k = 0; k < count; ++k) {
      const double* const q = rows.data() + 4 * k;
      std::invoke(at, items[k]) = Value(q[0], q[1], q[2], q[3]);
    }
  } else {
    constexpr std::size_t kWidth = Value::RowsAtCompileTime;
    const std::vector<double> rows = file.read_doubles(name, kWidth * count);
    for (std::size_t k = 0; k < count; ++k) {
      std::invoke(at, items[k]) = Eigen::Map<const Value>(rows.data() + kWidth * k);
    }
  }
}

/// The same where the file has the dataset; without it the values stay.
template <class Item, class At>
void read_optional_column(const Hdf5File& file, const std::string& name, std::vector<Item>& items,
                          const At& at) {
  if (file.exists(name)) read_column(file, name, items, at);
}

/// 0, 1, 2, ...: ParaView's readers need the point numbers of each cell.
inline void write_point_numbers(Hdf5File& file, const std::string& name, std::size_t points) {
  std::vector<int> numbers(points);
  std::iota(numbers.begin(), numbers.end(), 0);
  file.write(name, numbers);
}

}  // namespace bipot
