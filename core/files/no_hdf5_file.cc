// In place of hdf5_file.cc where the program is built without HDF5: no file can be opened, so that
// nothing but the constructor is ever called.
#include <utility>

#include "core/files/hdf5_file.h"

namespace bipot {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& path) {
  throw FileError(path, "", "this program was built without HDF5 (-DBIPOT_WITH_HDF5=OFF)");
}

}  // namespace

Hdf5File::Hdf5File(std::filesystem::path path, Mode) : path_(std::move(path)) { refuse(path_); }
Hdf5File::~Hdf5File() = default;
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
void Hdf5File::close() { refuse(path_); }
void Hdf5File::check_structure(const std::filesystem::path& path) {
  if (is_hdf5(path)) refuse(path);
}
bool Hdf5File::exists(const std::string&) const { refuse(path_); }
std::size_t Hdf5File::size(const std::string&) const { refuse(path_); }
std::vector<std::size_t> Hdf5File::shape(const std::string&) const { refuse(path_); }
std::vector<std::string> Hdf5File::list(const std::string&) const { refuse(path_); }
int Hdf5File::read_int(const std::string&) const { refuse(path_); }
double Hdf5File::read_double(const std::string&) const { refuse(path_); }
std::vector<int> Hdf5File::read_ints(const std::string&) const { refuse(path_); }
std::vector<double> Hdf5File::read_doubles(const std::string&) const { refuse(path_); }
std::string Hdf5File::read_string(const std::string&) const { refuse(path_); }
std::vector<std::string> Hdf5File::read_strings(const std::string&) const { refuse(path_); }
void Hdf5File::write(const std::string&, int) { refuse(path_); }
void Hdf5File::write(const std::string&, double, std::string_view) { refuse(path_); }
void Hdf5File::write(const std::string&, std::string_view) { refuse(path_); }
void Hdf5File::write(const std::string&, std::span<const int>) { refuse(path_); }
void Hdf5File::write(const std::string&, std::span<const double>, std::string_view) {
  refuse(path_);
}
void Hdf5File::write(const std::string&, std::span<const std::string>) { refuse(path_); }
void Hdf5File::write_rows(const std::string&, std::span<const double>, std::size_t,
                          std::string_view) {
  refuse(path_);
}
void Hdf5File::create_group(const std::string&) { refuse(path_); }
void Hdf5File::remove(const std::string&) { refuse(path_); }
void Hdf5File::rename(const std::string&, const std::string&) { refuse(path_); }
void Hdf5File::link(const std::string&, const std::filesystem::path&, const std::string&) {
  refuse(path_);
}
bool Hdf5File::has_attribute(const std::string&, const std::string&) const { refuse(path_); }
void Hdf5File::write_attribute(const std::string&, const std::string&, std::string_view) {
  refuse(path_);
}

}  // namespace bipot
