#include "core/criterion/impulse_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/criterion/error_terms.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

/// One contact as judged by the criterion, and its impulse as given, in physical variables.
template <int D>
struct GivenContact {
  PhysicalContact<double, D> judged;
  FrameVector<double, D> given;

  /// given - P_K(given).
  FrameVector<double, D> off_cone() const { return given - onto_cone<D>(given, judged.mu); }
};

template <int D>
GivenContact<D> given_contact(const ContactProblem& p, const Vector& diagonal, const Vector& given,
                              const ImpulseVerdict& verdict, int c) {
  FrameVector<double, D> r;
  for (int k = 0; k < D; ++k) r[k] = physical_row_scale(p, c * D + k);
  const double w_nn = r[0] * r[0] * diagonal[c * D];
  return {physical_contact<true>(frame_vector<D>(verdict.s, c), frame_vector<D>(verdict.u, c),
                                 frame_vector<D>(p.u_free, c), r, p.mu[c], w_nn, 1 / w_nn),
          frame_vector<D>(given, c) / r};
}

/// Energies of one contact: its parts of G + V and of the sum under eta², and the distance of the
/// impulse as given from the cone.
struct ContactEnergies {
  double law = 0, natural = 0, cone = 0;
};

template <int D>
ContactEnergies contact_energies(const GivenContact<D>& x) {
  ErrorSums sums;
  const ContactTerms<double> terms = add_law_terms(x.judged, law_terms(x.judged), sums);
  return {terms.violation, sums.natural, natural_energy(x.judged.w_nn, x.off_cone())};
}

template <int D>
std::vector<ContactFault> find_faults(const GivenContact<D>& x) {
  using Kind = ContactFault::Kind;
  std::vector<ContactFault> faults;
  const auto add = [&faults](Kind kind, double size, double energy) {
    if (energy > 0) faults.push_back({kind, size, energy});
  };
  const auto& [s, u, slip, mu, w_nn, rho_nn, moved] = x.judged;
  const double off_cone = natural_energy(w_nn, x.off_cone());
  if (x.given[0] < 0) {
    add(Kind::kPulls, x.given[0], off_cone);
  } else {
    add(Kind::kOutsideCone, tangential_norm<D>(x.given) - mu * x.given[0], off_cone);
  }
  const LawTerms<double> law = law_terms(x.judged);
  if (u[0] < 0) {
    add(Kind::kPenetrates, u[0], law.penetration + law.normal);
  } else {
    add(Kind::kActsAcrossGap, u[0], law.normal);
  }
  if constexpr (D > 1) {
    const bool inside = tangential_norm<D>(s) < kConeEdge * mu * s[0];
    add(inside ? Kind::kSlidesInside : Kind::kNotOpposed, slip, law.excess);
  }
  std::stable_sort(faults.begin(), faults.end(), [](const ContactFault& a, const ContactFault& b) {
    return a.energy > b.energy;
  });
  return faults;
}

template <int D>
Vector to_vector(const FrameVector<double, D>& x) {
  return Eigen::Map<const Local<D>>(x.component);
}

/// The stop test of Siconos: û and the projection in the problem's variables, rho = 1.
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
void judge_contacts(const ContactProblem& p, const Vector& given, const Vector& diagonal,
                    std::size_t worst, ImpulseVerdict& verdict) {
  const int contacts = p.num_contacts();
  std::vector<double> rank(to_size(contacts));
  double off_cone = 0;
  for (int c = 0; c < contacts; ++c) {
    const GivenContact<D> x = given_contact<D>(p, diagonal, given, verdict, c);
    const ContactEnergies e = contact_energies(x);
    const bool by_natural = verdict.error.eta > verdict.error.epsilon;
    rank[to_size(c)] = (by_natural ? e.natural : e.law) + e.cone;
    off_cone += e.cone;
    if (-x.judged.u[0] > verdict.penetration_velocity) {
      verdict.penetration_velocity = -x.judged.u[0];
      verdict.penetration_contact = c;
    }
    const FrameVector<double, D> off = x.off_cone();
    const double violation = std::sqrt(dot(off, off));
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
    const GivenContact<D> x = given_contact<D>(p, diagonal, given, verdict, *it);
    verdict.worst.push_back({.contact = *it,
                             .mu = x.judged.mu,
                             .s = to_vector(x.given),
                             .u = to_vector(x.judged.u),
                             .share = rank[to_size(*it)] / total,
                             .faults = find_faults(x)});
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
  // Smaller faults than a hundredth of the contact's largest one are left out.
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
  if (!verdict.caution.empty()) {
    ImpulseVerdict plain = verdict;
    plain.caution.clear();
    return fmt::format("{}: the error has no meaning as an energy; {}", verdict.caution,
                       sentence(plain, tol));
  }
  const double error = verdict.guarded();
  const char* measure = verdict.cone > verdict.error.guarded() ? "distance to the cone" : "error";
  if (error <= tol) return fmt::format("within the tolerance {:g}: {} {:.2e}", tol, measure, error);
  std::string text = fmt::format("not within the tolerance {:g}: {} {:.2e}", tol, measure, error);
  if (!verdict.worst.empty()) text += "; " + sentence(verdict.worst.front());
  return text;
}

}  // namespace bipot
