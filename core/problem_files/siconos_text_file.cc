#include "core/problem_files/siconos_text_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/file_error.h"
#include "core/base/number_text.h"
#include "core/base/triplets.h"
#include "core/files/input_file.h"
#include "core/problem_files/problem_form.h"

namespace bipot {
namespace {

/// Words of a text, separated by white space, with the line of each for messages.
class Words {
 public:
  explicit Words(const std::filesystem::path& path) : path_(path), text_(read_text_file(path)) {
    if (text_.find('\0') != std::string::npos) throw FileError(path, "", "not a text file");
  }

  [[noreturn]] void fail(std::string_view reason) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + begin_of_word_, '\n');
    throw FileError(path_, fmt::format("line {}", line), reason);
  }

  std::string_view word(std::string_view what) {
    skip_space();
    begin_of_word_ = static_cast<std::ptrdiff_t>(at_);
    if (at_ == text_.size()) fail(fmt::format("the file ends where {} should stand", what));
    while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
    return std::string_view(text_).substr(static_cast<std::size_t>(begin_of_word_),
                                          at_ - static_cast<std::size_t>(begin_of_word_));
  }

  double number(std::string_view what) {
    const std::string_view w = word(what);
    const auto value = printed_number(w);
    if (!value) fail(fmt::format("{}: '{}' is not a number", what, w));
    if (!std::isfinite(*value)) fail(fmt::format("{} = {} is not finite", what, *value));
    return *value;
  }

  int integer(std::string_view what, int lowest = 0) {
    const std::string_view w = word(what);
    const auto value = whole_number<int>(w);
    if (!value) fail(fmt::format("{}: '{}' is not an integer", what, w));
    if (*value < lowest) fail(fmt::format("{} = {} is too small", what, *value));
    return *value;
  }

  void expect(std::string_view text) {
    const std::string_view w = word(text);
    if (w != text) fail(fmt::format("'{}' where '{}' should stand", w, text));
  }

  /// The rest of the line, without its end.
  std::string_view line() {
    begin_of_word_ = static_cast<std::ptrdiff_t>(at_);
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    const std::string_view rest = std::string_view(text_).substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    return rest;
  }

  /// The next two integers, which stay; -1 for what is none.
  std::array<int, 2> next_two() const {
    std::array<int, 2> values{-1, -1};
    const char* at = text_.data() + at_;
    const char* const end = text_.data() + text_.size();
    for (int& value : values) {
      while (at != end && is_space(*at)) ++at;
      const auto [stop, error] = std::from_chars(at, end, value);
      if (error != std::errc()) return values;
      at = stop;
    }
    return values;
  }

  /// Number of remaining words.
  std::size_t left() const {
    std::size_t count = 0;
    bool inside = false;
    for (std::size_t k = at_; k < text_.size(); ++k) {
      const bool space = is_space(text_[k]);
      if (!space && !inside) ++count;
      inside = !space;
    }
    return count;
  }

  /// No sensible count exceeds the number of characters: guards the allocations below.
  void require_plausible(double count, std::string_view what) const {
    if (count > static_cast<double>(text_.size())) {
      fail(fmt::format("{} {}: more than the file can hold", count, what));
    }
  }

 private:
  static bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }

  std::filesystem::path path_;
  std::string text_;
  std::size_t at_ = 0;
  std::ptrdiff_t begin_of_word_ = 0;
};

struct TextMatrix : StoredEntries {
  std::vector<int> extents;  // of block rows, from 0; sparse blocks only
};

void read_dense(Words& words, TextMatrix& matrix) {
  const int rows = words.integer("number of rows");
  const int columns = words.integer("number of columns");
  if (rows != matrix.rows || columns != matrix.columns) {
    words.fail(fmt::format("the dense matrix is {} x {}, its header says {} x {}", rows, columns,
                           matrix.rows, matrix.columns));
  }
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) {
      const double value = words.number("matrix entry");
      if (value != 0) matrix.entries.emplace_back(i, j, value);
    }
  }
}

/// Accumulated extents: increasing, with `total` as the last one.
std::vector<int> read_extents(Words& words, int count, int total) {
  std::vector<int> extents = {0};
  for (int k = 0; k < count; ++k) extents.push_back(words.integer("block extent"));
  if (!std::is_sorted(extents.begin(), extents.end()) || extents.back() != total) {
    words.fail(fmt::format("block extents do not increase to {}", total));
  }
  return extents;
}

