#include "core/criterion/impulse_verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "core/base/number_text.h"
#include "core/criterion/error_terms.h"
#include "core/criterion/extended_error.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"

namespace bipot {
namespace {

/// One contact as judged by the criterion, and its impulse as given, in physical variables, rolling
/// rows times their arm.
template <ContactRows D>
struct GivenContact {
  PhysicalContact<double, D, FrictionOf<D>> judged;
  FrameVector<double, D> given;
  double arm;

  /// given - P_K(given).
  FrameVector<double, D> off_cone() const { return given - onto_cone<D>(given, judged.mu); }
};

template <ContactRows D>
GivenContact<D> given_contact(const ContactProblem& p, const ErrorWeights& weights,
                              const Vector& given, const ImpulseVerdict& verdict, int c) {
  FrameVector<double, D> r;
  for (int k = 0; k < D; ++k) r[k] = physical_row_scale(p, c * D + k);
  const double arm = weights.arm_of(c);
  return {physical_contact(true, times_arm<D>(frame_vector<D>(verdict.s, c), 1 / arm),
                           times_arm<D>(frame_vector<D>(verdict.u, c), arm),
                           times_arm<D>(frame_vector<D>(p.u_free, c), arm), r,
                           over_arm(friction_of<D>(p, c), arm), weights.w_nn[c], weights.rho_nn[c]),
          times_arm<D>(frame_vector<D>(given, c), 1 / arm) / r, arm};
}

/// Energies of one contact: its parts of G + V and of the sum under eta², and the distance of the
/// impulse as given from the cone.
struct ContactEnergies {
  double law = 0, natural = 0, cone = 0;
};

template <ContactRows D>
ContactEnergies contact_energies(const GivenContact<D>& x) {
  ErrorSums sums;
  const ContactTerms<double> terms = add_law_terms(x.judged, law_terms(x.judged), sums);
  return {terms.violation, sums.natural, natural_energy(x.judged.w_nn, x.off_cone())};
}

/// The fault of one bounded part of an impulse that exceeds its bound as given, and of one that does
/// not dissipate as it should.
struct PartFaults {
  ContactFault::Kind beyond, inside, not_opposed;
};
constexpr PartFaults kSliding{ContactFault::Kind::kOutsideCone, ContactFault::Kind::kSlidesInside,
                              ContactFault::Kind::kNotOpposed};
constexpr PartFaults kRolling{ContactFault::Kind::kBeyondRolling, ContactFault::Kind::kRollsInside,
                              ContactFault::Kind::kRollsAlong};

template <ContactRows D>
std::vector<ContactFault> find_faults(const GivenContact<D>& x) {
  using Kind = ContactFault::Kind;
  std::vector<ContactFault> faults;
  const auto add = [&faults](Kind kind, double size, double energy) {
    if (energy > 0) faults.push_back({kind, size, energy});
  };
  const auto& s = x.judged.s;
  const auto& u = x.judged.u;
  const double off_cone = natural_energy(x.judged.w_nn, x.off_cone());
  const LawTerms<double> law = law_terms(x.judged);
  if (x.given[0] < 0) add(Kind::kPulls, x.given[0], off_cone);
  if (u[0] < 0) {
    add(Kind::kPenetrates, u[0], law.penetration + law.normal);
  } else {
    add(Kind::kActsAcrossGap, u[0], law.normal);
  }
  each_bounded<D>(x.judged.mu, [&](auto first, auto count, double bound) {
    const bool rolling = first() > D.tangents();
    const PartFaults& faulty = rolling ? kRolling : kSliding;
    const double arm = rolling ? x.arm : 1;
    const double outside = part_norm<first(), count()>(x.given) - bound * x.given[0];
    if (x.given[0] >= 0 && outside > 0) add(faulty.beyond, arm * outside, off_cone);
    const double speed = part_norm<first(), count()>(u);
    double excess = D.rolls ? bound * s[0] * speed : law.excess;
    for (int k = 0; D.rolls && k < count(); ++k) excess += s[first() + k] * u[first() + k];
    const bool inside = part_norm<first(), count()>(s) < kConeEdge * bound * s[0];
    add(inside ? faulty.inside : faulty.not_opposed, speed / arm, excess);
  });
  std::stable_sort(faults.begin(), faults.end(), [](const ContactFault& a, const ContactFault& b) {
    return a.energy > b.energy;
  });
  return faults;
}

/// The physical components, from those with rolling rows times their arm.
template <ContactRows D>
Vector to_vector(const FrameVector<double, D>& x, double over) {
  return Eigen::Map<const Local<D>>(times_arm<D>(x, 1 / over).component);
}

/// The stop test of Siconos: û and the projection in the problem's variables, rho = 1.
template <ContactRows D>
double siconos_map(const ContactProblem& p, const Eigen::Ref<const Vector>& s, const Vector& u) {
  double sum = 0;
  for (int c = 0; c < p.num_contacts(); ++c) {
    const Local<D> x = local<D>(s, c);
    const auto friction = friction_of<D>(p, c);
    const Local<D> hat = de_saxce_velocity<D>(local<D>(u, c), friction);
    sum += (x - project_coulomb_cone<D>(x - hat, friction)).squaredNorm();
  }
  const double scale = std::max({p.u_free.norm(), s.norm(), u.norm()});
  return sum == 0 ? 0 : std::sqrt(sum) / scale;
}

double slide_of(double mu) { return mu; }
double slide_of(const RollingFriction<double>& friction) { return friction.slide; }

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

template <ContactRows D>
void judge_contacts(const ContactProblem& p, const Vector& given, const ErrorWeights& weights,
                    std::size_t worst, ImpulseVerdict& verdict) {
  const int contacts = p.num_contacts();
  std::vector<double> rank(to_size(contacts));
  double off_cone = 0;
  for (int c = 0; c < contacts; ++c) {
    const GivenContact<D> x = given_contact<D>(p, weights, given, verdict, c);
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
    const GivenContact<D> x = given_contact<D>(p, weights, given, verdict, *it);
    verdict.worst.push_back({.contact = *it,
                             .mu = slide_of(x.judged.mu),
                             .tangents = D.tangents(),
                             .s = to_vector<D>(x.given, 1 / x.arm),
                             .u = to_vector<D>(x.judged.u, x.arm),
                             .share = rank[to_size(*it)] / total,
                             .faults = find_faults(x)});
  }
}

/// Angle between a and -b [rad].
double off_opposite(const Vector& a, const Vector& b) {
  const Vector x = a.normalized(), y = b.normalized();
  return 2 * std::atan2((x + y).norm(), (x - y).norm());
}

/// Names of the kinds, in their order.
constexpr std::string_view kFaultNames[] = {"pulls",
                                            "outside the cone",
                                            "beyond the bound of rolling friction",
                                            "penetrates",
                                            "acts across a gap",
                                            "slides inside the cone",
                                            "friction does not oppose",
                                            "rolls inside that bound",
                                            "rolling friction does not oppose"};

std::string sentence(const ContactFault& f, const JudgedContact& c) {
  using Kind = ContactFault::Kind;
  const double s_t = c.tangents > 0 ? c.s.segment(1, c.tangents).norm() : 0;
  switch (f.kind) {
    case Kind::kPulls:
      return fmt::format("pulls with s_n = {:.1e} N s", f.size);
    case Kind::kOutsideCone:
      return fmt::format("outside the cone, |s_t| = {:.1e} N s and mu s_n = {:.1e} N s", s_t,
                         c.mu * c.s[0]);
    case Kind::kPenetrates:
      return fmt::format("penetrates at {:.1e} m/s", -f.size);
    case Kind::kActsAcrossGap:
      return fmt::format("opens at {:.1e} m/s and yet has s_n = {:.1e} N s", f.size, c.s[0]);
    case Kind::kSlidesInside:
      return fmt::format("slides at {:.1e} m/s, |s_t| being {:.3g} of mu s_n", f.size,
                         s_t / (c.mu * c.s[0]));
    case Kind::kNotOpposed:
      return fmt::format("slides at {:.1e} m/s, which s_t does not oppose: {:.1e} rad off", f.size,
                         off_opposite(c.s.segment(1, c.tangents), c.u.segment(1, c.tangents)));
    case Kind::kBeyondRolling:
      return fmt::format("its moment is {:.1e} N m s beyond rolling friction", f.size);
    case Kind::kRollsInside:
      return fmt::format("rolls at {:.1e} rad/s inside the bound of rolling friction", f.size);
    case Kind::kRollsAlong:
      return fmt::format("rolls at {:.1e} rad/s, which its moment does not oppose", f.size);
  }
  return {};
}

}  // namespace

std::string_view to_string(ContactFault::Kind kind) {
  return kFaultNames[static_cast<std::size_t>(kind)];
}

std::string sentence(const JudgedContact& c) {
  // Smaller faults than a hundredth of the contact's largest one are left out.
  constexpr double kWorthSaying = 1e-2;
  std::string text = fmt::format("contact {}", c.contact);
  const char* separator = ": ";
  for (const ContactFault& f : c.faults) {
    if (f.energy < kWorthSaying * c.faults.front().energy) break;
    text += separator + sentence(f, c);
    separator = "; ";
  }
  return text;
}

namespace {

// Below, squares of numbers that are whole themselves lose digits.
constexpr double kLeastEnergy = 1e-290;

/// True if there is an impulse in the cone, or one is needed.
bool acts(const ContactProblem& p, const Eigen::Ref<const Vector>& s) {
  if (!s.isZero(0)) return true;
  for (Eigen::Index k = 0; k < p.u_free.size(); k += p.dim) {
    if (p.u_free[k] < 0) return true;
  }
  return false;
}

}  // namespace

double ImpulseVerdict::guarded() const { return cone > accurate ? cone : accurate; }

ImpulseVerdict judge(const ContactProblem& problem, const Eigen::Ref<const Vector>& s, int worst) {
  check_impulse(problem, s);
  ContactErrorEvaluator evaluate(problem);
  ImpulseVerdict verdict;
  verdict.error = evaluate(s);
  if (!std::isfinite(verdict.error.energy)) {
    throw std::invalid_argument("the energy of these impulses is beyond double precision");
  }
  if (verdict.error.energy < kLeastEnergy && acts(problem, evaluate.impulse())) {
    throw std::invalid_argument("the energy of these impulses is below double precision");
  }
  verdict.s = evaluate.impulse();
  verdict.accurate = accurate_guarded_error(problem, verdict.s, verdict.error);
  verdict.u = evaluate.velocity();
  verdict.count = count_contacts(problem, verdict.s);
  Vector u_given(problem.num_rows());
  evaluate.delassus().velocity(s, u_given);
  const ErrorWeights weights = error_weights(problem, evaluate.delassus().diagonal());
  dispatch_rows(problem, [&](auto d) {
    verdict.siconos_map = siconos_map<d()>(problem, s, u_given);
    judge_contacts<d()>(problem, s, weights, to_size(std::max(0, worst)), verdict);
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
  const char* measure = verdict.cone > verdict.accurate               ? "distance to the cone"
                        : verdict.accurate != verdict.error.guarded() ? "error in higher precision"
                                                                      : "error";
  const bool within = error <= tol;
  std::string text = fmt::format("{} the tolerance {}: {} {:.2e}", within ? "within" : "not within",
                                 tolerance_label(tol), measure, error);
  if (!within && !verdict.worst.empty()) text += "; " + sentence(verdict.worst.front());
  return text;
}

}  // namespace bipot
