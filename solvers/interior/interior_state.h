#pragma once

#include <vector>

#include "solvers/interior/contact_jordan.h"
#include "solvers/systems/shifted_delassus.h"

namespace bipot {

/// A point in the interior of the cones of the contact law, with exact dynamics. It has the pairs
/// X, Y of every contact (contact_jordan.h) and the impulse s of X. The velocity u = W s + u_free
/// is recomputed from s; the kinematic residual is p = u - U Y.
template <ContactRows D>
struct InteriorState {
  Vector X, Y;  ///< ContactJordan<D>::P components a contact
  Vector s, u;  ///< m
  Vector p;     ///< m, u - U Y; zero for rows without friction
};

/// A direction in the pairs and the impulse.
struct PairDirection {
  Vector dX, dY, ds;
};

/// The complementarity system of a problem and its Newton directions. With W_cc the diagonal of W
/// (tangents averaged) and L(X) the multiplication by X, a direction solves
///
///     X∘dY + Y∘dX = r,   dX = T ds,   W ds + delta W_cc ds - U dY = -p,
///
/// condensed contact by contact to (W + C) ds = q, C = U L(X)⁻¹ L(Y) T + delta W_cc, q = U L(X)⁻¹ r
/// - p. One factorisation of I + C⁻¹ W serves all right-hand sides. Each solution is refined by the
/// velocity residual q - W ds - C ds, because eliminating nearly open or nearly sliding contacts
/// loses ds (C ranges over 1e12).
template <ContactRows D>
class InteriorSystem {
 public:
  using State = InteriorState<D>;
  using Jordan = ContactJordan<D>;
  using Pairs = typename Jordan::Pairs;
  static constexpr int P = Jordan::P;

  /// `elsewhere`: factors the linear systems; null: LocalFactor does. `stop`: of ShiftedDelassus.
  InteriorSystem(const ContactProblem& problem, const DelassusOperator& delassus,
                 ShiftedDelassus::Form form, SystemFactor* elsewhere = nullptr,
                 FactorStop stop = {});

  /// X, Y with all eigenvalue products equal to `energy[c]`, s_t = 0, s_n = impulse[c].
  State central_state(const Vector& impulse, const Vector& energy) const;
  /// X = x and Y with all eigenvalue products equal to `energy`, of one contact.
  void put_central(State& z, int c, const Pairs& x, double energy) const {
    z.X.template segment<P>(c * P) = x;
    z.Y.template segment<P>(c * P) =
        Jordan::divide(Jordan::identity(energy, parts(c)), x, parts(c));
  }
  /// u and p from X and Y.
  void recompute(State& z) const;
  /// z + t d.
  void move(State& z, const PairDirection& d, double t) const;

  Vector products(const Vector& X, const Vector& Y) const;
  double mean_product(const Vector& products) const;
  double smallest_product(const Vector& products) const;
  /// Mean over the contacts of (|p_n| + mu |p_t|) s_n, an energy like the mean product.
  double residual_energy(const State& z) const;
  double longest_step(const State& z, const PairDirection& d) const;

  /// Factors at z. False: singular or not finite.
  [[nodiscard]] bool linearise(const State& z, double delta);
  int determinant_sign() const { return shifted_.determinant_sign(); }
  /// Direction for the right-hand sides r (P for each contact) and p (m; empty: zero). Refined at
  /// most `refinements` times, until a correction is below 1e-7 of every contact's impulse.
  void direction(const State& z, const Vector& r, const Vector& p, PairDirection& out,
                 int refinements = 2) const;

  /// ContactJordan::parts_of() a contact.
  unsigned parts(int c) const { return parts_[to_size(c)]; }
  FrictionOf<D> mu(int c) const { return friction_of<D>(problem_, c); }
  int num_contacts() const { return problem_.num_contacts(); }
  int num_eigenvalues() const { return eigenvalues_; }
  const Vector& mobility() const { return mobility_; }
  ShiftedDelassus& shifted() { return shifted_; }
  const DelassusOperator& delassus() const { return delassus_; }
  const ContactProblem& problem() const { return problem_; }

  Pairs pairs(const Vector& x, int c) const { return x.template segment<P>(c * P); }

 private:
  bool refined(const State& z, const Vector& ds) const;
  /// Start of the d x d block of contact c.
  static std::size_t block(int c) { return to_size(c) * D * D; }

  const ContactProblem& problem_;
  const DelassusOperator& delassus_;
  ShiftedDelassus shifted_;
  std::vector<unsigned char> parts_;
  int eigenvalues_ = 0;
  Vector mobility_;            // diagonal of W, tangents averaged
  std::vector<double> C_, R_;  // row-major d x d blocks of the last linearisation
  mutable Vector q_, g_, correction_, wds_;
};

}  // namespace bipot
