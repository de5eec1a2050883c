#include "bench/compare/random_problem.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "core/base/portable_random.h"
#include "core/base/triplets.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

/// Friction of a problem: one coefficient, or decades from which that of each contact is drawn.
struct Friction {
  std::string_view name;
  double value = 0;
  int from = 0, to = 0;
};
constexpr std::array<Friction, 6> kFrictions = {{{"0"},
                                                 {"1e-12", 1e-12},
                                                 {"1e-3 to 1", 0, -3, 0},
                                                 {"1 to 10", 0, 0, 1},
                                                 {"1e6", 1e6},
                                                 {"mixed"}}};
constexpr int kMixed = 5;  // of the others

double draw_mu(PortableRandom& draw, int friction) {
  const Friction& f = kFrictions[to_size(friction == kMixed ? draw.below(kMixed) : friction)];
  return f.from < f.to ? draw.decades(f.from, f.to) : f.value;
}

Vec3 draw_direction(PortableRandom& draw, int dim) {
  for (;;) {
    Vec3 x(draw.between(-1, 1), draw.between(-1, 1), dim == 3 ? draw.between(-1, 1) : 0);
    if (x.norm() > 0.1 && x.norm() <= 1) return x.normalized();
  }
}

/// One contact of body i with j (-1: the ground): frame, and the lever arms from both centres.
struct Geometry {
  int i = 0, j = -1;
  Vec3 frame[3];
  Vec3 arm_i, arm_j;
};

Geometry draw_contact(PortableRandom& draw, int dim, int bodies, int c) {
  Geometry g;
  g.i = c % bodies;  // every body is touched
  g.j = draw.chance(0.3) || bodies == 1 ? -1 : draw.below(bodies);
  if (g.j == g.i) g.j = -1;
  g.frame[0] = draw_direction(draw, dim);
  if (dim == 2) {
    g.frame[1] = Vec3(-g.frame[0][1], g.frame[0][0], 0);
  } else if (dim == 3) {
    g.frame[1] = g.frame[0].unitOrthogonal();
    g.frame[2] = g.frame[0].cross(g.frame[1]);
  }
  g.arm_i = draw.decades(-0.5, 0.5) * draw_direction(draw, dim);
  g.arm_j = draw.decades(-0.5, 0.5) * draw_direction(draw, dim);
  return g;
}

/// A and H of bodies with translations (2 or 3) and rotations (none, 1 or 3).
void add_bodies(PortableRandom& draw, ContactProblem& p, int bodies,
                const std::vector<Geometry>& contacts, double mass_unit, double spread,
                double length_unit) {
  const int translations = p.dim == 3 ? 3 : 2;
  const int rotations = p.dim == 1 ? 0 : (p.dim == 2 ? 1 : 3);
  const int per_body = translations + rotations;
  Triplets a, h;
  for (int b = 0; b < bodies; ++b) {
    const double mass = mass_unit * draw.decades(0, spread);
    for (int k = 0; k < translations; ++k) a.emplace_back(b * per_body + k, b * per_body + k, mass);
    const double inertia = mass * length_unit * length_unit * draw.decades(-1, 1);
    for (int k = translations; k < per_body; ++k) {
      a.emplace_back(b * per_body + k, b * per_body + k, inertia);
    }
  }
  const auto add = [&](int body, int column, const Vec3& direction, const Vec3& arm, double sign) {
    for (int k = 0; k < translations; ++k) {
      h.emplace_back(body * per_body + k, column, sign * direction[k]);
    }
    const Vec3 moment = length_unit * arm.cross(direction);
    for (int k = 0; k < rotations; ++k) {
      h.emplace_back(body * per_body + translations + k, column,
                     sign * moment[rotations == 1 ? 2 : k]);
    }
  };
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Geometry& g = contacts[c];
    for (int k = 0; k < p.dim; ++k) {
      const int column = static_cast<int>(c) * p.dim + k;
      add(g.i, column, g.frame[k], g.arm_i, 1);
      if (g.j >= 0) add(g.j, column, g.frame[k], g.arm_j, -1);
    }
  }
  p.A = from_triplets(bodies * per_body, bodies * per_body, a);
  p.H = from_triplets(bodies * per_body, static_cast<Eigen::Index>(contacts.size()) * p.dim, h);
}

/// H diag(1/r), mu r_t / r_n, r = sqrt(1 + e): core/problem/contact_problem.h.
void add_restitution(PortableRandom& draw, ContactProblem& p) {
  p.row_scale.resize(p.H.cols());
  const bool one = draw.chance(0.5);
  const double e = draw.uniform();
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double e_n = one ? e : draw.uniform(), e_t = one ? e : draw.uniform();
    for (int k = 0; k < p.dim; ++k) {
      p.row_scale[c * p.dim + k] = std::sqrt(1 + (k == 0 ? e_n : e_t));
    }
    if (p.dim > 1) p.mu[c] *= p.row_scale[c * p.dim + 1] / p.row_scale[c * p.dim];
  }
  for (int j = 0; j < p.H.outerSize(); ++j) {
    for (SparseMatrix::InnerIterator it(p.H, j); it; ++it) it.valueRef() /= p.row_scale[j];
  }
}

