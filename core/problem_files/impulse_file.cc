#include "core/problem_files/impulse_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/file_error.h"
#include "core/base/number_text.h"
#include "core/files/hdf5_file.h"
#include "core/files/input_file.h"
#include "core/problem_files/npy_file.h"

namespace bipot {
namespace {

/// Numbers with their rows and columns; columns 1: a plain list.
struct TextTable {
  std::vector<double> values;  // row by row
  std::size_t columns = 1;
  std::vector<std::string> names;  // of the last columns, from the line before the numbers

  std::size_t rows() const { return columns == 0 ? 0 : values.size() / columns; }
};

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kSeparators = " \t\r,;";
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = line.find_first_not_of(kSeparators);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const std::size_t end = std::min(line.find_first_of(kSeparators), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

/// The numbers of "size = 6; data= [1, 2, ...]", and how many they are said to be; other text as it
/// is.
std::string_view without_brackets(const std::filesystem::path& path, std::string_view text,
                                  std::optional<std::size_t>& size) {
  const std::string_view begin =
      text.substr(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (!begin.starts_with("size")) return text;
  text = begin;
  const std::size_t open = text.find('['), close = text.rfind(']');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) {
    throw FileError(path, "", "begins with 'size', but has no [...] with numbers");
  }
  const std::vector<std::string_view> words = words_of(text.substr(0, open));
  if (words.size() > 2 && words[1] == "=") size = whole_number<std::size_t>(words[2]);
  return text.substr(open + 1, close - open - 1);
}

TextTable read_text(const std::filesystem::path& path) {
  const std::string content = read_text_file(path);
  if (content.find('\0') != std::string::npos) {
    throw FileError(path, "", "neither a text file nor .npy nor HDF5");
  }
  std::optional<std::size_t> size;
  const std::string_view text = without_brackets(path, content, size);
  TextTable table;
  bool even = true;
  std::size_t columns = 0, number = 0;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    const std::vector<std::string_view> words = words_of(line.substr(0, line.find('#')));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    ++number;
    if (words.empty()) continue;
    if (table.values.empty() && !printed_number(words.front())) {
      table.names.assign(words.begin(), words.end());
      continue;
    }
    if (columns == 0) columns = words.size();
    even = even && words.size() == columns;
    for (const std::string_view word : words) {
      const std::optional<double> x = printed_number(word);
      if (!x) {
        throw FileError(path, fmt::format("line {}", number),
                        fmt::format("'{}' is not a number", word));
      }
      table.values.push_back(*x);
    }
  }
  if (size && *size != table.values.size()) {
    throw FileError(path, "",
                    fmt::format("{} numbers, where size is {}", table.values.size(), *size));
  }
  if (even) table.columns = std::max<std::size_t>(1, columns);
  return table;
}

TextTable read_table(const std::filesystem::path& path) {
  if (is_npy(path)) {
    NpyArray array = read_npy(path);
    if (array.shape.size() > 2) {
      throw FileError(path, "", fmt::format("{} dimensions, expected 1 or 2", array.shape.size()));
    }
    const std::size_t columns = array.shape.size() == 2 ? array.shape[1] : 1;
    return {std::move(array.values), columns, {}};
  }
  if (Hdf5File::is_hdf5(path)) {
    const Hdf5File file(path, Hdf5File::Mode::kRead);
    if (!file.exists("/solution/r")) {
      throw FileError(path, "/solution/r", "is missing: the file has no impulses");
    }
    const std::vector<std::size_t> shape = file.shape("/solution/r");
    return {file.read_doubles("/solution/r"), shape.size() == 2 ? shape[1] : 1, {}};
  }
  return read_text(path);
}

/// True if the first column counts from 0 or 1.
bool counts(const TextTable& table) {
  const double first = table.values.empty() ? -1 : table.values[0];
  if (first != 0 && first != 1) return false;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (table.values[row * table.columns] != first + static_cast<double>(row)) return false;
  }
  return true;
}

/// The component in the name of a column: "n", "s_n", "rn", "Normal"; t1 and t2 are t and s.
std::optional<char> component_of(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name.starts_with("normal")) return 'n';
  if (name.starts_with("tangent") || name == "t1") return name.ends_with('2') ? 's' : 't';
  if (name == "t2") return 's';
  const bool known =
      name.size() <= 3 && std::string_view("nts").find(name.back()) != std::string::npos;
  return known ? std::optional(name.back()) : std::nullopt;
}

