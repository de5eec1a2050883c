#include "core/files/atomic_file.h"

#include <fstream>
#include <system_error>
#include <utility>

#include "core/base/file_error.h"

namespace bipot {

AtomicFile::AtomicFile(std::filesystem::path path) : path_(std::move(path)), draft_(path_) {
  draft_ += ".part";
}

AtomicFile::~AtomicFile() {
  std::error_code ignored;  // nothing to remove after commit()
  std::filesystem::remove(draft_, ignored);
}

void AtomicFile::commit() {
  std::error_code error;
  std::filesystem::rename(draft_, path_, error);
  if (error) throw FileError(path_, "", "cannot write: " + error.message());
}

void write_text_file(const std::filesystem::path& path, std::string_view text) {
  AtomicFile file(path);
  std::ofstream out(file.draft(), std::ios::binary);
  out << text;
  out.close();
  if (!out) throw FileError(path, "", "cannot be written");
  file.commit();
}

}  // namespace bipot
