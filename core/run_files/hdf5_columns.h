#pragma once

#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "core/files/hdf5_file.h"

namespace bipot {

/// Datasets of the files of a run: a value of each item of a range.

/// Collects one column of numbers, or several, row by row.
class Hdf5Column {
 public:
  explicit Hdf5Column(std::size_t reserve) { values_.reserve(reserve); }
  void add(double x) { values_.push_back(x); }
  template <int D>
  void add(const Eigen::Matrix<double, D, 1>& x) {
    values_.insert(values_.end(), x.begin(), x.end());
  }
  std::span<const double> values() const { return values_; }

 private:
  std::vector<double> values_;
};

template <class Range, class Get>
void write_doubles(Hdf5File& file, const std::string& name, const char* unit, const Range& range,
                   Get&& get) {
  Hdf5Column column(range.size());
  for (const auto& item : range) column.add(static_cast<double>(get(item)));
  file.write(name, column.values());
  file.write_attribute(name, "unit", unit);
}

template <class Range, class Get>
void write_vectors(Hdf5File& file, const std::string& name, const char* unit, const Range& range,
                   Get&& get) {
  using Vec = std::remove_cvref_t<decltype(get(*range.begin()))>;
  constexpr std::size_t kWidth = Vec::RowsAtCompileTime;
  Hdf5Column column(kWidth * range.size());
  for (const auto& item : range) column.add(Vec(get(item)));
  file.write_rows(name, column.values(), kWidth);
  file.write_attribute(name, "unit", unit);
}

/// Numbers in 2D, vectors in 3D.
template <class Range, class Get>
void write_turns(Hdf5File& file, const std::string& name, const char* unit, const Range& range,
                 Get&& get) {
  if constexpr (std::is_convertible_v<decltype(get(*range.begin())), double>) {
    write_doubles(file, name, unit, range, get);
  } else {
    write_vectors(file, name, unit, range, get);
  }
}

template <class Range, class Get>
void write_ints(Hdf5File& file, const std::string& name, const Range& range, Get&& get) {
  std::vector<int> column;
  column.reserve(range.size());
  for (const auto& item : range) column.push_back(static_cast<int>(get(item)));
  file.write(name, column);
}

/// 0, 1, 2, ...: ParaView's readers need the point numbers of each cell.
inline void write_point_numbers(Hdf5File& file, const std::string& name, std::size_t points) {
  std::vector<int> numbers(points);
  for (std::size_t k = 0; k < numbers.size(); ++k) numbers[k] = static_cast<int>(k);
  file.write(name, numbers);
}

}  // namespace bipot
