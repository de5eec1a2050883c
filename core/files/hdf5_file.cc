#include "core/files/hdf5_file.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/files/input_file.h"

namespace bipot {
namespace {

static_assert(sizeof(hid_t) == sizeof(std::int64_t));

/// A turn at the library, which serves one thread at a time.
std::unique_lock<std::recursive_mutex> take_turn() {
  static std::recursive_mutex library;
  std::unique_lock<std::recursive_mutex> turn(library);
  // Files are closed here. After a failed close (a full disk) the library's own exit handler
  // crashes.
  [[maybe_unused]] static const herr_t no_end = H5dont_atexit();
  return turn;
}

/// Switches HDF5's printing of its error stack off for the time of one call.
class Silence {
 public:
  Silence() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() {
    // If a thread ends with errors on its stack, the library cannot close them.
    H5Eclear2(H5E_DEFAULT);
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
  }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Owns one identifier.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// The innermost message of HDF5's error stack, or what the operating system says in it.
std::string hdf5_reason() {
  std::string reason;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_DOWNWARD,
      [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
        if (error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
        return 0;
      },
      &reason);
  constexpr std::string_view kSystem = "error message = '";
  if (const std::size_t at = reason.find(kSystem); at != std::string::npos) {
    reason.erase(0, at + kSystem.size());
    reason.erase(std::min(reason.find('\''), reason.size()));
  }
  return reason.empty() ? "unknown HDF5 error" : reason;
}

bool link_exists(hid_t file, const std::string& name) {
  if (name == "/") return true;
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    if (H5Lexists(file, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) break;
  }
  return H5Oexists_by_name(file, name.c_str(), H5P_DEFAULT) > 0;  // the target of a link, too
}

/// The type of texts of `size` bytes, their end included.
class TextType : public Handle {
 public:
  explicit TextType(std::size_t size) : Handle(H5Tcopy(H5T_C_S1), H5Tclose) {
    H5Tset_size(*this, size);
  }
};

/// Properties of new links: missing groups above them are made.
class WithGroups : public Handle {
 public:
  WithGroups() : Handle(H5Pcreate(H5P_LINK_CREATE), H5Pclose) {
    H5Pset_create_intermediate_group(*this, 1);
  }
};

}  // namespace

Hdf5File::Hdf5File(std::filesystem::path path, Mode mode)
    : path_(std::move(path)), turn_(take_turn()) {
  const Silence silence;
  if (mode != Mode::kCreate) {
    require_regular_file(path_);
    if (!is_hdf5(path_)) throw FileError(path_, "", "not an HDF5 file");
    file_ =
        H5Fopen(path_.c_str(), mode == Mode::kRead ? H5F_ACC_RDONLY : H5F_ACC_RDWR, H5P_DEFAULT);
  } else {
    file_ = H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  }
  if (file_ < 0) throw FileError(path_, "", "cannot open: " + hdf5_reason());
}

Hdf5File::~Hdf5File() {
  const Silence silence;
  if (file_ >= 0) H5Fclose(file_);
}

Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : path_(std::move(other.path_)),
      turn_(std::move(other.turn_)),
      file_(std::exchange(other.file_, -1)) {}

void Hdf5File::close() {
  const Silence silence;
  if (file_ < 0) return;
  const bool flushed = H5Fflush(file_, H5F_SCOPE_LOCAL) >= 0;
  const std::string reason = flushed ? "" : hdf5_reason();  // closing would hide it
  const bool closed = H5Fclose(std::exchange(file_, -1)) >= 0;
  const auto turn = std::move(turn_);  // until the reason is read
  if (!flushed || !closed) {
    throw FileError(path_, "", "cannot write: " + (flushed ? hdf5_reason() : reason));
  }
}

bool Hdf5File::exists(const std::string& name) const {
  const Silence silence;
  return link_exists(file_, name);
}

std::int64_t Hdf5File::open_dataset(const std::string& name) const {
  if (!link_exists(file_, name)) throw FileError(path_, name, "missing");
  const hid_t dataset = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
  if (dataset < 0) throw FileError(path_, name, "not a dataset");
  return dataset;
}

std::vector<std::size_t> Hdf5File::shape(const std::string& name) const {
  const Silence silence;
  const Handle dataset(open_dataset(name), H5Dclose);
  const Handle space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (rank < 0) throw FileError(path_, name, "has no simple extents");
  std::vector<hsize_t> extents(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, extents.data(), nullptr);
  return {extents.begin(), extents.end()};
}

std::size_t Hdf5File::size(const std::string& name) const {
  std::size_t product = 1;
  for (std::size_t extent : shape(name)) product *= extent;
  return product;
}

std::vector<std::string> Hdf5File::list(const std::string& group) const {
  const Silence silence;
  if (!link_exists(file_, group)) throw FileError(path_, group, "missing");
  const Handle id(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose);
  if (!id.ok()) throw FileError(path_, group, "not a group");
  std::vector<std::string> names;
  H5Literate(
      id, H5_INDEX_NAME, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
        static_cast<std::vector<std::string>*>(out)->emplace_back(name);
        return 0;
      },
      &names);
  std::sort(names.begin(), names.end());
  return names;
}

/// The number of elements. Refused, before memory is allocated, if the file cannot hold so many: no
/// filter of HDF5 packs a number into less than a thousandth of a byte of the file.
std::size_t Hdf5File::plausible_size(const std::string& name) const {
  constexpr double kPacked = 1100;  // deflate, at best 1032 to 1
  const std::vector<std::size_t> extents = shape(name);
  double product = 1;
  for (const std::size_t extent : extents) product *= static_cast<double>(extent);
  hsize_t bytes = 0;
  if (H5Fget_filesize(file_, &bytes) < 0) throw FileError(path_, name, "has no size");
  if (product > kPacked * static_cast<double>(bytes)) {
    throw FileError(
        path_, name,
        fmt::format("claims {:.6g} values, more than a file of {} bytes can hold", product, bytes));
  }
  return size(name);
}

namespace {

// Bytes of a number: a damaged file can claim any size.
constexpr std::size_t kWidestType = 16;
constexpr double kMostText = 1e8;  // bytes

/// Of a dataset that is read.
void require_filters(const std::filesystem::path& path, const std::string& name, hid_t dataset) {
  const Handle made(H5Dget_create_plist(dataset), H5Pclose);
  for (int k = 0; k < H5Pget_nfilters(made); ++k) {
    char filter[64] = "";
    std::size_t values = 0;
    const H5Z_filter_t id = H5Pget_filter2(made, static_cast<unsigned>(k), nullptr, &values,
                                           nullptr, sizeof filter, filter, nullptr);
    if (H5Zfilter_avail(id) <= 0) {
      throw FileError(path, name,
                      fmt::format("is packed by the filter {} '{}', which is not installed here; "
                                  "gzip can be read",
                                  id, filter));
    }
  }
}

/// Numbers of an open dataset, all of it; `native`: their type in memory.
template <class Number>
void read_numbers(const std::filesystem::path& path, const std::string& name, hid_t dataset,
                  hid_t native, std::vector<Number>& values) {
  const Handle type(H5Dget_type(dataset), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type);
  const bool whole = std::is_integral_v<Number>;
  if (kind != H5T_INTEGER && (whole || kind != H5T_FLOAT)) {
    throw FileError(path, name, whole ? "not integers" : "not numbers");
  }
  if (const std::size_t width = H5Tget_size(type); width > kWidestType) {
    throw FileError(path, name, fmt::format("numbers of {} bytes", width));
  }
  if (values.empty()) return;
  require_filters(path, name, dataset);
  if (H5Dread(dataset, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
    throw FileError(path, name, "cannot read: " + hdf5_reason());
  }
}

}  // namespace

void Hdf5File::check_structure(const std::filesystem::path& path) {
  if (!is_hdf5(path)) return;
  const Hdf5File file(path, Mode::kRead);
  const Silence silence;
  std::vector<std::string> datasets;
  std::string foreign;
  const auto note_link = [](hid_t, const char* name, const H5L_info_t* link, void* out) -> herr_t {
    if (link->type == H5L_TYPE_HARD || link->type == H5L_TYPE_SOFT) return 0;
    *static_cast<std::string*>(out) = name;
    return 1;
  };
  const auto note_dataset = [](hid_t, const char* name, const H5O_info_t* object,
                               void* out) -> herr_t {
    if (object->type == H5O_TYPE_DATASET) {
      static_cast<std::vector<std::string>*>(out)->push_back(std::string("/") + name);
    }
    return 0;
  };
  if (H5Lvisit(file.file_, H5_INDEX_NAME, H5_ITER_INC, note_link, &foreign) < 0 ||
      H5Ovisit(file.file_, H5_INDEX_NAME, H5_ITER_INC, note_dataset, &datasets) < 0) {
    throw FileError(path, "", "damaged: " + hdf5_reason());
  }
  if (!foreign.empty())
    throw FileError(path, "/" + foreign, "a link to another file is not followed");
  hsize_t bytes = 0;
  H5Fget_filesize(file.file_, &bytes);
  for (const std::string& name : datasets) {
    const std::size_t count = file.plausible_size(name);
    const Handle dataset(H5Dopen2(file.file_, name.c_str(), H5P_DEFAULT), H5Dclose);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const Handle made(H5Dget_create_plist(dataset), H5Pclose);
    const H5D_layout_t layout = H5Pget_layout(made);
    const hsize_t stored = H5Dget_storage_size(dataset), needed = count * H5Tget_size(type);
    if (layout == H5D_CHUNKED) continue;
    if ((layout != H5D_CONTIGUOUS && layout != H5D_COMPACT) || H5Pget_external_count(made) != 0) {
      throw FileError(path, name, "is not stored in the file");
    }
    // Nothing is stored of what nobody has written.
    if (stored != 0 && (stored < needed || stored > bytes)) {
      throw FileError(path, name, fmt::format("claims {} bytes and stores {}", needed, stored));
    }
  }
}

std::vector<double> Hdf5File::read_doubles(const std::string& name) const {
  std::vector<double> values(plausible_size(name));
  const Silence silence;
  const Handle dataset(open_dataset(name), H5Dclose);
  read_numbers(path_, name, dataset, H5T_NATIVE_DOUBLE, values);
  return values;
}

std::vector<int> Hdf5File::read_ints(const std::string& name) const {
  std::vector<std::int64_t> wide(plausible_size(name));
  const Silence silence;
  const Handle dataset(open_dataset(name), H5Dclose);
  read_numbers(path_, name, dataset, H5T_NATIVE_INT64, wide);
  std::vector<int> values;
  values.reserve(wide.size());
  for (std::size_t k = 0; k < wide.size(); ++k) {
    if (wide[k] < std::numeric_limits<int>::min() || wide[k] > std::numeric_limits<int>::max()) {
      throw FileError(path_, name, fmt::format("element {} = {} does not fit an int", k, wide[k]));
    }
    values.push_back(static_cast<int>(wide[k]));
  }
  return values;
}

int Hdf5File::read_int(const std::string& name) const { return read_ints(name, 1)[0]; }

double Hdf5File::read_double(const std::string& name) const { return read_doubles(name, 1)[0]; }

std::vector<std::string> Hdf5File::read_strings(const std::string& name) const {
  const std::size_t count = size(name);
  const Silence silence;
  const Handle dataset(open_dataset(name), H5Dclose);
  const Handle type(H5Dget_type(dataset), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING) throw FileError(path_, name, "not text");
  if (count == 0) return {};
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> texts(count, nullptr);
    const Handle space(H5Dget_space(dataset), H5Sclose);
    if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, texts.data()) < 0) {
      throw FileError(path_, name, "cannot read: " + hdf5_reason());
    }
    std::vector<std::string> result;
    for (const char* text : texts) result.emplace_back(text == nullptr ? "" : text);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts.data());
    return result;
  }
  const std::size_t width = H5Tget_size(type);
  if (static_cast<double>(count) * static_cast<double>(width) > kMostText) {
    throw FileError(path_, name, fmt::format("{} texts of {} bytes: too long", count, width));
  }
  std::vector<char> bytes(count * width);
  if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) {
    throw FileError(path_, name, "cannot read: " + hdf5_reason());
  }
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < bytes.size(); at += width) {
    std::string& text = texts.emplace_back(bytes.data() + at, width);
    text.resize(std::min(text.size(), text.find('\0')));
  }
  return texts;
}

