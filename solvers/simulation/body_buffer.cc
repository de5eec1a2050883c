#include "solvers/simulation/body_buffer.h"

#include <algorithm>

namespace bipot {
namespace {

/// Passes all data of a body, without clusters, in their order in a buffer.
template <class AnyBody, class Pass>
void pass_body(AnyBody& b, const Pass& pass) {
  pass(b.x);
  if constexpr (requires { b.angle; }) {
    pass(b.angle);
  } else {
    pass(b.orientation.coeffs());
  }
  pass(b.v, b.spin, b.radius, b.mass, b.inertia, b.material, b.wall);
}

/// The same for a contact.
template <class Outcome, class Pass>
void pass_contact(Outcome& c, const Pass& pass) {
  pass(c.contact.i, c.contact.j, c.contact.n, c.contact.gap, c.s_n, c.s_t, c.u_n, c.u_t, c.status);
}

auto appending(Buffer& buffer) {
  return [&buffer](const auto&... values) { append(buffer, values...); };
}
auto taking(BufferReader& buffer) {
  return [&buffer](auto&... values) { buffer.take(values...); };
}

}  // namespace

template <int D>
void put(int number, const Body<D>& body, Buffer& buffer) {
  buffer.push_back(number);
  pass_body(body, appending(buffer));
}

template <int D>
NumberedBody<D> take_body(BufferReader& buffer) {
  NumberedBody<D> out;
  out.number = buffer.integer();
  pass_body(out.body, taking(buffer));
  return out;
}

template <int D>
void put(const ContactOutcome<D>& contact, Buffer& buffer) {
  pass_contact(contact, appending(buffer));
}

template <int D>
ContactOutcome<D> take_contact(BufferReader& buffer) {
  ContactOutcome<D> contact;
  pass_contact(contact, taking(buffer));
  return contact;
}

template <int D>
void sort_by_bodies(std::vector<ContactOutcome<D>>& contacts) {
  std::sort(contacts.begin(), contacts.end(),
            [](const ContactOutcome<D>& a, const ContactOutcome<D>& b) {
              return a.contact.pair() < b.contact.pair();
            });
}

template void put<2>(int, const Disk&, Buffer&);
template void put<3>(int, const Sphere&, Buffer&);
template NumberedBody<2> take_body(BufferReader&);
template NumberedBody<3> take_body(BufferReader&);
template void put<2>(const ContactOutcome<2>&, Buffer&);
template void put<3>(const ContactOutcome<3>&, Buffer&);
template ContactOutcome<2> take_contact<2>(BufferReader&);
template ContactOutcome<3> take_contact<3>(BufferReader&);
template void sort_by_bodies<2>(std::vector<ContactOutcome<2>>&);
template void sort_by_bodies<3>(std::vector<ContactOutcome<3>>&);

}  // namespace bipot