void read_blocks(Words& words, TextMatrix& matrix) {
  const int blocks = words.integer("number of blocks");
  if (blocks == 0) return;
  const int block_rows = words.integer("number of block rows");
  const int block_columns = words.integer("number of block columns");
  words.require_plausible(double(block_rows) + block_columns, "block rows and columns");
  const std::vector<int> row_extents = read_extents(words, block_rows, matrix.rows);
  const std::vector<int> column_extents = read_extents(words, block_columns, matrix.columns);
  matrix.extents = row_extents;
  const int num_starts = words.integer("number of row starts", 1);
  const int num_columns = words.integer("number of block column indices");
  if (num_starts - 1 > block_rows || num_columns < blocks) {
    words.fail(fmt::format("{} row starts for {} block rows, {} indices for {} blocks", num_starts,
                           block_rows, num_columns, blocks));
  }
  words.require_plausible(num_columns, "blocks");
  std::vector<int> starts, columns;
  for (int k = 0; k < num_starts; ++k) starts.push_back(words.integer("row start"));
  for (int k = 0; k < num_columns; ++k) columns.push_back(words.integer("block column"));
  if (!std::is_sorted(starts.begin(), starts.end()) || starts.front() != 0 ||
      starts.back() != blocks) {
    words.fail(fmt::format("row starts do not increase from 0 to {}", blocks));
  }
  for (std::size_t row = 0; row + 1 < starts.size(); ++row) {
    for (int k = starts[row]; k < starts[row + 1]; ++k) {
      const int number = words.integer("block number");
      if (number != k) words.fail(fmt::format("block {} where {} should stand", number, k));
      const int block_column = columns[to_size(k)];
      if (block_column >= block_columns) {
        words.fail(fmt::format("block {} is in column {} of {}", k, block_column, block_columns));
      }
      const std::size_t column = to_size(block_column);
      for (int j = column_extents[column]; j < column_extents[column + 1]; ++j) {
        for (int i = row_extents[row]; i < row_extents[row + 1]; ++i) {
          const double value = words.number("block entry");
          if (value != 0) matrix.entries.emplace_back(i, j, value);
        }
      }
    }
  }
}

void add_checked(Words& words, TextMatrix& matrix, int row, int column, double value) {
  if (row >= matrix.rows || column >= matrix.columns) {
    words.fail(fmt::format("entry ({}, {}) of a {} x {} matrix", row, column, matrix.rows,
                           matrix.columns));
  }
  if (value != 0) matrix.entries.emplace_back(row, column, value);
}

/// The number after `name` in the header of a CSparse listing.
int header_count(Words& words, std::string_view header, std::string_view name) {
  const std::size_t found = header.find(name);
  if (found == std::string_view::npos) {
    words.fail(fmt::format("'{}' is missing in the header of the sparse matrix", name));
  }
  std::string_view rest = header.substr(found + name.size());
  rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
  int value = -1;
  std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (value < 0) words.fail(fmt::format("'{}' is not followed by a count", name));
  return value;
}

void read_sparse(Words& words, TextMatrix& matrix) {
  enum Origin { kTriplet = 1, kColumns = 2, kRows = 3, kHalfTriplet = 4 };
  const int origin = words.integer("origin of the sparse matrix");
  if (origin == kHalfTriplet) words.fail("half-stored symmetric matrices are not supported");
  words.line();
  words.line();  // name and version of CSparse
  const std::string_view header = words.line();
  const bool triplets = header.starts_with("triplet:");
  const bool by_rows = header.starts_with("csr:");
  std::string_view size = header.substr(triplets ? 8 : (by_rows ? 4 : 0));
  size.remove_prefix(std::min(size.find_first_not_of(' '), size.size()));
  const std::string expected = fmt::format("{}-by-{},", matrix.rows, matrix.columns);
  if (!size.starts_with(expected)) {
    words.fail(fmt::format("the sparse matrix should begin with '{}'", expected));
  }
  const int nonzeros = header_count(words, header, "nnz:");
  if (triplets) {
    for (int k = 0; k < nonzeros; ++k) {
      const int row = words.integer("row");
      const int column = words.integer("column");
      words.expect(":");
      add_checked(words, matrix, row, column, words.number("matrix entry"));
    }
    return;
  }
  const int lines = by_rows ? matrix.rows : matrix.columns;
  int read = 0;
  for (int k = 0; k < lines; ++k) {
    words.expect(by_rows ? "row" : "col");
    if (const int number = words.integer("line number"); number != k) {
      words.fail(fmt::format("line {} where {} should stand", number, k));
    }
    words.expect(":");
    words.expect("locations");
    const int first = words.integer("first location");
    words.expect("to");
    const int last = words.integer("last location", -1);
    if (first != read || last < first - 1) {
      words.fail(fmt::format("locations {} to {} after {} entries", first, last, read));
    }
    for (; read <= last; ++read) {
      const int other = words.integer("index");
      words.expect(":");
      const double value = words.number("matrix entry");
      add_checked(words, matrix, by_rows ? k : other, by_rows ? other : k, value);
    }
  }
  if (read != nonzeros) {
    words.fail(fmt::format("{} entries, the header says {}", read, nonzeros));
  }
}