std::string Hdf5File::read_string(const std::string& name) const {
  std::vector<std::string> texts = read_strings(name);
  if (texts.size() != 1) {
    throw FileError(path_, name, fmt::format("has {} elements, expected one", texts.size()));
  }
  return std::move(texts[0]);
}

void Hdf5File::write_array(const std::string& name, std::int64_t type, const void* data,
                           std::span<const std::size_t> extents) {
  if (link_exists(file_, name)) remove(name);
  const Silence silence;
  std::vector<hsize_t> dims(extents.begin(), extents.end());
  const bool empty = std::find(dims.begin(), dims.end(), hsize_t{0}) != dims.end();
  const Handle space(dims.empty()
                         ? H5Screate(H5S_SCALAR)
                         : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr),
                     H5Sclose);
  const WithGroups links;
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  const Handle dataset(H5Dcreate2(file_, name.c_str(), type, space, links, properties, H5P_DEFAULT),
                       H5Dclose);
  if (!dataset.ok()) throw FileError(path_, name, "cannot create: " + hdf5_reason());
  if (!empty && H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
    throw FileError(path_, name, "cannot write: " + hdf5_reason());
  }
}

void Hdf5File::write(const std::string& name, int value) { write(name, std::span(&value, 1)); }

void Hdf5File::write(const std::string& name, double value, std::string_view unit) {
  write(name, std::span<const double>(&value, 1), unit);
}

