#include "core/problem_files/npy_file.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>

#include "core/base/file_error.h"
#include "core/files/input_file.h"

namespace bipot {
namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they stand");

constexpr std::string_view kMagic = "\x93NUMPY";

/// The text after 'key': in the header, which is a Python dictionary.
std::string_view entry(const std::filesystem::path& path, std::string_view header,
                       std::string_view key) {
  const std::string quoted = fmt::format("'{}':", key);
  const std::size_t found = header.find(quoted);
  if (found == std::string_view::npos) {
    throw FileError(path, "header", fmt::format("'{}' is missing", key));
  }
  std::string_view rest = header.substr(found + quoted.size());
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  return rest;
}

std::vector<std::size_t> parse_shape(const std::filesystem::path& path, std::string_view text) {
  std::vector<std::size_t> shape;
  const std::size_t end = text.find(')');
  if (!text.starts_with('(') || end == std::string_view::npos) {
    throw FileError(path, "header", "the shape is not a tuple");
  }
  text = text.substr(1, end - 1);
  while (text.find_first_not_of(", ") != std::string_view::npos) {
    text.remove_prefix(text.find_first_not_of(", "));
    std::size_t extent = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), extent);
    if (error != std::errc()) throw FileError(path, "header", "the shape is not made of numbers");
    shape.push_back(extent);
    text.remove_prefix(static_cast<std::size_t>(stop - text.data()));
  }
  return shape;
}

template <class Number>
std::vector<double> numbers(std::string_view bytes) {
  std::vector<double> values(bytes.size() / sizeof(Number));
  for (std::size_t k = 0; k < values.size(); ++k) {
    Number x;
    std::memcpy(&x, bytes.data() + k * sizeof(Number), sizeof(Number));
    values[k] = static_cast<double>(x);
  }
  return values;
}

/// From first index fastest to last index fastest.
std::vector<double> transposed(const std::vector<double>& values,
                               const std::vector<std::size_t>& shape) {
  std::vector<double> out(values.size());
  std::vector<std::size_t> index(shape.size(), 0);
  for (const double value : values) {
    std::size_t place = 0;
    for (std::size_t k = 0; k < shape.size(); ++k) place = place * shape[k] + index[k];
    out[place] = value;
    for (std::size_t k = 0; k < shape.size() && ++index[k] == shape[k]; ++k) index[k] = 0;
  }
  return out;
}

}  // namespace

bool is_npy(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  char begin[kMagic.size()] = {};
  in.read(begin, sizeof begin);
  return in && std::string_view(begin, sizeof begin) == kMagic;
}

NpyArray read_npy(const std::filesystem::path& path) {
  const std::string content = read_text_file(path);
  const std::string_view all = content;
  if (!all.starts_with(kMagic) || all.size() < 12) throw FileError(path, "", "not a .npy file");
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(all[k]); };
  const int version = byte(6);
  if (version < 1 || version > 3) {
    throw FileError(path, "", fmt::format("format version {} is not 1, 2 or 3", version));
  }
  const std::size_t begin = version == 1 ? 10 : 12;
  std::size_t length = byte(8) + 256u * byte(9);
  if (version > 1) length += 65536u * (byte(10) + std::size_t{256} * byte(11));
  if (all.size() < begin + length) throw FileError(path, "header", "the file ends within it");
  const std::string_view header = all.substr(begin, length);
  const std::string_view bytes = all.substr(begin + length);

  NpyArray array{.shape = parse_shape(path, entry(path, header, "shape"))};
  const std::string_view descr = entry(path, header, "descr"), type = descr.substr(0, 5);
  const std::size_t width = type == "'<f8'" || type == "'<i8'" ? 8 : 4;
  if (type != "'<f8'" && type != "'<f4'" && type != "'<i8'" && type != "'<i4'") {
    throw FileError(path, "header",
                    fmt::format("elements of type {}: expected float64, float32, int64 or int32, "
                                "little-endian",
                                descr.substr(0, descr.find_first_of(",}"))));
  }
  // Extents whose product overflows would seem small.
  std::size_t count = 1;
  for (const std::size_t extent : array.shape) {
    if (extent != 0 && count > bytes.size() / extent) {
      throw FileError(path, "", "the shape asks for more elements than the file has");
    }
    count *= extent;
  }
  if (count * width != bytes.size()) {
    throw FileError(path, "",
                    fmt::format("{} bytes of elements, the shape asks for {} of {} bytes",
                                bytes.size(), count, width));
  }
  array.values = type == "'<f8'"   ? numbers<double>(bytes)
                 : type == "'<f4'" ? numbers<float>(bytes)
                 : type == "'<i8'" ? numbers<std::int64_t>(bytes)
                                   : numbers<std::int32_t>(bytes);
  if (entry(path, header, "fortran_order").starts_with("True")) {
    array.values = transposed(array.values, array.shape);
  }
  return array;
}

}  // namespace bipot
