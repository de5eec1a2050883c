#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"
#include "core/problem/delassus.h"
#include "core/problem/delassus_blocks.h"
#include "core/problem/disk_structure.h"
#include "solvers/kernels/sphere_sweep.h"

namespace bipot {

/// Local velocities that follow the impulse contact by contact, the state of every Gauss-Seidel
/// sweep. Three forms have one interface:
///   - disks and spheres: body velocities are updated in place, H is packed;
///   - two-pass (diagonal A): the mass-scaled body velocities y = A^{-1/2} H s are updated in
///     place. A contact touches at most two runs of K consecutive degrees of freedom (one rigid
///     body each);
///   - explicit: u_c is a product with the block row of W.
/// The forms stream about 100, 170 and 450 bytes for each contact of disks.
template <int D>
class ExplicitSweep {
 public:
  ExplicitSweep(const ContactProblem& p, std::shared_ptr<const DelassusBlocks> blocks)
      : p_(p), blocks_(std::move(blocks)), s_(Vector::Zero(p.num_rows())) {}
  void reset(const Eigen::Ref<const Vector>& s) { s_ = s; }
  const Vector& impulse() const { return s_; }
  Local<D> impulse(int c) const { return s_.segment<D>(c * D); }

  Local<D> velocity(int c) const {
    return blocks_->product<D>(c, s_.data()) + Local<D>(p_.u_free.segment<D>(c * D));
  }
  void set(int c, const Local<D>& s) { s_.segment<D>(c * D) = s; }

 private:
  const ContactProblem& p_;
  std::shared_ptr<const DelassusBlocks> blocks_;
  Vector s_;
};

template <int D, int K>
class TwoPassSweep {
 public:
  /// True if every contact acts on at most two runs of K consecutive degrees of freedom.
  static bool fits(const ContactProblem& p) {
    if (!p.has_velocities() || !is_diagonal(p.A)) return false;
    std::vector<int> dofs;
    for (int c = 0; c < p.num_contacts(); ++c) {
      if (!runs(p, c, dofs).fits) return false;
    }
    return true;
  }

