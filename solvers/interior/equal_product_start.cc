#include "solvers/interior/equal_product_start.h"

#include <algorithm>
#include <cmath>

namespace bipot {
namespace {

// Least stiffness of the springs, relative to 1/W_nn: forces reach about its square root of
// contacts far.
constexpr double kSpringStiffness = 1e4;
constexpr int kBisections = 100;

/// Distance a = radius - |s_t| to the edge of the disk of the smoothed friction law W (|s_t| -
/// pull) + 2 tau |s_t| / (radius² - |s_t|²) = 0. Found by bisection in the logarithm: a may be many
/// decades below the radius.
double edge_distance(double pull, double radius, double W, double tau) {
  const auto excess = [&](double a) {
    return W * (radius - a - pull) + 2 * tau * (radius - a) / (a * (2 * radius - a));
  };
  if (!(pull > 0)) return radius;
  double low = std::min(0.5 * radius, 2.0 / 3.0 * tau / (W * pull)), high = radius;
  for (int k = 0; k < kBisections && high > low * (1 + 1e-15); ++k) {
    const double middle = std::sqrt(low) * std::sqrt(high);
    (excess(middle) > 0 ? low : high) = middle;
  }
  return low;
}

}  // namespace

template <ContactRows D>
double EqualProductStart<D>::spring_energy() {
  const ContactProblem& p = system.problem();
  const Vector& mobility = system.mobility();
  std::vector<double> R(to_size(p.num_contacts()) * D * D, 0.0);
  Vector g = Vector::Zero(p.num_rows());
  double fallback = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    // Forces must reach across the largest packing with this number of contacts.
    const double stiffness =
        std::max(kSpringStiffness, static_cast<double>(p.num_contacts())) / mobility[c * D];
    R[to_size(c) * D * D] = stiffness;
    g[c * D] = -stiffness * p.u_free[c * D];
    fallback += p.u_free.segment<D>(c * D).squaredNorm() / mobility[c * D];
  }
  double energy = 0;
  if (system.shifted().factor(R)) {
    Vector s;
    system.shifted().solve(g, s);
    energy = normal_energy(s);
  }
  // An indefinite operator may have a pole at the springs.
  return std::isfinite(energy) && energy > 0 ? energy : fallback / p.num_contacts();
}

template <ContactRows D>
double EqualProductStart<D>::normal_energy(const Vector& s) const {
  double energy = 0;
  for (int c = 0; c < system.num_contacts(); ++c) {
    energy += system.mobility()[c * D] * s[c * D] * s[c * D];
  }
  return energy / system.num_contacts();
}

template <ContactRows D>
InteriorState<D> EqualProductStart<D>::cold(double energy, double factor) const {
  Vector impulse(system.num_contacts());
  for (int c = 0; c < system.num_contacts(); ++c) {
    impulse[c] = factor * std::sqrt(energy / system.mobility()[c * D]);
  }
  return system.central_state(impulse, Vector::Constant(system.num_contacts(), factor * energy));
}

template <ContactRows D>
InteriorState<D> EqualProductStart<D>::warm(const Vector& s0, double tau) const {
  using Jordan = ContactJordan<D>;
  constexpr int P = Jordan::P;
  InteriorState<D> z;
  z.X.setZero(system.num_contacts() * P);
  z.Y.setZero(system.num_contacts() * P);
  Vector u0;
  system.delassus().velocity(s0, u0);
  for (int c = 0; c < system.num_contacts(); ++c) {
    const unsigned f = system.parts(c);
    const double W = system.mobility()[c * D];
    const FrictionOf<D> mu = system.mu(c);
    const double pull = s0[c * D] - u0[c * D] / W;
    const double root = std::sqrt(pull * pull + 4 * tau / W);
    // The positive root of W s² - W pull s - tau, without cancellation.
    const double normal = pull > 0 ? 0.5 * (pull + root) : 2 * tau / W / (root - pull);
    Local<D> s = Local<D>::Zero();
    s[0] = normal;
    Local<D> edges;  // at the first row of each part
    Jordan::each_part(f, mu, [&](auto first, auto count, auto, double bound) {
      const int row = c * D + first();
      const double Wt = system.mobility()[row], radius = bound * normal;
      const Eigen::Matrix<double, count(), 1> along =
          s0.segment<count()>(row) - u0.segment<count()>(row) / Wt;
      const double length = along.norm();
      const double edge = edges[first()] = edge_distance(length, radius, Wt, tau);
      if (length > 0) s.template segment<count()>(first()) = (radius - edge) / length * along;
    });
    typename Jordan::Pairs x = Jordan::pairs_of_impulse(s, mu, f);
    // The difference mu s_n - |s_t| has lost the small edge distance.
    Jordan::each_part(f, [&](auto first, auto count, auto pair) {
      if constexpr (count() == 1) x[pair() + (s[first()] > 0 ? 0 : 1)] = edges[first()];
    });
    system.put_central(z, c, x, tau);
  }
  system.recompute(z);
  return z;
}

BIPOT_FOR_ROWS(template struct EqualProductStart);

}  // namespace bipot