/// A pair (s, u) on the law; u_free follows from it in extended precision.
Vector plant(PortableRandom& draw, ContactProblem& p, double velocity_unit) {
  const int d = p.dim;
  Vector s = Vector::Zero(p.num_rows()), u = s;
  const Vector diagonal = p.W.diagonal();
  for (int c = 0; c < p.num_contacts(); ++c) {
    const double pushed = velocity_unit * draw.between(0.2, 1.2) / diagonal[c * d];
    const double speed = velocity_unit * draw.between(0.1, 1.1);
    const Vec3 direction =
        d == 1 ? Vec3::Zero()
               : (d == 2 ? Vec3(draw.chance(0.5) ? 1 : -1, 0, 0) : draw_direction(draw, 2));
    const int status = draw.below(d == 1 ? 2 : 3);
    if (status == 0) {  // opens
      u[c * d] = speed;
      for (int k = 1; k < d; ++k) u[c * d + k] = speed * direction[k - 1];
      continue;
    }
    // Closed: sticks inside the cone or slips on its edge. If friction is much larger than the
    // normal impulse, it would only press the bodies harder; then the tangential part has this
    // size.
    const double normal = p.mu[c] > 1 ? pushed / p.mu[c] : pushed;
    s[c * d] = normal;
    const double edge = p.mu[c] * normal;
    const double share = status == 1 ? 0.9 * draw.uniform() : 1;
    for (int k = 1; k < d; ++k) {
      s[c * d + k] = -share * edge * direction[k - 1];
      if (status == 2) u[c * d + k] = speed * direction[k - 1];
    }
  }
  for (int i = 0; i < p.num_rows(); ++i) {
    long double sum = u[i];
    for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
      sum -= static_cast<long double>(it.value()) * static_cast<long double>(s[it.col()]);
    }
    p.u_free[i] = static_cast<double>(sum);
  }
  return s;
}

}  // namespace

RandomProblem random_problem(std::uint64_t seed, int index) {
  PortableRandom draw(seed, static_cast<std::uint64_t>(index));
  RandomProblem out;
  ContactProblem& p = out.problem;
  p.dim = 1 + draw.below(3);
  const int contacts = static_cast<int>(std::pow(51.0, draw.uniform()));  // 1 to 50
  const int bodies = 1 + draw.below(contacts);
  const double mass_unit = draw.decades(-10, 10), velocity_unit = draw.decades(-10, 10);
  const double length_unit = draw.decades(-5, 5);
  const double spread = draw.chance(0.5) ? 0 : draw.between(0, 8);
  const int friction = p.dim == 1 ? 0 : draw.below(6);
  const bool repeated = draw.chance(1.0 / 3), restitution = draw.chance(1.0 / 3);
  const bool local = draw.chance(0.5);

  std::vector<Geometry> geometry;
  for (int c = 0; c < contacts; ++c) {
    if (repeated && c >= bodies && draw.chance(0.3)) {
      geometry.push_back(geometry[to_size(draw.below(c))]);
    } else {
      geometry.push_back(draw_contact(draw, p.dim, bodies, c));
    }
  }
  p.u_free = Vector::Zero(static_cast<Eigen::Index>(contacts) * p.dim);
  p.mu.resize(contacts);
  for (int c = 0; c < contacts; ++c) p.mu[c] = draw_mu(draw, friction);
  add_bodies(draw, p, bodies, geometry, mass_unit, spread, length_unit);
  if (restitution) add_restitution(draw, p);
  p.W = assemble_delassus(p.A, p.H, p.dim);
  p.v_free = Vector::Zero(p.H.rows());
  std::string_view data = "planted";
  if (index % 2 == 0) {
    out.planted = plant(draw, p, velocity_unit);
  } else if (draw.chance(0.5)) {
    data = "of a motion";
    for (Eigen::Index i = 0; i < p.v_free.size(); ++i) {
      p.v_free[i] = velocity_unit * draw.between(-1, 1);
      const int per_body = p.dim == 1 ? 2 : 3 * (p.dim - 1);
      if (i % per_body >= (p.dim == 3 ? 3 : 2)) p.v_free[i] /= length_unit;
    }
    p.u_free = p.H.transpose() * p.v_free;
  } else {
    data = "any";
    for (Eigen::Index i = 0; i < p.u_free.size(); ++i) {
      p.u_free[i] = velocity_unit * draw.between(-1, 1);
    }
  }
  if (local) {
    p.A.resize(0, 0);
    p.H.resize(0, 0);
    p.v_free.resize(0);
  } else {
    p.W.resize(0, 0);
  }
  out.description = fmt::format(
      "d = {}, {} contacts, {} bodies, friction {}, masses over {:.1f} decades, units {:.0e} kg, "
      "{:.0e} m/s, {:.0e} m{}{}{}, data {}",
      p.dim, contacts, bodies, kFrictions[to_size(friction)].name, spread, mass_unit, velocity_unit,
      length_unit, repeated ? ", repeated contacts" : "", restitution ? ", restitution" : "",
      local ? ", W alone" : "", data);
  return out;
}

}  // namespace bipot
