#include "core/criterion/impulse_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

/// Physical values of one contact: those of the criterion and the impulse as it was given.
template <int D>
struct ContactValues {
  double mu = 0, w_nn = 0;
  Local<D> given, s, u;
};

template <int D>
ContactValues<D> contact_values(const ContactProblem& p, const Vector& diagonal,
                                const Eigen::Ref<const Vector>& given,
                                const ImpulseVerdict& verdict, int c) {
  ContactValues<D> x{p.mu[c], diagonal[c * D], local<D>(given, c), local<D>(verdict.s, c),
                     local<D>(verdict.u, c)};
  if (p.row_scale.size() == 0) return x;
  const Local<D> r = local<D>(p.row_scale, c);
  if constexpr (D > 1) x.mu *= r[0] / r[1];
  x.w_nn *= r[0] * r[0];
  x.given = x.given.cwiseQuotient(r);
  x.s = x.s.cwiseQuotient(r);
  x.u = x.u.cwiseQuotient(r);
  return x;
}

/// Energies of one contact: what it adds to G + V and to the sum under eta², and how far off the
/// cone it was given.
struct ContactEnergies {
  double law = 0, natural = 0, cone = 0;
};

template <int D>
ContactEnergies contact_energies(const ContactValues<D>& x) {
  ContactEnergies e;
  e.cone = 0.5 * x.w_nn * (x.given - project_coulomb_cone<D>(x.given, x.mu)).squaredNorm();
  const double slip = tangential_norm<D>(x.u);
  double power = x.mu * x.s[0] * slip;
  for (int k = 1; k < D; ++k) power += x.s[k] * x.u[k];
  const double closing = positive_part(-x.u[0]);
  e.law = positive_part(power) + x.s[0] * std::abs(x.u[0]) + 0.5 * closing * closing / x.w_nn;
  if (x.s[0] == 0 && x.u[0] >= 0) return e;
  const Local<D> moved = x.s - de_saxce_velocity<D>(x.u, x.mu) / x.w_nn;
  e.natural = 0.5 * x.w_nn * (x.s - project_coulomb_cone<D>(moved, x.mu)).squaredNorm();
  return e;
}

template <int D>
std::vector<ContactFault> find_faults(const ContactValues<D>& x) {
  using Kind = ContactFault::Kind;
  std::vector<ContactFault> faults;
  const auto add = [&faults](Kind kind, double size, double energy) {
    if (energy > 0) faults.push_back({kind, size, energy});
  };
  const double off_cone = contact_energies(x).cone;
  const double given_t = tangential_norm<D>(x.given);
  if (x.given[0] < 0) {
    add(Kind::kPulls, x.given[0], off_cone);
  } else {
    add(Kind::kOutsideCone, given_t - x.mu * x.given[0], off_cone);
  }
  const double u_n = x.u[0];
  if (u_n < 0) {
    add(Kind::kPenetrates, u_n, 0.5 * u_n * u_n / x.w_nn - x.s[0] * u_n);
  } else {
    add(Kind::kActsAcrossGap, u_n, x.s[0] * u_n);
  }
  if constexpr (D > 1) {
    const double slip = tangential_norm<D>(x.u);
    double power = x.mu * x.s[0] * slip;
    for (int k = 1; k < D; ++k) power += x.s[k] * x.u[k];
    const bool inside = tangential_norm<D>(x.s) < kConeEdge * x.mu * x.s[0];
    add(inside ? Kind::kSlidesInside : Kind::kNotOpposed, slip, power);
  }
  std::stable_sort(faults.begin(), faults.end(), [](const ContactFault& a, const ContactFault& b) {
    return a.energy > b.energy;
  });
  return faults;
}

/// Siconos' own: û and the projection in the problem's variables, rho = 1.
template <int D>
double siconos_map(const ContactProblem& p, const Eigen::Ref<const Vector>& s, const Vector& u) {
  double sum = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> x = local<D>(s, c);
    const Local<D> hat = de_saxce_velocity<D>(local<D>(u, c), p.mu[c]);
    sum += (x - project_coulomb_cone<D>(x - hat, p.mu[c])).squaredNorm();
  }
  const double scale = std::max({p.u_free.norm(), s.norm(), u.norm()});
  return sum == 0 ? 0 : std::sqrt(sum) / scale;
}

void check_impulse(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  if (s.size() != p.num_rows()) {
    throw std::invalid_argument(fmt::format("s has size {}, expected {} = {} contacts x {}",
                                            s.size(), p.num_rows(), p.num_contacts(), p.dim));
  }
  for (Eigen::Index i = 0; i < s.size(); ++i) {
    if (!std::isfinite(s[i])) {
      throw std::invalid_argument(fmt::format("s[{}] = {} is not finite", i, s[i]));
    }
  }
}

