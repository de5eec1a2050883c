#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/file_error.h"

namespace bipot {

/// The turn of a thread to use the HDF5 library, which serves one at a time: a thread that has one
/// may take more, another waits until it has given back all. It is given back by the thread that took
/// it.
class Hdf5Turn {
 public:
  Hdf5Turn();
  ~Hdf5Turn();
  Hdf5Turn(Hdf5Turn&& other) noexcept : taken_(other.taken_) { other.taken_ = false; }
  Hdf5Turn& operator=(Hdf5Turn&&) = delete;

 private:
  bool taken_ = true;
};

/// One open HDF5 file. Objects are named by absolute paths ("/a/b"); groups on the way are created.
/// Datasets are contiguous, uncompressed, native types, without time stamps: the same content gives
/// the same bytes. Every failure throws FileError with the file and the object's name; HDF5's own
/// messages are kept off the terminal. The only user of the HDF5 library; while a thread has a file
/// open, other threads that want to open one wait.
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

  /// Writes what is still in memory and closes; throws where the destructor could only be silent.
  void close();

  const std::filesystem::path& path() const { return path_; }

  /// True when the file starts with the HDF5 signature, whatever its name. False for no file.
  static bool is_hdf5(const std::filesystem::path& path);

  /// Ends the library: every block that it keeps for later goes back to the heap, which notices what
  /// was written beyond one. No file may be open, and none can be opened after it.
  static void end_library();

  bool exists(const std::string& name) const;
  /// Number of elements of a dataset.
  std::size_t size(const std::string& name) const;
  /// Extents of a dataset; empty for a scalar.
  std::vector<std::size_t> shape(const std::string& name) const;
  /// Names in a group, sorted.
  std::vector<std::string> list(const std::string& group) const;

  /// Datasets. A scalar may be stored with any rank, but with one element.
  int read_int(const std::string& name) const;
  double read_double(const std::string& name) const;
  std::vector<int> read_ints(const std::string& name) const;
  /// All elements, last index fastest.
  std::vector<double> read_doubles(const std::string& name) const;
  std::string read_string(const std::string& name) const;
  std::vector<std::string> read_strings(const std::string& name) const;

  /// Replaces what was there. A scalar is written as an array of one element, as FCLIB does.
  void write(const std::string& name, int value);
  void write(const std::string& name, double value);
  void write(const std::string& name, std::string_view value);
  void write(const std::string& name, std::span<const int> values);
  void write(const std::string& name, std::span<const double> values);
  void write(const std::string& name, std::span<const std::string> values);
  /// rows x columns, row by row.
  void write_rows(const std::string& name, std::span<const double> values, std::size_t columns);

  void create_group(const std::string& name);
  void remove(const std::string& name);
  /// A name here that stands for `target` in another file; a relative `file` is looked up beside
  /// this file.
  void link(const std::string& name, const std::filesystem::path& file, const std::string& target);

  /// Text attribute of an object, e.g. a unit.
  void write_attribute(const std::string& object, const std::string& name, std::string_view value);

 private:
  void write_array(const std::string& name, std::int64_t type, const void* data,
                   std::span<const std::size_t> extents);
  std::int64_t open_dataset(const std::string& name) const;
  std::size_t plausible_size(const std::string& name) const;

  std::filesystem::path path_;
  std::optional<Hdf5Turn> turn_;  // while the file is open
  std::int64_t file_ = -1;        // hid_t, kept out of this header
};

}  // namespace bipot
