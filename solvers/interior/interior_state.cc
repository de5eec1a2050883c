#include "solvers/interior/interior_state.h"

#include <Eigen/LU>
#include <utility>

#include "solvers/kernels/contact_scaling.h"

namespace bipot {
namespace {

constexpr double kRefined = 1e-7;  // correction of a direction after which no other is needed

}  // namespace

template <ContactRows D>
InteriorSystem<D>::InteriorSystem(const ContactProblem& problem, const DelassusOperator& delassus,
                                  ShiftedDelassus::Form form, SystemFactor* elsewhere,
                                  FactorStop stop)
    : problem_(problem),
      delassus_(delassus),
      shifted_(problem, form, elsewhere, std::move(stop)),
      parts_(to_size(problem.num_contacts())),
      mobility_(mean_diagonal(problem, delassus.diagonal())) {
  for (int c = 0; c < num_contacts(); ++c) {
    parts_[to_size(c)] = static_cast<unsigned char>(Jordan::parts_of(mu(c)));
    eigenvalues_ += Jordan::rank(parts(c));
  }
  C_.resize(to_size(num_contacts()) * D * D);
  R_.resize(C_.size());
}

template <ContactRows D>
InteriorState<D> InteriorSystem<D>::central_state(const Vector& impulse,
                                                  const Vector& energy) const {
  State z;
  z.X.setZero(num_contacts() * P);
  z.Y.setZero(num_contacts() * P);
  for (int c = 0; c < num_contacts(); ++c) {
    Local<D> s = Local<D>::Zero();
    s[0] = impulse[c];
    put_central(z, c, Jordan::pairs_of_impulse(s, mu(c), parts(c)), energy[c]);
  }
  recompute(z);
  return z;
}

template <ContactRows D>
void InteriorSystem<D>::recompute(State& z) const {
  const int contacts = num_contacts();
  z.s.resize(contacts * D);
  for (int c = 0; c < contacts; ++c) {
    z.s.template segment<D>(c * D) = Jordan::impulse_of_pairs(pairs(z.X, c), parts(c));
  }
  delassus_.velocity(z.s, z.u);
  z.p.resize(contacts * D);
  for (int c = 0; c < contacts; ++c) {
    Local<D> p = local<D>(z.u, c) - Jordan::velocity_of_pairs(pairs(z.Y, c), parts(c));
    Jordan::clear_smooth_rows(p, parts(c));
    z.p.template segment<D>(c * D) = p;
  }
}

template <ContactRows D>
void InteriorSystem<D>::move(State& z, const PairDirection& d, double t) const {
  z.X += t * d.dX;
  z.Y += t * d.dY;
  for (int c = 0; c < num_contacts(); ++c) {
    Pairs x = pairs(z.X, c);
    Jordan::join_copies(x, mu(c), parts(c));
    z.X.template segment<P>(c * P) = x;
  }
  recompute(z);
}

template <ContactRows D>
Vector InteriorSystem<D>::products(const Vector& X, const Vector& Y) const {
  Vector z(X.size());
  for (int c = 0; c < num_contacts(); ++c) {
    z.segment<P>(c * P) = Jordan::product(pairs(X, c), pairs(Y, c), parts(c));
  }
  return z;
}

template <ContactRows D>
double InteriorSystem<D>::mean_product(const Vector& products) const {
  double sum = 0;
  for (int c = 0; c < num_contacts(); ++c) sum += Jordan::trace(pairs(products, c), parts(c));
  return sum / eigenvalues_;
}

template <ContactRows D>
double InteriorSystem<D>::smallest_product(const Vector& products) const {
  double smallest = kInfinity;
  for (int c = 0; c < num_contacts(); ++c) {
    smallest = std::min(smallest, Jordan::eigenvalues(pairs(products, c), parts(c)).minCoeff());
  }
  return smallest;
}

template <ContactRows D>
double InteriorSystem<D>::residual_energy(const State& z) const {
  double sum = 0;
  for (int c = 0; c < num_contacts(); ++c) {
    const Local<D> p = local<D>(z.p, c);
    sum += (std::abs(p[0]) + friction_speed<D>(p, mu(c))) * z.s[c * D];
  }
  return sum / num_contacts();
}

template <ContactRows D>
double InteriorSystem<D>::longest_step(const State& z, const PairDirection& d) const {
  double t = kInfinity;
  for (int c = 0; c < num_contacts(); ++c) {
    t = std::min(t, Jordan::longest_step(pairs(z.X, c), pairs(d.dX, c), parts(c)));
    t = std::min(t, Jordan::longest_step(pairs(z.Y, c), pairs(d.dY, c), parts(c)));
  }
  return t;
}

template <ContactRows D>
bool InteriorSystem<D>::linearise(const State& z, double delta) {
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  for (int c = 0; c < num_contacts(); ++c) {
    const unsigned f = parts(c);
    const Pairs x = pairs(z.X, c), y = pairs(z.Y, c);
    Eigen::Map<Block> C(&C_[to_size(c) * D * D]);
    Eigen::Map<Block> R(&R_[to_size(c) * D * D]);
    C.setZero();
    Local<D> active = Local<D>::Ones();
    Jordan::clear_smooth_rows(active, f);
    for (int k = 0; k < D; ++k) {
      if (active[k] == 0) {
        C(k, k) = 1;  // until it is inverted
        continue;
      }
      Local<D> unit = Local<D>::Zero();
      unit[k] = 1;
      const Pairs dx = Jordan::pairs_of_impulse(unit, mu(c), f);
      const Pairs dy = Jordan::divide(Jordan::product(dx, y, f), x, f);
      C.col(k) = Jordan::velocity_of_pairs(dy, f);
      C(k, k) += delta * mobility_[c * D + k];
    }
    R = Block(C).inverse();
    for (int k = 0; k < D; ++k) {
      if (active[k] == 0) C(k, k) = R(k, k) = 0;
    }
  }
  return shifted_.factor(R_);
}

/// True if the last correction was small at every contact, relative to its impulse or to its
/// change. The next one would be small relative to this one.
template <ContactRows D>
bool InteriorSystem<D>::refined(const State& z, const Vector& ds) const {
  for (int c = 0; c < num_contacts(); ++c) {
    const double size = std::max(z.s[c * D], local<D>(ds, c).template lpNorm<Eigen::Infinity>());
    if (!(local<D>(correction_, c).template lpNorm<Eigen::Infinity>() <= kRefined * size)) {
      return false;
    }
  }
  return true;
}

template <ContactRows D>
void InteriorSystem<D>::direction(const State& z, const Vector& r, const Vector& p,
                                  PairDirection& out, int refinements) const {
  using Block = Eigen::Matrix<double, D, D, Eigen::RowMajor>;
  const int contacts = num_contacts();
  q_.resize(contacts * D);
  g_.resize(contacts * D);
  for (int c = 0; c < contacts; ++c) {
    const unsigned f = parts(c);
    Local<D> row = Jordan::velocity_of_pairs(Jordan::divide(pairs(r, c), pairs(z.X, c), f), f);
    if (p.size() != 0) row -= local<D>(p, c);
    Jordan::clear_smooth_rows(row, f);
    q_.segment<D>(c * D) = row;
    g_.segment<D>(c * D) = Eigen::Map<const Block>(&R_[block(c)]) * row;
  }
  shifted_.solve(g_, out.ds);
  for (int k = 0; k < refinements; ++k) {
    delassus_.apply(out.ds, wds_);
    for (int c = 0; c < contacts; ++c) {
      Local<D> e = local<D>(q_, c) - local<D>(wds_, c) -
                   Eigen::Map<const Block>(&C_[block(c)]) * local<D>(out.ds, c);
      Jordan::clear_smooth_rows(e, parts(c));
      g_.segment<D>(c * D) = Eigen::Map<const Block>(&R_[block(c)]) * e;
    }
    shifted_.solve(g_, correction_);
    out.ds += correction_;
    if (refined(z, out.ds)) break;
  }
  out.dX.resize(contacts * P);
  out.dY.resize(contacts * P);
  for (int c = 0; c < contacts; ++c) {
    const unsigned f = parts(c);
    const Pairs dx = Jordan::pairs_of_impulse(local<D>(out.ds, c), mu(c), f);
    out.dX.template segment<P>(c * P) = dx;
    out.dY.template segment<P>(c * P) =
        Jordan::divide(pairs(r, c) - Jordan::product(pairs(z.Y, c), dx, f), pairs(z.X, c), f);
  }
}

BIPOT_FOR_ROWS(template class InteriorSystem);

}  // namespace bipot