TextMatrix read_matrix(Words& words) {
  enum Storage { kDense = 0, kSparseBlocks = 1, kSparse = 2 };
  const int storage = words.integer("storage of a matrix");
  TextMatrix matrix;
  matrix.rows = words.integer("number of rows");
  matrix.columns = words.integer("number of columns");
  // Vectors of these lengths follow.
  words.require_plausible(matrix.rows, "rows of a matrix");
  words.require_plausible(matrix.columns, "columns of a matrix");
  if (storage == kDense) {
    read_dense(words, matrix);
  } else if (storage == kSparseBlocks) {
    read_blocks(words, matrix);
  } else if (storage == kSparse) {
    read_sparse(words, matrix);
  } else {
    words.fail(
        fmt::format("matrix storage {} is not 0 (dense), 1 (blocks) or 2 (sparse)", storage));
  }
  return matrix;
}

Vector read_vector(Words& words, Eigen::Index size, std::string_view what) {
  words.require_plausible(static_cast<double>(size), what);
  Vector vector(size);
  for (double& value : vector) value = words.number(what);
  return vector;
}

constexpr int kStorages = 3;

/// True if the first two numbers begin a matrix n x n, storage, n, n: a general mechanical problem.
/// The numbers of a problem with friction are d, contacts, storage, rows, columns.
bool begins_mechanical(const Words& words, int first, int second) {
  const int third = words.next_two()[0];
  return first < kStorages && second > 0 && second == third && (first != 2 || third >= kStorages);
}

/// The rows of `of` in which contacts, or else equality rows, meet those of `with`. `place`: of each
/// row among its kind.
template <class Sparse>
Sparse part_of(const TextMatrix& of, const std::vector<int>& place, const std::vector<bool>& equal,
               bool rows_equal, bool columns_equal, Eigen::Index rows, Eigen::Index columns) {
  Triplets entries;
  for (const auto& entry : of.entries) {
    const std::size_t i = to_size(entry.row()), j = to_size(entry.col());
    if (equal[i] != rows_equal || equal[j] != columns_equal) continue;
    entries.emplace_back(place[i], place[j], entry.value());
  }
  return from_triplets<Sparse>(rows, columns, entries);
}