/// True for contact numbers, or a size, and normals of a frictionless problem; false for normals and
/// inert tangents.
bool numbers_normals(const std::filesystem::path& path, const TextTable& table,
                     std::size_t contacts) {
  const std::vector<double>& x = table.values;
  const bool is_text = !is_npy(path) && !Hdf5File::is_hdf5(path);
  const auto refuse = [&] {
    throw FileError(path, "",
                    "a size or numbers of the contacts with normal impulses 0, or normals with "
                    "tangents 0: name two columns in a line before them");
  };
  if (table.columns == 1 && x.size() == contacts + 1) {  // of one contact two numbers
    if (!is_text || x[0] != static_cast<double>(contacts)) return false;
    if (x[1] == 0) refuse();
    return true;
  }
  if (table.columns != 2 || table.rows() != contacts) return false;
  if (table.names.size() >= 2) {
    if (component_of(table.names.back()) == 'n') return counts(table);
    if (component_of(table.names[table.names.size() - 2]) == 'n') return false;
  }
  if (!counts(table)) return false;
  for (std::size_t row = 0; row < contacts; ++row) {
    if (x[2 * row + 1] != 0) return true;
  }
  if (is_text && (contacts > 1 || x[0] != 0)) refuse();
  return false;
}

/// Removes a column of contact numbers and a leading size.
void strip(TextTable& table, std::size_t contacts, std::size_t dim) {
  std::vector<double>& x = table.values;
  const std::size_t size = contacts * dim;
  if (table.columns == dim + 1 && table.rows() == contacts && counts(table)) {
    TextTable impulses{{}, dim, table.names};
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (k % table.columns != 0) impulses.values.push_back(x[k]);
    }
    table = std::move(impulses);
  } else if (x.size() == size + 1 && !x.empty() && x[0] == static_cast<double>(size)) {
    x.erase(x.begin());
    table.columns = 1;
  }
}

/// Names that say another order than the one the columns are read in are refused.
void check_names(const std::filesystem::path& path, const TextTable& table, std::size_t dim,
                 const ImpulseLayout& layout) {
  if (dim < 2 || table.columns != dim || table.names.size() < dim) return;
  const std::string expected =
      layout.components.empty() ? std::string("nts").substr(0, dim) : layout.components;
  const auto names = table.names.end() - static_cast<std::ptrdiff_t>(dim);
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const std::string& name = names[static_cast<std::ptrdiff_t>(k)];
    const std::optional<char> said = component_of(name);
    if (!said || *said == expected[k]) continue;
    throw FileError(path, "",
                    fmt::format("column {} is named '{}', but the columns are read as '{}': give "
                                "the order of the components",
                                k + 1, name, expected));
  }
}

/// Position in the file of component k (0: normal) of a contact, from the letters of the layout.
/// Moments of rolling in space have no letters and keep their places.
std::vector<std::size_t> component_places(const ImpulseLayout& layout, std::size_t dim) {
  const std::string standard = std::string("nts").substr(0, dim);
  const std::string letters = layout.components.empty() ? standard : layout.components;
  if (!std::is_permutation(letters.begin(), letters.end(), standard.begin(), standard.end())) {
    throw std::invalid_argument(fmt::format(
        "components '{}': expected the letters of '{}' in some order", letters, standard));
  }
  for (const char c : layout.negated) {
    if (standard.find(c) == std::string::npos) {
      throw std::invalid_argument(fmt::format("negated components '{}': expected letters of '{}'",
                                              layout.negated, standard));
    }
  }
  std::vector<std::size_t> places;
  for (const char c : standard) places.push_back(letters.find(c));
  while (places.size() < dim) places.push_back(places.size());
  return places;
}

