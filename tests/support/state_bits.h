#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/motion/state.h"

namespace bipot {

/// Numbers and vectors as hexadecimal floats, of which none is rounded.
inline std::string bits_of(double x) { return fmt::format("{:a} ", x); }
template <class Derived>
std::string bits_of(const Eigen::DenseBase<Derived>& x) {
  std::string text;
  for (Eigen::Index k = 0; k < x.size(); ++k) text += bits_of(x.derived().coeff(k));
  return text;
}
template <class... Values>
std::string bits_of_all(const Values&... values) {
  return (bits_of(values) + ...);
}

/// The bodies of a state, a line each: equal texts are equal bits.
template <int D>
std::string bits_of_bodies(const State<D>& state) {
  std::string text;
  for (const Body<D>& b : state.bodies) {
    text += fmt::format("\nbody {} ", b.material) +
            bits_of_all(b.x, b.v, b.spin, b.radius, b.mass, b.inertia);
    if constexpr (D == 2) text += bits_of(b.angle);
    if constexpr (D == 3) text += bits_of(b.orientation.coeffs());
  }
  return text;
}

/// Its contacts.
template <int D>
std::string bits_of_contacts(const State<D>& state) {
  std::string text;
  for (const ContactOutcome<D>& c : state.contacts) {
    text += fmt::format("\ncontact {} {} {} {} {} ", c.contact.i, c.contact.j, c.contact.image_x,
                        c.contact.image_y, static_cast<int>(c.status)) +
            bits_of_all(c.contact.n, c.contact.gap, c.s_n, c.s_t, c.u_n, c.u_t, c.spring);
  }
  return text;
}

/// All of it: time, work, bodies, clusters, walls, cell, contacts.
template <int D>
std::string bits_of_state(const State<D>& state) {
  std::string text = fmt::format("step {} ", state.step) +
                     bits_of_all(state.time, state.wall_work, state.friction_loss, state.shock_loss,
                                 state.cohesion_loss) +
                     bits_of_bodies(state);
  for (const int number : state.population.numbers) text += fmt::format("\nnumber {}", number);
  for (const auto& c : state.clusters.bodies) {
    text += "\ncluster " + bits_of_all(c.x, c.v, c.spin);
    if constexpr (D == 2) text += bits_of(c.angle);
    if constexpr (D == 3) text += bits_of(c.orientation.coeffs());
  }
  for (const Wall<D>& w : state.walls) {
    text += fmt::format("\nwall '{}' {} {} {} {} ", w.name, static_cast<int>(w.shape),
                        static_cast<int>(w.motion), w.material, w.present) +
            bits_of_all(w.a, w.b, w.normal, w.v, w.direction, w.force, w.mass);
  }
  for (int k = 0; k < 3; ++k) {
    text += "\nside " + bits_of_all(state.cell.side(k).length, state.cell.side(k).speed);
  }
  return text + bits_of_contacts(state);
}

/// Largest distance between the places of the same bodies.
template <class Bodies>
double farthest(const Bodies& a, const Bodies& b) {
  double most = a.size() == b.size() ? 0 : kInfinity;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    most = std::max(most, (a[k].x - b[k].x).norm());
  }
  return most;
}

}  // namespace bipot