/// M, q, and for each block row of M the type of its sub-problem, with mu for a contact.
ProblemFile read_mechanical(const std::filesystem::path& path) {
  enum Type { kEquality = 2, kContactInSpace = 4 };
  Words words(path);
  const TextMatrix M = read_matrix(words);
  if (M.rows != M.columns) words.fail(fmt::format("the matrix is {} x {}", M.rows, M.columns));
  if (M.extents.empty()) {
    words.fail(
        "a general mechanical problem needs its matrix in blocks (storage 1), one for each "
        "sub-problem");
  }
  const Vector q = read_vector(words, M.rows, "q");
  std::vector<int> place;  // of each row among those of its kind
  std::vector<bool> equal;
  std::vector<double> mu;
  int equalities = 0;
  for (std::size_t k = 0; k + 1 < M.extents.size(); ++k) {
    const int type = words.integer("type of a sub-problem");
    const int size = M.extents[k + 1] - M.extents[k];
    if (type != kEquality && !(type == kContactInSpace && size == 3)) {
      words.fail(
          fmt::format("sub-problem {} is of type {} and size {}; taken are equality rows "
                      "(joints, type 2) and contacts in space (type 4, size 3)",
                      k, type, size));
    }
    const bool joint = type == kEquality;
    int next = joint ? equalities : 3 * static_cast<int>(mu.size());
    if (!joint) mu.push_back(words.number("mu"));
    for (int row = 0; row < size; ++row) {
      place.push_back(next++);
      equal.push_back(joint);
    }
    if (joint) equalities = next;
  }
  const Eigen::Index contacts = 3 * static_cast<Eigen::Index>(mu.size());
  Vector q_contacts(contacts), s(equalities);
  for (int row = 0; row < M.rows; ++row) {
    (equal[to_size(row)] ? s : q_contacts)[place[to_size(row)]] = q[row];
  }
  const auto part = [&]<class Sparse>(Sparse, bool rows, bool columns) {
    return part_of<Sparse>(M, place, equal, rows, columns, rows ? equalities : contacts,
                           columns ? equalities : contacts);
  };
  ProblemFile file;
  file.info.title = path.filename().string();
  file.info.description = "Siconos Numerics, GenericMechanicalProblem (text)";
  file.problem =
      from_local_form(3, part(SparseRows(), false, false), q_contacts,
                      Eigen::Map<const Vector>(mu.data(), static_cast<Eigen::Index>(mu.size())),
                      part(SparseRows(), false, true), part(SparseMatrix(), true, true), s);
  return file;
}

/// What a file is whose first two numbers begin no problem with friction; empty: it may be one.
std::string other_kind(const Words& words, int first, int second) {
  const auto [third, fourth] = words.next_two();
  // The size, then the matrix: n, storage, n, n.
  const bool no_storage = third >= kStorages;
  if (first > 0 && second < kStorages && third == first && fourth == first &&
      (no_storage || (first != 2 && first != 3))) {
    return fmt::format(
        "this is a linear complementarity problem (LCP) of {} rows; Bipot solves contact problems, "
        "which also have a dimension and a friction coefficient for each contact",
        first);
  }
  if (first == 2 || first == 3) return {};
  return fmt::format(
      "contact dimension {} is neither 2 nor 3 (rolling friction and other laws are not supported)",
      first);
}

}  // namespace

ProblemFile read_siconos_text(const std::filesystem::path& path) {
  Words words(path);
  const int dim = words.integer("contact dimension");
  const int contacts = words.integer("number of contacts");
  if (begins_mechanical(words, dim, contacts)) {
    try {
      return read_mechanical(path);
    } catch (const std::invalid_argument& e) {
      throw FileError(path, "", e.what());
    }
  }
  if (const std::string other = other_kind(words, dim, contacts); !other.empty()) {
    words.fail(other);
  }
  words.require_plausible(contacts, "contacts");
  const Eigen::Index rows = static_cast<Eigen::Index>(dim) * contacts;
  const TextMatrix first = read_matrix(words);

  ProblemFile file;
  file.info.title = path.filename().string();
  const std::size_t local_words = static_cast<std::size_t>(rows + contacts);
  const std::size_t left = words.left();
  try {
    if (left == local_words || left == local_words + 1) {
      file.info.description = "Siconos Numerics, FrictionContactProblem (text)";
      Vector q = read_vector(words, rows, "q");
      Vector mu = read_vector(words, contacts, "mu");
      file.problem = from_local_form(dim, first.build<SparseRows>(), std::move(q), std::move(mu));
    } else if (left < local_words) {
      throw std::invalid_argument(
          fmt::format("{} numbers after the matrix, q and mu have {}", left, local_words));
    } else {
      file.global = true;
      file.info.description = "Siconos Numerics, GlobalFrictionContactProblem (text)";
      const TextMatrix second = read_matrix(words);
      const Vector f = read_vector(words, first.rows, "f");
      const Vector w = read_vector(words, second.columns, "w");
      Vector mu = read_vector(words, contacts, "mu");
      if (words.left() > 1) {
        throw std::invalid_argument(fmt::format("{} words after the end", words.left()));
      }
      file.problem = from_global_form(dim, first.build<SparseMatrix>(),
                                      second.build<SparseMatrix>(), f, w, std::move(mu));
    }
  } catch (const std::invalid_argument& e) {
    throw FileError(path, "", e.what());
  }
  return file;
}

}  // namespace bipot
