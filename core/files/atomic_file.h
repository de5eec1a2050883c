#pragma once

#include <filesystem>
#include <string_view>

namespace bipot {

/// A file that appears under its name whole or not at all, whenever the program dies. It is written
/// under another name in the same folder, and commit() renames it in one step. Until then an
/// earlier file of that name remains. A link stays, and what it names is written. A pipe, a device
/// or an open file of that name (/dev/stdout) is written to directly, once a pipe has a reader.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  /// Removes the draft unless commit() was called.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Path to write to.
  const std::filesystem::path& draft() const { return draft_; }
  /// Begins with a copy of the earlier file, to be added to. Throws FileError.
  void copy_earlier();
  /// Throws FileError.
  void commit();

 private:
  std::filesystem::path path_, draft_;
  int pipe_ = -1;  ///< open as long as this lives
};

/// The whole text as a file. Throws FileError with the system's reason.
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace bipot
