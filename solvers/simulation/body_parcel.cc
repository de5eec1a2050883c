#include "solvers/simulation/body_parcel.h"

#include <algorithm>
#include <tuple>

namespace bipot {
namespace {

void put_vector(const Eigen::Ref<const Vector>& x, Parcel& parcel) {
  parcel.insert(parcel.end(), x.data(), x.data() + x.size());
}

void put_turn(double x, Parcel& parcel) { parcel.push_back(x); }
void put_turn(const Vec3& x, Parcel& parcel) { put_vector(x, parcel); }

void take_turn(ParcelReader& parcel, double& x) { x = parcel.number(); }
void take_turn(ParcelReader& parcel, Vec3& x) { x = parcel.vector<3>(); }

void put_orientation(const Disk& d, Parcel& parcel) { parcel.push_back(d.angle); }
void put_orientation(const Sphere& s, Parcel& parcel) {
  put_vector(s.orientation.coeffs(), parcel);
}
void take_orientation(ParcelReader& parcel, Disk& d) { d.angle = parcel.number(); }
void take_orientation(ParcelReader& parcel, Sphere& s) {
  s.orientation.coeffs() = parcel.vector<4>();
}

}  // namespace

template <int D>
void put(int number, const Body<D>& body, Parcel& parcel) {
  parcel.push_back(number);
  put_vector(body.x, parcel);
  put_orientation(body, parcel);
  put_vector(body.v, parcel);
  put_turn(body.spin, parcel);
  parcel.insert(parcel.end(), {body.radius, body.mass, body.inertia,
                               static_cast<double>(body.material), static_cast<double>(body.wall)});
}

template <int D>
NumberedBody<D> take_body(ParcelReader& parcel) {
  NumberedBody<D> out;
  out.number = parcel.integer();
  Body<D>& body = out.body;
  body.x = parcel.vector<D>();
  take_orientation(parcel, body);
  body.v = parcel.vector<D>();
  take_turn(parcel, body.spin);
  body.radius = parcel.number();
  body.mass = parcel.number();
  body.inertia = parcel.number();
  body.material = parcel.integer();
  body.wall = parcel.integer();
  return out;
}

template <int D>
void put(const ContactOutcome<D>& c, Parcel& parcel) {
  parcel.insert(parcel.end(), {static_cast<double>(c.contact.i), static_cast<double>(c.contact.j)});
  put_vector(c.contact.n, parcel);
  parcel.insert(parcel.end(), {c.contact.gap, c.s_n});
  put_turn(c.s_t, parcel);
  parcel.push_back(c.u_n);
  put_turn(c.u_t, parcel);
  parcel.push_back(static_cast<double>(c.status));
}

template <int D>
ContactOutcome<D> take_contact(ParcelReader& parcel) {
  ContactOutcome<D> c;
  c.contact.i = parcel.integer();
  c.contact.j = parcel.integer();
  c.contact.n = parcel.vector<D>();
  c.contact.gap = parcel.number();
  c.s_n = parcel.number();
  take_turn(parcel, c.s_t);
  c.u_n = parcel.number();
  take_turn(parcel, c.u_t);
  c.status = static_cast<ContactStatus>(parcel.integer());
  return c;
}

template <int D>
void sort_by_bodies(std::vector<ContactOutcome<D>>& contacts) {
  std::sort(contacts.begin(), contacts.end(),
            [](const ContactOutcome<D>& a, const ContactOutcome<D>& b) {
              return std::tie(a.contact.i, a.contact.j) < std::tie(b.contact.i, b.contact.j);
            });
}

template void put<2>(int, const Disk&, Parcel&);
template void put<3>(int, const Sphere&, Parcel&);
template NumberedBody<2> take_body(ParcelReader&);
template NumberedBody<3> take_body(ParcelReader&);
template void put<2>(const ContactOutcome<2>&, Parcel&);
template void put<3>(const ContactOutcome<3>&, Parcel&);
template ContactOutcome<2> take_contact<2>(ParcelReader&);
template ContactOutcome<3> take_contact<3>(ParcelReader&);
template void sort_by_bodies<2>(std::vector<ContactOutcome<2>>&);
template void sort_by_bodies<3>(std::vector<ContactOutcome<3>>&);

}  // namespace bipot
