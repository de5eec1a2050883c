#pragma once

#include <functional>
#include <string>

namespace bipot {

/// The way from long work to the one who waits for it. Both functions may be empty.
struct Watch {
  std::function<bool()> interrupted;  ///< polled between pieces of work and inside solves
  std::function<void(long done, long total, const std::string& what)> progress;

  bool stopped() const { return interrupted && interrupted(); }
  void tell(long done, long total, const std::string& what) const {
    if (progress) progress(done, total, what);
  }
};

}  // namespace bipot
