#include <cmath>
#include <string>

#include "bench/compare/case_parts.h"
#include "core/problem/delassus.h"
#include "core/scene/scene_family.h"

namespace bipot {
namespace {

using Expect = ExtremeCase::Expect;

double rounded(double x, int digits) {
  if (x == 0) return 0;
  const double unit = std::pow(10.0, digits - 1 - std::floor(std::log10(std::abs(x))));
  return std::round(x * unit) / unit;
}

/// W of a lattice with `digits` digits; `lower` has one digit less below the diagonal.
ContactProblem rounded_problem(int digits, bool asymmetric) {
  ContactProblem p = first_step(make_family_scene("triangular", 6, {.mass_ratio = 100}));
  p.W = assemble_delassus(p.A, p.H, p.dim);
  for (int i = 0; i < p.W.outerSize(); ++i) {
    for (SparseRows::InnerIterator it(p.W, i); it; ++it) {
      it.valueRef() = rounded(it.value(), asymmetric && it.col() < i ? digits - 1 : digits);
    }
  }
  p.A.resize(0, 0);
  p.H.resize(0, 0);
  p.v_free.resize(0);
  return p;
}

ContactProblem one_normal(double w, double b) {
  ContactProblem p{.dim = 1};
  p.W.resize(1, 1);
  p.W.insert(0, 0) = w;
  p.W.makeCompressed();
  p.mu = Vector::Zero(1);
  p.u_free = Vector::Constant(1, b);
  return p;
}

}  // namespace

void add_violent_cases(std::vector<ExtremeCase>& cases) {
  cases.push_back(
      {.name = "hit_at_1_km_s",
       .what = "a disk of 1 kg hits a triangular lattice of 33 at 1 km/s, 5 steps of 10 µs",
       .known = "one coefficient e = 0: the contacts create no energy",
       .scene =
           [] {
             Scene<2> scene = make_family_scene("triangular", 6);
             scene.step = 1e-5;
             Disk hit = scene.bodies.back();
             hit.x += Vec2(0, 1 + 5e-3);
             hit.v = Vec2(100, -1000);
             scene.bodies.push_back(hit);
             return scene;
           },
       .steps = 5,
       .must_dissipate = true});
  Scene<2> deep = tower({1, 1}, {0.5});
  deep.bodies[1].x[1] -= 0.5;
  deep.bodies[0].x[1] -= 0.3;
  deep.bodies[1].x[1] -= 0.3;
  cases.push_back(
      {.name = "deep_overlap",
       .what = "two disks on a floor, overlapping by half a diameter, the lower one 0.3 m in it",
       .known = "the law is one of velocities: the weights above, as without overlap",
       .problem = step_of(deep),
       .true_error = against(tower_impulses(deep))});
  Scene<2> buried = tower({2}, {0.5});
  buried.bodies[0].x[1] = -3;
  cases.push_back({.name = "inside_a_wall",
                   .what = "a disk whose centre lies 3 m behind a half-plane",
                   .known = "its weight, h m g, along the wall's normal",
                   .problem = step_of(buried),
                   .true_error = against(tower_impulses(buried))});
  Scene<2> same = tower({1, 1}, {0.5});
  same.bodies[1].x = same.bodies[0].x;
  cases.push_back({.name = "coincident_centres",
                   .what = "two disks with one centre",
                   .known = "their contact has no normal: refused, with both numbers",
                   .expect = Expect::kRefused,
                   .problem = step_of(same)});
  Scene<2> nothing = tower({1, 2, 1}, {0.5});
  nothing.gravity.setZero();
  cases.push_back(
      {.name = "zero_everything",
       .what = "a tower of 3 disks without gravity and velocities",
       .known = "s = 0",
       .problem = step_of(nothing),
       .true_error = [](const Vector& s, const Vector&) { return s.cwiseAbs().maxCoeff(); }});
  cases.push_back({.name = "signed_zeros",
                   .what = "one contact with w = -0",
                   .known = "s = 0",
                   .problem = [] { return one_normal(1, -0.0); },
                   .true_error = [](const Vector& s, const Vector&) { return std::abs(s[0]); }});
  cases.push_back({.name = "denormal_data",
                   .what = "one contact, W = 1, w = -1e-310 (below the smallest normal number)",
                   .known =
                       "s = 1e-310; its energy underflows to 0, so that no criterion can tell it "
                       "from s = 0: nothing false may be said, no NaN returned",
                   .expect = Expect::kOpen,
                   .problem = [] { return one_normal(1, -1e-310); }});
  cases.push_back({.name = "denormal_mass",
                   .what = "a mass of 1e-310 kg: W = 1e310 is beyond the largest number",
                   .known = "cannot be represented: a status that says so",
                   .expect = Expect::kOpen,
                   .problem = [] {
                     Scene<2> scene = tower({1, 1e-310}, {0.5});
                     return first_step(scene);
                   }});
  cases.push_back({.name = "huge_data",
                   .what = "one contact, W = 1e-150, w = -1e150: an energy of 1e450 J",
                   .known = "s = 1e300, whose energy is beyond the largest number: nothing false "
                            "may be said",
                   .expect = Expect::kOpen,
                   .problem = [] { return one_normal(1e-150, -1e150); }});
  const std::string digits =
      "the exact W has a solution; the rounded one is slightly indefinite: no theory says it has one";
  cases.push_back(
      {.name = "six_digits",
       .what = "W of a triangular lattice, masses over two decades, rounded to 6 digits",
       .known = digits,
       .expect = Expect::kOpen,
       .problem = [] { return rounded_problem(6, false); }});
  cases.push_back({.name = "seven_digits_asymmetric",
                   .what = "the same with 7 digits above and 6 below the diagonal",
                   .known = digits + ", nor is it symmetric",
                   .expect = Expect::kOpen,
                   .problem = [] { return rounded_problem(7, true); }});
}

}  // namespace bipot