void Hdf5File::write(const std::string& name, std::span<const int> values) {
  write_array(name, H5T_NATIVE_INT, values.data(), std::array{values.size()});
}

void Hdf5File::write(const std::string& name, std::span<const double> values,
                     std::string_view unit) {
  write_array(name, H5T_NATIVE_DOUBLE, values.data(), std::array{values.size()});
  if (!unit.empty()) write_attribute(name, "unit", unit);
}

void Hdf5File::write_rows(const std::string& name, std::span<const double> values,
                          std::size_t columns, std::string_view unit) {
  write_array(name, H5T_NATIVE_DOUBLE, values.data(), std::array{values.size() / columns, columns});
  if (!unit.empty()) write_attribute(name, "unit", unit);
}

void Hdf5File::write(const std::string& name, std::string_view value) {
  const Silence silence;
  const TextType type(value.size() + 1);
  const std::string terminated(value);
  write_array(name, type, terminated.c_str(), {});
}

void Hdf5File::write(const std::string& name, std::span<const std::string> values) {
  const Silence silence;
  std::size_t width = 1;
  for (const std::string& value : values) width = std::max(width, value.size() + 1);
  std::string bytes;
  for (const std::string& value : values) {
    bytes += value;
    bytes.append(width - value.size(), '\0');
  }
  write_array(name, TextType(width), bytes.data(), std::array{values.size()});
}

