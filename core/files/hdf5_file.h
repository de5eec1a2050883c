#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/file_error.h"

namespace bipot {

/// One open HDF5 file. Objects are named by absolute paths ("/a/b"); missing groups are created.
/// Datasets are contiguous, uncompressed, of native types and without time stamps: the same content
/// gives the same bytes. Every failure throws FileError with the file and the object's name; HDF5
/// prints nothing to the terminal. Only this class uses the HDF5 library. While a thread has a file
/// open, other threads wait to open one.
class Hdf5File {
 public:
  enum class Mode {
    kRead,
    kAppend,  ///< an existing file, to be changed
    kCreate   ///< a new file; one that exists is emptied
  };
  Hdf5File(std::filesystem::path path, Mode mode);
  ~Hdf5File();
  Hdf5File(Hdf5File&&) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;

  /// Writes all buffers and closes. Reports failures, which the destructor cannot.
  void close();

  const std::filesystem::path& path() const { return path_; }

  /// True if the file starts with the HDF5 signature, whatever its name. False if there is no file.
  static bool is_hdf5(const std::filesystem::path& path);

  /// Refuses an HDF5 file before its data are read: links to other files, storage outside of the
  /// file, datasets larger than their storage. Other files pass. The library reads all headers for
  /// it; damage that the library itself does not notice can still end the program.
  static void check_structure(const std::filesystem::path& path);

  bool exists(const std::string& name) const;
  /// Number of elements of a dataset.
  std::size_t size(const std::string& name) const;
  /// Extents of a dataset; empty for a scalar.
  std::vector<std::size_t> shape(const std::string& name) const;
  /// Names in a group, sorted.
  std::vector<std::string> list(const std::string& group) const;

  /// Datasets. A scalar may be stored with any rank, but has one element.
  int read_int(const std::string& name) const;
  double read_double(const std::string& name) const;
  std::vector<int> read_ints(const std::string& name) const;
  /// All elements, last index fastest.
  std::vector<double> read_doubles(const std::string& name) const;
  /// As many as given: throws FileError otherwise.
  std::vector<int> read_ints(const std::string& name, std::size_t size) const {
    return sized(read_ints(name), name, size);
  }
  std::vector<double> read_doubles(const std::string& name, std::size_t size) const {
    return sized(read_doubles(name), name, size);
  }
  std::string read_string(const std::string& name) const;
  std::vector<std::string> read_strings(const std::string& name) const;

  /// Replaces an earlier dataset. A scalar is written as an array of one element, as in FCLIB.
  /// `unit`: text of its attribute `unit`; empty: it has none.
  void write(const std::string& name, int value);
  void write(const std::string& name, double value, std::string_view unit = {});
  void write(const std::string& name, std::string_view value);
  void write(const std::string& name, std::span<const int> values);
  void write(const std::string& name, std::span<const double> values, std::string_view unit = {});
  void write(const std::string& name, std::span<const std::string> values);
  /// rows x columns, row by row.
  void write_rows(const std::string& name, std::span<const double> values, std::size_t columns,
                  std::string_view unit = {});

  void create_group(const std::string& name);
  void remove(const std::string& name);
  void rename(const std::string& name, const std::string& to);
  /// Creates a link `name` to `target` in another file; a relative `file` is looked up beside this
  /// file.
  void link(const std::string& name, const std::filesystem::path& file, const std::string& target);

  bool has_attribute(const std::string& object, const std::string& name) const;
  /// Text attribute of an object, e.g. a unit.
  void write_attribute(const std::string& object, const std::string& name, std::string_view value);

 private:
  template <class Values>
  Values sized(Values values, const std::string& name, std::size_t size) const {
    if (values.size() == size) return values;
    throw FileError(path_, name,
                    "has " + std::to_string(values.size()) + " elements, expected " +
                        (size == 1 ? "one" : std::to_string(size)));
  }
  void write_array(const std::string& name, std::int64_t type, const void* data,
                   std::span<const std::size_t> extents);
  std::int64_t open_dataset(const std::string& name) const;
  std::size_t plausible_size(const std::string& name) const;

  std::filesystem::path path_;
  std::unique_lock<std::recursive_mutex> turn_;  // at the library, while the file is open
  std::int64_t file_ = -1;                       // hid_t, kept out of this header
};

}  // namespace bipot
