#include <fmt/format.h>

#include <cmath>

#include "bench/compare/case_parts.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

/// One contact of a unit mass in 3D, W = diag(1, 3, 3) + coupling of normal and tangent.
ContactProblem contact_in_space(double mu, double coupling, const Vector& b) {
  ContactProblem p{.dim = 3};
  p.W.resize(3, 3);
  const double w[3][3] = {{1, coupling, 0}, {coupling, 3, 0}, {0, 0, 3}};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) p.W.insert(i, j) = w[i][j];
  }
  p.W.makeCompressed();
  p.mu = Vector::Constant(1, mu);
  p.u_free = b;
  return p;
}

Vector three(double a, double b, double c) {
  Vector x(3);
  x << a, b, c;
  return x;
}

}  // namespace

void add_friction_cases(std::vector<ExtremeCase>& cases) {
  const auto lattice = [](double mu) {
    return make_family_scene("triangular", 6, {.mu = mu, .tilt_degrees = 20});
  };
  const std::string why =
      "floor and one wall bear it: no self-stress once gravity pushes from both others; a "
      "certificate decides";
  for (const double mu : {0.0, 1e-12, 1.0, 10.0, 1e6}) {
    cases.push_back(
        {.name = fmt::format("mu_{:g}", mu),
         .what = fmt::format(
             "a triangular lattice of 33 disks in a box, tilted by 20 degrees, mu = {:g}", mu),
         .known = why,
         .problem = [=] { return first_step(lattice(mu)); },
         .least_seconds = mu > 1e3 ? 2.0 : 0});
  }
  cases.push_back(
      {.name = "mu_mixed",
       .what = "the same with mu = 0, 1e-12, 0.3, 10 and 1e6 in turn, contact by contact",
       .known = why,
       .problem = [=] {
         ContactProblem p = first_step(lattice(0.3));
         const double mus[] = {0, 1e-12, 0.3, 10, 1e6};
         for (int c = 0; c < p.num_contacts(); ++c) p.mu[c] = mus[c % 5];
         return p;
       }});
  // tan = 3 mu: rolling needs the friction s_n tan / 3, exactly the limit of friction.
  for (const double beyond : {0.0, 1e-12, -1e-12}) {
    Scene<2> scene = empty_scene(0.2);
    const double angle = std::atan(3 * 0.2 * (1 + beyond));
    scene.gravity = 9.81 * Vec2(std::sin(angle), -std::cos(angle));
    scene.bodies = {round_body<2>(Vec2(0, 0.5), 0.5, 2)};
    scene.walls = {flat_floor<2>()};
    const double normal = scene.step * 2 * 9.81 * std::cos(angle);
    cases.push_back(
        {.name = beyond == 0 ? "edge_of_the_cone"
                             : (beyond > 0 ? "just_beyond_the_edge" : "just_within_the_edge"),
         .what = fmt::format("a disk on a plane of slope 3 mu (1 + {:g}), mu = 0.2", beyond),
         .known =
             "rolling asks for s_t = s_n tan / 3, which is the edge: s = s_n (1, mu) on both sides",
         .problem = step_of(scene),
         .true_error = [normal](const Vector& s, const Vector&) {
           return std::hypot(s[0] - normal, std::abs(s[1]) - 0.2 * normal) / normal;
         }});
  }
  // Sliding along +t with u = (0, 1, 0); b_n = coupling - 1/mu < 0, so that s = 0 is no answer.
  for (const double mu : {1.0, 10.0, 1e6}) {
    const double coupling = -0.5;
    // Friction of size 1: s = (1/mu, -1, 0), W s = (1/mu - coupling, coupling/mu - 3, 0).
    const Vector b = three(coupling - 1 / mu, 1 + 3 - coupling / mu, 0);
    cases.push_back(
        {.name = fmt::format("slides_in_space_mu_{:g}", mu),
         .what = fmt::format("one contact in space, normal and tangent coupled, mu = {:g}: "
                             "data of the sliding pair s = (1/mu, -1, 0), u = (0, 1, 0)",
                             mu),
         .known = "that pair obeys the law, and s = 0 does not",
         .problem = [=] { return contact_in_space(mu, coupling, b); },
         .true_error =
             [mu](const Vector& s, const Vector& u) {
               return std::max(relative_difference(s, three(1 / mu, -1, 0)),
                               (u - three(0, 1, 0)).norm());
             }});
  }
  cases.push_back(
      {.name = "sticks_in_space_mu_1e6",
       .what = "the same contact, data of the sticking pair s = (1, 2, -1), u = 0, mu = 1e6",
       .known = "W is regular and s lies inside the cone; the sliding pairs of this contact "
                "would need u_t against s_t",
       .problem =
           [] {
             ContactProblem p = contact_in_space(1e6, 0.5, Vector::Zero(3));
             p.u_free = -(p.W * three(1, 2, -1));
             return p;
           },
       .true_error = against(three(1, 2, -1))});
}

}  // namespace bipot