/// The order that the shape of a table gives, if it gives one.
std::optional<ImpulseLayout::Order> order_of(const TextTable& table, std::size_t contacts,
                                             std::size_t dim) {
  using Order = ImpulseLayout::Order;
  if (contacts == dim || contacts <= 1 || dim == 1) return {};  // square, or both are the same
  if (table.columns == contacts) return Order::kComponent;
  if (table.columns == dim) return Order::kContact;
  return {};
}

Vector arrange(const TextTable& table, std::size_t contacts, std::size_t dim,
               const ImpulseLayout& layout) {
  const std::vector<std::size_t> place = component_places(layout, dim);
  const auto order = layout.order ? layout.order : order_of(table, contacts, dim);
  const bool by_contact = order != ImpulseLayout::Order::kComponent;
  Vector s(static_cast<Eigen::Index>(contacts * dim));
  for (std::size_t c = 0; c < contacts; ++c) {
    for (std::size_t k = 0; k < dim; ++k) {
      const bool negated = k < 3 && layout.negated.find("nts"[k]) != std::string::npos;
      const std::size_t from = by_contact ? c * dim + place[k] : place[k] * contacts + c;
      s[static_cast<Eigen::Index>(c * dim + k)] =
          (negated ? -1 : 1) * layout.factor * table.values[from];
    }
  }
  return s;
}

}  // namespace

Vector read_impulses(const std::filesystem::path& path, const ContactProblem& problem,
                     const ImpulseLayout& layout) {
  require_regular_file(path);
  if (path.extension() == ".toml") {
    throw FileError(path, "",
                    fmt::format("a scene, not impulses: expected .npy, .csv, FCLIB HDF5 or Siconos "
                                "text with {} = {} contacts x {} numbers",
                                problem.num_rows(), problem.num_contacts(), problem.dim));
  }
  Hdf5File::check_structure(path);
  TextTable table = read_table(path);
  const std::size_t contacts = to_size(problem.num_contacts()), dim = to_size(problem.dim);
  const bool with_tangents = dim == 1 && table.values.size() >= 2 * contacts && contacts > 0 &&
                             !numbers_normals(path, table, contacts);
  const std::size_t file_dim = with_tangents ? 2 : dim;
  strip(table, contacts, file_dim);
  if (table.values.size() != contacts * file_dim) {
    throw FileError(
        path, "",
        fmt::format(
            "{}, expected {} = {} contacts x {}",
            table.values.empty() ? "no numbers" : fmt::format("s has size {}", table.values.size()),
            problem.num_rows(), contacts, dim));
  }
  const auto shape = order_of(table, contacts, file_dim);
  if (layout.order && shape && layout.order != shape) {
    throw FileError(path, "",
                    fmt::format("rows of {} numbers are in the other order; for a list, write one "
                                "number a line",
                                table.columns));
  }
  if ((is_npy(path) || Hdf5File::is_hdf5(path)) && contacts > 0) {
    const std::size_t m = table.values.size(), columns = table.columns;
    if (columns != 1 && columns != file_dim && columns != contacts && columns != m) {
      throw FileError(path, "",
                      fmt::format("the shape {} x {}, expected {}, {} x {} or {} x {}", m / columns,
                                  columns, m, contacts, file_dim, file_dim, contacts));
    }
  }
  Vector s = arrange(table, contacts, file_dim, layout);
  check_names(path, table, file_dim, layout);
  for (Eigen::Index k = 0; k < s.size(); ++k) {
    if (!std::isfinite(s[k])) {
      throw FileError(path, "", fmt::format("s[{}] = {} is not finite", k, s[k]));
    }
  }
  if (!with_tangents) return s;
  Vector normals(problem.num_rows());
  for (Eigen::Index c = 0; c < normals.size(); ++c) {
    if (s[2 * c + 1] != 0) {
      throw FileError(path, "",
                      fmt::format("contact {} of a frictionless problem has the tangential impulse "
                                  "{}, expected 0",
                                  c, s[2 * c + 1]));
    }
    normals[c] = s[2 * c];
  }
  return normals;
}

}  // namespace bipot
