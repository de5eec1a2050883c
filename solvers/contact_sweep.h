#pragma once

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/contact_problem.h"
#include "core/coulomb_cone.h"
#include "core/delassus.h"

namespace bipot {

/// Local velocities that follow the impulse contact by contact, the state of every Gauss-Seidel
/// sweep. Two forms behind one interface:
///   - two-pass (diagonal A): the mass-scaled body velocities y = A^{-1/2} H s are updated in
///   place;
///     a contact touches at most two runs of K consecutive degrees of freedom (one rigid body
///     each);
///   - explicit: u_c is a product with the block row of W.
/// The first streams about 170 bytes a contact for disks, the second about 450.
template <int D>
class ExplicitSweep {
 public:
  explicit ExplicitSweep(const ContactProblem& p) : p_(p), s_(Vector::Zero(p.num_rows())) {
    if (!p.has_delassus()) throw std::invalid_argument("the explicit sweep needs W");
  }
  void reset(const Eigen::Ref<const Vector>& s) { s_ = s; }
  const Vector& impulse() const { return s_; }
  Local<D> impulse(int c) const { return s_.segment<D>(c * D); }

  Local<D> velocity(int c) const {
    Local<D> u = p_.u_free.segment<D>(c * D);
    const int* start = p_.W.outerIndexPtr();
    const int* column = p_.W.innerIndexPtr();
    const double* value = p_.W.valuePtr();
    for (int a = 0; a < D; ++a) {
      double sum = 0;
      for (int k = start[c * D + a]; k < start[c * D + a + 1]; ++k) sum += value[k] * s_[column[k]];
      u[a] += sum;
    }
    return u;
  }
  void set(int c, const Local<D>& s) { s_.segment<D>(c * D) = s; }

 private:
  const ContactProblem& p_;
  Vector s_;
};

template <int D, int K>
class TwoPassSweep {
 public:
  /// True when every contact acts on at most two runs of K consecutive degrees of freedom.
  static bool fits(const ContactProblem& p) {
    if (!p.has_velocities() || !is_diagonal(p.A)) return false;
    std::vector<int> dofs;
    for (int c = 0; c < p.num_contacts(); ++c) {
      if (!runs(p, c, dofs).fits) return false;
    }
    return true;
  }

  explicit TwoPassSweep(const ContactProblem& p)
      : p_(p), contacts_(p.num_contacts()), y_(Vector::Zero(p.num_dofs() + K)) {
    root_inverse_mass_ = p.A.diagonal().cwiseInverse().cwiseSqrt();
    std::vector<int> dofs;
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Runs r = runs(p, c, dofs);
      Contact& contact = contacts_[c];
      contact.start[0] = r.start[0];
      contact.start[1] = r.start[1];
      for (int a = 0; a < D; ++a) {
        for (SparseMatrix::InnerIterator it(p.H, c * D + a); it; ++it) {
          const int row = static_cast<int>(it.row());
          const int side = row < r.start[0] + K && row >= r.start[0] ? 0 : 1;
          contact.g[side][row - r.start[side]][a] = it.value() * root_inverse_mass_[row];
        }
      }
      contact.b = p.u_free.segment<D>(c * D);
    }
  }

  void reset(const Eigen::Ref<const Vector>& s) {
    y_.setZero();
    const Vector wrench = p_.H * s;
    y_.head(p_.num_dofs()) = root_inverse_mass_.cwiseProduct(wrench);
    for (int c = 0; c < p_.num_contacts(); ++c) contacts_[c].s = s.segment<D>(c * D);
  }
  const Vector& impulse() const {
    gathered_.resize(p_.num_rows());
    for (int c = 0; c < p_.num_contacts(); ++c) gathered_.segment<D>(c * D) = contacts_[c].s;
    return gathered_;
  }
  Local<D> impulse(int c) const { return contacts_[c].s; }

  Local<D> velocity(int c) const {
    const Contact& contact = contacts_[c];
    Local<D> u = contact.b;
    for (int side = 0; side < 2; ++side) {
      const double* y = y_.data() + contact.start[side];
      for (int k = 0; k < K; ++k) {
        for (int a = 0; a < D; ++a) u[a] += contact.g[side][k][a] * y[k];
      }
    }
    return u;
  }
  void set(int c, const Local<D>& s) {
    Contact& contact = contacts_[c];
    const Local<D> ds = s - contact.s;
    contact.s = s;
    for (int side = 0; side < 2; ++side) {
      double* y = y_.data() + contact.start[side];
      for (int k = 0; k < K; ++k) {
        for (int a = 0; a < D; ++a) y[k] += contact.g[side][k][a] * ds[a];
      }
    }
  }

 private:
  struct Contact {
    int start[2] = {0, 0};
    double g[2][K][D] = {};
    Local<D> b = Local<D>::Zero(), s = Local<D>::Zero();
  };
  struct Runs {
    bool fits = false;
    int start[2] = {0, 0};
  };

  static Runs runs(const ContactProblem& p, int c, std::vector<int>& dofs) {
    dofs.clear();
    for (int a = 0; a < D; ++a) {
      for (SparseMatrix::InnerIterator it(p.H, c * D + a); it; ++it) {
        dofs.push_back(static_cast<int>(it.row()));
      }
    }
    std::sort(dofs.begin(), dofs.end());
    Runs r;
    if (dofs.empty()) return r;
    r.start[0] = dofs.front();
    // The second run is anchored at its first touched degree of freedom; with none, it points at
    // the padding behind the last one, with zero coefficients.
    r.start[1] = p.num_dofs();
    for (int dof : dofs) {
      if (dof >= r.start[0] + K) {
        r.start[1] = dof;
        break;
      }
    }
    r.fits = dofs.back() < r.start[0] + K || dofs.back() < r.start[1] + K;
    return r;
  }

  const ContactProblem& p_;
  std::vector<Contact> contacts_;
  Vector root_inverse_mass_;
  Vector y_;
  mutable Vector gathered_;
};

/// Calls f with the fastest sweep that the problem's structure allows.
template <int D, class F>
decltype(auto) with_sweep(const ContactProblem& p, F&& f) {
  constexpr int kPlanar = D == 1 ? 2 : 3;  // disks: (x, y) without friction, (x, y, spin) with
  if (TwoPassSweep<D, kPlanar>::fits(p)) return f(TwoPassSweep<D, kPlanar>(p));
  if (TwoPassSweep<D, 6>::fits(p)) return f(TwoPassSweep<D, 6>(p));
  if (p.has_delassus()) return f(ExplicitSweep<D>(p));
  ContactProblem copy = p;
  copy.W = assemble_delassus(p.A, p.H, p.dim);
  return f(ExplicitSweep<D>(copy));
}

}  // namespace bipot
