#pragma once

#include <vector>

#include "core/motion/state.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

/// Reads the numbers of a buffer in sequence. Throws std::out_of_range past the end.
class BufferReader {
 public:
  explicit BufferReader(const Buffer& buffer) : buffer_(buffer) {}
  bool at_end() const { return next_ == buffer_.size(); }
  double number() { return buffer_.at(next_++); }
  int integer() { return static_cast<int>(number()); }
  template <int N>
  Eigen::Matrix<double, N, 1> vector() {
    Eigen::Matrix<double, N, 1> x;
    for (int k = 0; k < N; ++k) x[k] = number();
    return x;
  }

 private:
  const Buffer& buffer_;
  std::size_t next_ = 0;
};

/// A body and its number in the whole.
template <int D>
struct NumberedBody {
  int number = -1;
  Body<D> body;
};

/// Appends all data of a body, without clusters.
template <int D>
void put(int number, const Body<D>& body, Buffer& buffer);
template <int D>
NumberedBody<D> take_body(BufferReader& buffer);

/// Appends all results of a nonsmooth step at a contact outside a periodic cell.
template <int D>
void put(const ContactOutcome<D>& contact, Buffer& buffer);
template <int D>
ContactOutcome<D> take_contact(BufferReader& buffer);

/// Sorts by i, then by j.
template <int D>
void sort_by_bodies(std::vector<ContactOutcome<D>>& contacts);

}  // namespace bipot