template <int D>
void judge_contacts(const ContactProblem& p, const Eigen::Ref<const Vector>& given,
                    const Vector& diagonal, std::size_t worst, ImpulseVerdict& verdict) {
  const int contacts = p.num_contacts();
  std::vector<double> rank(to_size(contacts));
  double off_cone = 0;
  for (int c = 0; c < contacts; ++c) {
    const auto x = contact_values<D>(p, diagonal, given, verdict, c);
    const ContactEnergies e = contact_energies<D>(x);
    const bool by_natural = verdict.error.eta > verdict.error.epsilon;
    rank[to_size(c)] = (by_natural ? e.natural : e.law) + e.cone;
    off_cone += e.cone;
    if (-x.u[0] > verdict.penetration_velocity) {
      verdict.penetration_velocity = -x.u[0];
      verdict.penetration_contact = c;
    }
    const double violation = (x.given - project_coulomb_cone<D>(x.given, x.mu)).norm();
    if (violation > verdict.cone_violation) {
      verdict.cone_violation = violation;
      verdict.cone_contact = c;
    }
  }
  const double scale = std::max(verdict.error.friction_power, kTheta * verdict.error.energy);
  verdict.cone = off_cone == 0 ? 0 : (scale == 0 ? kInfinity : std::sqrt(off_cone / scale));

  const double total = std::accumulate(rank.begin(), rank.end(), 0.0);
  std::vector<int> order(to_size(contacts));
  std::iota(order.begin(), order.end(), 0);
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(worst, order.size()));
  std::partial_sort(order.begin(), end, order.end(), [&](int a, int b) {
    return rank[to_size(a)] != rank[to_size(b)] ? rank[to_size(a)] > rank[to_size(b)] : a < b;
  });
  for (auto it = order.begin(); it != end && rank[to_size(*it)] > 0; ++it) {
    const auto x = contact_values<D>(p, diagonal, given, verdict, *it);
    verdict.worst.push_back({.contact = *it,
                             .mu = x.mu,
                             .s = x.given,
                             .u = x.u,
                             .share = rank[to_size(*it)] / total,
                             .faults = find_faults<D>(x)});
  }
}

}  // namespace

std::string_view to_string(ContactFault::Kind kind) {
  switch (kind) {
    case ContactFault::Kind::kPulls:
      return "pulls";
    case ContactFault::Kind::kOutsideCone:
      return "outside the cone";
    case ContactFault::Kind::kPenetrates:
      return "penetrates";
    case ContactFault::Kind::kActsAcrossGap:
      return "acts across a gap";
    case ContactFault::Kind::kSlidesInside:
      return "slides inside the cone";
    case ContactFault::Kind::kNotOpposed:
      return "friction does not oppose";
  }
  return "unknown fault";
}

std::string sentence(const JudgedContact& c) {
  using Kind = ContactFault::Kind;
  std::string text = fmt::format("contact {}", c.contact);
  // Faults of a hundredth of the contact's largest one would only hide it.
  constexpr double kWorthSaying = 1e-2;
  const double s_t = c.s.size() > 1 ? c.s.tail(c.s.size() - 1).norm() : 0;
  bool first = true;
  for (const ContactFault& f : c.faults) {
    if (f.energy < kWorthSaying * c.faults.front().energy) break;
    text += first ? ": " : "; ";
    first = false;
    switch (f.kind) {
      case Kind::kPulls:
        text += fmt::format("pulls with s_n = {:.1e} N s", f.size);
        break;
      case Kind::kOutsideCone:
        text += fmt::format("outside the cone, |s_t| = {:.1e} N s and mu s_n = {:.1e} N s", s_t,
                            c.mu * c.s[0]);
        break;
      case Kind::kPenetrates:
        text += fmt::format("penetrates at {:.1e} m/s", -f.size);
        break;
      case Kind::kActsAcrossGap:
        text += fmt::format("opens at {:.1e} m/s and yet has s_n = {:.1e} N s", f.size, c.s[0]);
        break;
      case Kind::kSlidesInside:
        text += fmt::format("slides at {:.1e} m/s, |s_t| being {:.3g} of mu s_n", f.size,
                            s_t / (c.mu * c.s[0]));
        break;
      case Kind::kNotOpposed:
        text += fmt::format("slides at {:.1e} m/s, which s_t does not oppose", f.size);
        break;
    }
  }
  return text;
}

double ImpulseVerdict::guarded() const {
  const double law = error.guarded();
  return cone > law ? cone : law;
}

ImpulseVerdict judge(const ContactProblem& problem, const Eigen::Ref<const Vector>& s, int worst) {
  check_impulse(problem, s);
  ContactErrorEvaluator evaluate(problem);
  ImpulseVerdict verdict;
  verdict.error = evaluate(s);
  verdict.s = evaluate.impulse();
  verdict.u = evaluate.velocity();
  verdict.count = count_contacts(problem, verdict.s);
  Vector u_given(problem.num_rows());
  evaluate.delassus().velocity(s, u_given);
  const Vector diagonal = evaluate.delassus().diagonal();
  dispatch_dim(problem.dim, [&](auto d) {
    verdict.siconos_map = siconos_map<d()>(problem, s, u_given);
    judge_contacts<d()>(problem, s, diagonal, to_size(std::max(0, worst)), verdict);
  });
  return verdict;
}

std::string sentence(const ImpulseVerdict& verdict, double tol) {
  const double error = verdict.guarded();
  const char* measure = verdict.cone > verdict.error.guarded() ? "distance to the cone" : "error";
  if (error <= tol) return fmt::format("within the tolerance {:g}: {} {:.2e}", tol, measure, error);
  std::string text = fmt::format("not within the tolerance {:g}: {} {:.2e}", tol, measure, error);
  if (!verdict.worst.empty()) text += "; " + sentence(verdict.worst.front());
  return text;
}

}  // namespace bipot