  explicit TwoPassSweep(const ContactProblem& p)
      : p_(p), contacts_(to_size(p.num_contacts())), y_(Vector::Zero(p.num_dofs() + K)) {
    root_inverse_mass_ = p.A.diagonal().cwiseInverse().cwiseSqrt();
    std::vector<int> dofs;
    for (int c = 0; c < p.num_contacts(); ++c) {
      const Runs r = runs(p, c, dofs);
      Contact& contact = contacts_[to_size(c)];
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
    for (int c = 0; c < p_.num_contacts(); ++c) contacts_[to_size(c)].s = s.segment<D>(c * D);
  }
  const Vector& impulse() const {
    gathered_.resize(p_.num_rows());
    for (int c = 0; c < p_.num_contacts(); ++c) {
      gathered_.segment<D>(c * D) = contacts_[to_size(c)].s;
    }
    return gathered_;
  }
  Local<D> impulse(int c) const { return contacts_[to_size(c)].s; }

  Local<D> velocity(int c) const {
    const Contact& contact = contacts_[to_size(c)];
    // Four sums for each row: one would wait for each of its additions.
    double u[2][2][kRows] = {};
    for (int side = 0; side < 2; ++side) {
      const double* y = y_.data() + contact.start[side];
      for (int k = 0; k < K; ++k) {
        for (int a = 0; a < D; ++a) u[side][k % 2][a] += contact.g[side][k][a] * y[k];
      }
    }
    Local<D> sum = contact.b;
    for (int a = 0; a < D; ++a) sum[a] += (u[0][0][a] + u[0][1][a]) + (u[1][0][a] + u[1][1][a]);
    return sum;
  }
  /// Adds to the contact's velocity at s = 0 the effect of contacts elsewhere.
  void shift(int c, const Local<D>& by) { contacts_[to_size(c)].b += by; }
  void set(int c, const Local<D>& s) {
    Contact& contact = contacts_[to_size(c)];
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
  static constexpr std::size_t kRun = K, kRows = D;
  struct Contact {
    int start[2] = {0, 0};
    double g[2][kRun][kRows] = {};
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
    // The second run starts at its first touched degree of freedom. Without one, it points at the
    // padding after the last, with zero coefficients.
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

/// The two-pass form for disks (disk_structure.h): 72 bytes for each contact, four numbers of H
/// included.
template <int D>
class DiskSweep {
 public:
  DiskSweep(const ContactProblem& p, const DiskStructure& disks)
      : contacts_(to_size(p.num_contacts())), bodies_(disks.bodies.size()) {
    for (std::size_t k = 0; k < bodies_.size(); ++k) {
      bodies_[k].inverse_mass = disks.bodies[k].inverse_mass;
      bodies_[k].inverse_inertia = disks.bodies[k].inverse_inertia;
    }
    for (int c = 0; c < p.num_contacts(); ++c) {
      const DiskStructure::Contact& from = disks.contacts[to_size(c)];
      Contact& to = contacts_[to_size(c)];
      to.i = from.i;
      to.j = from.j;
      to.gx = from.normal * from.n[0];
      to.gy = from.normal * from.n[1];
      to.spin = from.tangential;
      to.ratio = from.tangential / from.normal;
      for (int k = 0; k < D; ++k) to.b[k] = p.u_free[c * D + k];
    }
  }

  void reset(const Eigen::Ref<const Vector>& s) {
    for (Body& body : bodies_) body.vx = body.vy = body.w = 0;
    for (int c = 0; c < static_cast<int>(contacts_.size()); ++c) {
      for (int k = 0; k < D; ++k) contacts_[to_size(c)].s[k] = 0;
      set(c, local<D>(s, c));
    }
  }
  const Vector& impulse() const {
    gathered_.resize(D * static_cast<Eigen::Index>(contacts_.size()));
    double* to = gathered_.data();
    for (const Contact& contact : contacts_) {
      for (int k = 0; k < D; ++k) *to++ = contact.s[k];
    }
    return gathered_;
  }
  Local<D> impulse(int c) const { return Eigen::Map<const Local<D>>(contacts_[to_size(c)].s); }

  Local<D> velocity(int c) const {
    const Contact& k = contacts_[to_size(c)];
    const Body& i = bodies_[to_size(k.i)];
    const Body& j = bodies_[to_size(k.j)];
    const double vx = i.vx - j.vx, vy = i.vy - j.vy;
    Local<D> u;
    u[0] = k.gx * vx + k.gy * vy + k.b[0];
    if constexpr (D == 2) u[1] = k.ratio * (k.gx * vy - k.gy * vx) - k.spin * (i.w + j.w) + k.b[1];
    return u;
  }
  /// Adds to the contact's velocity at s = 0 the effect of contacts elsewhere.
  void shift(int c, const Local<D>& by) {
    for (int k = 0; k < D; ++k) contacts_[to_size(c)].b[k] += by[k];
  }
  void set(int c, const Local<D>& s) {
    Contact& k = contacts_[to_size(c)];
    Body& i = bodies_[to_size(k.i)];
    Body& j = bodies_[to_size(k.j)];
    const double normal = s[0] - k.s[0];
    k.s[0] = s[0];
    double px = k.gx * normal, py = k.gy * normal;
    if constexpr (D == 2) {
      const double change = s[1] - k.s[1];
      k.s[1] = s[1];
      const double tangential = k.ratio * change, spin = k.spin * change;
      px -= k.gy * tangential;
      py += k.gx * tangential;
      i.w -= i.inverse_inertia * spin;
      j.w -= j.inverse_inertia * spin;
    }
    i.vx += i.inverse_mass * px;
    i.vy += i.inverse_mass * py;
    j.vx -= j.inverse_mass * px;
    j.vy -= j.inverse_mass * py;
  }

  /// Steps of relax(); step[0] times W_nn and step[1] times W_tt are the relaxation.
  void set_steps(int c, const Local<D>& step, double mu) {
    for (int k = 0; k < D; ++k) contacts_[to_size(c)].step[k] = step[k];
    contacts_[to_size(c)].mu = mu;
  }
  /// s_n <- max(0, s_n - step_n u_n), s_t <- s_t - step_t u_t cut off at mu s_n, and velocities.
  /// The same as velocity(), the two projections and set(). Products are arranged for the shortest
  /// dependency chain from one contact of a body to its next.
  void relax(int c) {
    Contact& k = contacts_[to_size(c)];
    Body& i = bodies_[to_size(k.i)];
    Body& j = bodies_[to_size(k.j)];
    const double vx = i.vx - j.vx, vy = i.vy - j.vy;
    const double ax = k.step[0] * k.gx, ay = k.step[0] * k.gy;
    const double start = k.s[0] - k.step[0] * k.b[0];
    const double trial = start - (ax * vx + ay * vy);
    const double s_n = trial > 0 ? trial : 0;
    const double normal = s_n - k.s[0];
    k.s[0] = s_n;
    double ix = i.vx + i.inverse_mass * k.gx * normal, iy = i.vy + i.inverse_mass * k.gy * normal;
    double jx = j.vx - j.inverse_mass * k.gx * normal, jy = j.vy - j.inverse_mass * k.gy * normal;
    if constexpr (D == 2) {
      const double tx = k.ratio * k.gy, ty = k.ratio * k.gx;
      const double bx = k.step[1] * tx, by = k.step[1] * ty, bw = k.step[1] * k.spin;
      const double start_t = k.s[1] - k.step[1] * k.b[1];
      const double trial_t = start_t - ((by * vy - bx * vx) - bw * (i.w + j.w));
      const double s_t = cut_off(trial_t, k.mu * s_n);
      const double change = s_t - k.s[1];
      k.s[1] = s_t;
      ix -= i.inverse_mass * tx * change;
      iy += i.inverse_mass * ty * change;
      jx += j.inverse_mass * tx * change;
      jy -= j.inverse_mass * ty * change;
      i.w -= i.inverse_inertia * k.spin * change;
      j.w -= j.inverse_inertia * k.spin * change;
    }
    i.vx = ix;
    i.vy = iy;
    j.vx = jx;
    j.vy = jy;
  }

 private:
  static constexpr std::size_t kRows = D;
  struct Contact {
    int i = 0, j = 0;
    double gx = 0, gy = 0, ratio = 0, spin = 0, mu = 0;
    double b[kRows] = {}, s[kRows] = {}, step[kRows] = {};
  };
  struct Body {
    double vx = 0, vy = 0, w = 0, inverse_mass = 0, inverse_inertia = 0;
  };

  std::vector<Contact> contacts_;
  std::vector<Body> bodies_;
  mutable Vector gathered_;
};

/// Calls f with a sweep through W, whose blocks are made if the operator has none.
template <int D, class F>
decltype(auto) with_explicit_sweep(const ContactProblem& p, const DelassusOperator& delassus,
                                   F&& f) {
  std::shared_ptr<const DelassusBlocks> blocks = delassus.blocks();
  if (!blocks && p.has_delassus()) blocks = std::make_shared<DelassusBlocks>(p.W, D);
  if (!blocks) {
    blocks = std::make_shared<DelassusBlocks>(assemble_delassus(p.A, p.H, p.dim), D);
  }
  return f(ExplicitSweep<D>(p, std::move(blocks)));
}

/// Calls f with the fastest sweep for the structure of the problem.
template <int D, class F>
decltype(auto) with_sweep(const ContactProblem& p, const DelassusOperator& delassus, F&& f) {
  if constexpr (D < 3) {
    if (const auto& disks = delassus.disks()) return f(DiskSweep<D>(p, *disks));
  } else if constexpr (D == 3) {
    if (const auto& spheres = delassus.bodies<3>()) return f(SphereSweep(p, *spheres));
  }
  constexpr int kPlanar = D == 1 ? 2 : 3;  // disks: (x, y) without friction, (x, y, spin) with
  if (TwoPassSweep<D, kPlanar>::fits(p)) return f(TwoPassSweep<D, kPlanar>(p));
  if (TwoPassSweep<D, 6>::fits(p)) return f(TwoPassSweep<D, 6>(p));
  return with_explicit_sweep<D>(p, delassus, f);
}

}  // namespace bipot