void Hdf5File::create_group(const std::string& name) {
  const Silence silence;
  if (link_exists(file_, name)) return;
  const WithGroups links;
  const Handle group(H5Gcreate2(file_, name.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  if (!group.ok()) throw FileError(path_, name, "cannot create: " + hdf5_reason());
}

void Hdf5File::remove(const std::string& name) {
  const Silence silence;
  if (H5Ldelete(file_, name.c_str(), H5P_DEFAULT) < 0) {
    throw FileError(path_, name, "cannot remove: " + hdf5_reason());
  }
}

void Hdf5File::rename(const std::string& name, const std::string& to) {
  const Silence silence;
  if (H5Lmove(file_, name.c_str(), file_, to.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) {
    throw FileError(path_, name, "cannot rename: " + hdf5_reason());
  }
}

void Hdf5File::link(const std::string& name, const std::filesystem::path& file,
                    const std::string& target) {
  const Silence silence;
  const WithGroups links;
  if (H5Lcreate_external(file.c_str(), target.c_str(), file_, name.c_str(), links, H5P_DEFAULT) <
      0) {
    throw FileError(path_, name, "cannot link: " + hdf5_reason());
  }
}

bool Hdf5File::has_attribute(const std::string& object, const std::string& name) const {
  const Silence silence;
  return link_exists(file_, object) &&
         H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

void Hdf5File::write_attribute(const std::string& object, const std::string& name,
                               std::string_view value) {
  const Silence silence;
  if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0) {
    H5Adelete_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT);
  }
  const TextType type(value.size() + 1);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space,
                                           H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  const std::string terminated(value);
  if (!attribute.ok() || H5Awrite(attribute, type, terminated.c_str()) < 0) {
    throw FileError(path_, object + "@" + name, "cannot write: " + hdf5_reason());
  }
}

}  // namespace bipot
