#pragma once

#include <filesystem>
#include <string_view>

namespace bipot {

/// A file that appears under its name whole or not at all, whenever the program dies: it is written
/// under another name in the same folder, which commit() changes in one step. A file of that name
/// that was there before stays until then.
class AtomicFile {
 public:
  explicit AtomicFile(std::filesystem::path path);
  /// Without commit(): removes what was written.
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  /// Where to write.
  const std::filesystem::path& draft() const { return draft_; }
  /// Throws FileError.
  void commit();

 private:
  std::filesystem::path path_, draft_;
};

/// The whole text as a file. Throws FileError.
void write_text_file(const std::filesystem::path& path, std::string_view text);

}  // namespace bipot
