#pragma once

#include <vector>

#include "core/motion/state.h"
#include "solvers/parallel/process_group.h"

namespace bipot {

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
