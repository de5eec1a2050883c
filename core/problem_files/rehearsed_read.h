#pragma once

#include <filesystem>
#include <functional>
#include <utility>

namespace bipot {

/// Calls read() in a child process and waits for its end. FileError when a signal or an abort ended
/// the child; exceptions are not its business. Where the system gives no child, nothing is done.
void rehearse(const std::filesystem::path& path, const std::function<void()>& read);

/// read(), after it has been rehearsed: the HDF5 library trusts the lengths inside a file, and a
/// damaged one can make it write where it must not. Then only the child is lost, and the file is
/// refused like any other that cannot be read. Costs a fork and a second reading.
template <class Read>
auto rehearsed_read(const std::filesystem::path& path, Read&& read) {
  rehearse(path, [&read] { read(); });
  return read();
}

}  // namespace bipot
