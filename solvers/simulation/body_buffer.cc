#include "solvers/simulation/body_buffer.h"

#include <algorithm>
#include <tuple>

namespace bipot {
namespace {

void put_vector(const Eigen::Ref<const Vector>& x, Buffer& buffer) {
  buffer.insert(buffer.end(), x.data(), x.data() + x.size());
}

void put_turn(double x, Buffer& buffer) { buffer.push_back(x); }
void put_turn(const Vec3& x, Buffer& buffer) { put_vector(x, buffer); }

void take_turn(BufferReader& buffer, double& x) { x = buffer.number(); }
void take_turn(BufferReader& buffer, Vec3& x) { x = buffer.vector<3>(); }

void put_orientation(const Disk& d, Buffer& buffer) { buffer.push_back(d.angle); }
void put_orientation(const Sphere& s, Buffer& buffer) {
  put_vector(s.orientation.coeffs(), buffer);
}
void take_orientation(BufferReader& buffer, Disk& d) { d.angle = buffer.number(); }
void take_orientation(BufferReader& buffer, Sphere& s) {
  s.orientation.coeffs() = buffer.vector<4>();
}

}  // namespace

template <int D>
void put(int number, const Body<D>& body, Buffer& buffer) {
  buffer.push_back(number);
  put_vector(body.x, buffer);
  put_orientation(body, buffer);
  put_vector(body.v, buffer);
  put_turn(body.spin, buffer);
  buffer.insert(buffer.end(), {body.radius, body.mass, body.inertia,
                               static_cast<double>(body.material), static_cast<double>(body.wall)});
}

template <int D>
NumberedBody<D> take_body(BufferReader& buffer) {
  NumberedBody<D> out;
  out.number = buffer.integer();
  Body<D>& body = out.body;
  body.x = buffer.vector<D>();
  take_orientation(buffer, body);
  body.v = buffer.vector<D>();
  take_turn(buffer, body.spin);
  body.radius = buffer.number();
  body.mass = buffer.number();
  body.inertia = buffer.number();
  body.material = buffer.integer();
  body.wall = buffer.integer();
  return out;
}

template <int D>
void put(const ContactOutcome<D>& c, Buffer& buffer) {
  buffer.insert(buffer.end(), {static_cast<double>(c.contact.i), static_cast<double>(c.contact.j)});
  put_vector(c.contact.n, buffer);
  buffer.insert(buffer.end(), {c.contact.gap, c.s_n});
  put_turn(c.s_t, buffer);
  buffer.push_back(c.u_n);
  put_turn(c.u_t, buffer);
  buffer.push_back(static_cast<double>(c.status));
}

template <int D>
ContactOutcome<D> take_contact(BufferReader& buffer) {
  ContactOutcome<D> c;
  c.contact.i = buffer.integer();
  c.contact.j = buffer.integer();
  c.contact.n = buffer.vector<D>();
  c.contact.gap = buffer.number();
  c.s_n = buffer.number();
  take_turn(buffer, c.s_t);
  c.u_n = buffer.number();
  take_turn(buffer, c.u_t);
  c.status = static_cast<ContactStatus>(buffer.integer());
  return c;
}

template <int D>
void sort_by_bodies(std::vector<ContactOutcome<D>>& contacts) {
  std::sort(contacts.begin(), contacts.end(),
            [](const ContactOutcome<D>& a, const ContactOutcome<D>& b) {
              return std::tie(a.contact.i, a.contact.j) < std::tie(b.contact.i, b.contact.j);
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
