#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

namespace bipot {

/// Message for one process, or from one, of any length.
using Buffer = std::vector<double>;

/// Appends numbers, enumerators and the components of vectors.
template <class... Values>
void append(Buffer& buffer, const Values&... values) {
  const auto add = [&](const auto& x) {
    if constexpr (requires { x.data(); }) {
      buffer.insert(buffer.end(), x.data(), x.data() + x.size());
    } else {
      buffer.push_back(static_cast<double>(x));
    }
  };
  (add(values), ...);
}

/// Reads the numbers of a buffer in sequence. Throws std::out_of_range past the end.
class BufferReader {
 public:
  explicit BufferReader(const Buffer& buffer) : buffer_(buffer) {}
  bool at_end() const { return next_ == buffer_.size(); }
  double number() { return buffer_.at(next_++); }
  int integer() { return static_cast<int>(number()); }
  /// Sets what append() took.
  template <class... Values>
  void take(Values&... values) {
    const auto set = [&](auto& x) {
      if constexpr (requires { x.data(); }) {
        for (auto* of = x.data(); of != x.data() + x.size(); ++of) *of = number();
      } else {
        x = static_cast<std::remove_reference_t<decltype(x)>>(number());
      }
    };
    (set(values), ...);
  }

 private:
  const Buffer& buffer_;
  std::size_t next_ = 0;
};

}  // namespace bipot
