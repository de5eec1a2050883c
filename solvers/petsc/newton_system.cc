#include "solvers/petsc/newton_system.h"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "core/problem/delassus.h"

namespace bipot {

NewtonSystem::NewtonSystem(const ContactProblem& p, const Vector& delassus_diagonal,
                           Residual residual, bool mixed)
    : d_(p.dim),
      contacts_(p.num_contacts()),
      residual_(residual),
      mixed_(mixed),
      scaling_(equilibrated_scaling(p, delassus_diagonal)),
      b_(p.u_free.cwiseProduct(scaling_.velocity)),
      anchor_(Vector::Zero(p.num_rows())) {
  unit_ = b_.norm();
  b_ /= unit_;
  if (mixed_) {
    const Vector s = p.A.diagonal().cwiseSqrt().cwiseInverse();
    dofs_ = p.num_dofs();
    A_ = s.asDiagonal() * p.A * s.asDiagonal();
    H_ = SparseMatrix(s.asDiagonal() * p.H * scaling_.velocity.asDiagonal());
    H_.makeCompressed();
    H_rows_ = H_;
    diagonal_mass_ = is_diagonal(p.A);
    if (!diagonal_mass_ && !mass_factor_.factor(SparseMatrix(A_))) {
      throw std::runtime_error("the mass matrix A is not positive definite");
    }
  } else {
    W_ = SparseRows(scaling_.velocity.asDiagonal() * p.W * scaling_.velocity.asDiagonal());
  }
  build_pattern();
}

void NewtonSystem::set_proximal(double kappa, const Vector& anchor_impulse) {
  kappa_ = kappa;
  anchor_ = anchor_impulse.cwiseProduct(scaling_.impulse) / unit_;
}

Vector NewtonSystem::unknowns(const Vector& s) const {
  Vector z(size());
  z.tail(rows()) = s.cwiseProduct(scaling_.impulse) / unit_;
  if (mixed_) {
    const Vector wrench = H_ * z.tail(rows());
    z.head(dofs_) = diagonal_mass_ ? wrench : mass_factor_.solve(wrench);
  }
  return z;
}

Vector NewtonSystem::impulse(const double* z) const {
  return unit_ * scaled_impulse(z).cwiseQuotient(scaling_.impulse);
}

double NewtonSystem::proximal_residual(const double* z) const {
  return (scaled_impulse(z) - anchor_).norm() / kappa_;
}

void NewtonSystem::residual(const double* z, double* f) const {
  const Vector w = velocity(z);
  const Eigen::Map<const Vector> x = scaled_impulse(z);
  if (mixed_) {
    const Eigen::Map<const Vector> y(z, dofs_);
    Eigen::Map<Vector>(f, dofs_) = A_ * y - H_rows_ * x;
  }
  if (residual_ == Residual::kInequality) {
    Eigen::Map<Vector>(f + dofs_, rows()) = w;
    return;
  }
  dispatch_kind([&](auto d) {
    constexpr ContactRows D = d();
    for (int c = 0; c < contacts_; ++c) {
      Eigen::Map<Local<D>>(f + dofs_ + c * D) = equation<D>(c, x, w).f;
    }
  });
}

void NewtonSystem::jacobian(const double* z, double* values) const {
  const Vector w = velocity(z);
  const Eigen::Map<const Vector> x = scaled_impulse(z);
  if (mixed_) std::copy(fixed_values_.begin(), fixed_values_.end(), values);
  dispatch_kind([&](auto d) {
    constexpr ContactRows D = d();
    for (int c = 0; c < contacts_; ++c) {
      LocalResidual<D> r;
      if (residual_ == Residual::kInequality) {
        r.Q.setIdentity();
      } else {
        r = equation<D>(c, x, w);
      }
      fill_contact<D>(c, r, values);
    }
  });
}

Vector NewtonSystem::velocity(const double* z) const {
  const Eigen::Map<const Vector> x = scaled_impulse(z);
  Vector w = b_ + (x - anchor_) / kappa_;
  if (mixed_) {
    w += H_.transpose() * Eigen::Map<const Vector>(z, dofs_);
  } else {
    w += W_ * x;
  }
  return w;
}

/// Calls f with the ContactRows of the problem.
template <class F>
void NewtonSystem::dispatch_kind(const F& f) const {
  ContactProblem kind;
  kind.dim = d_;
  kind.mu_r = scaling_.mu_r;
  dispatch_rows(kind, f);
}

template <ContactRows D>
LocalResidual<D> NewtonSystem::equation(int c, const Eigen::Map<const Vector>& x,
                                        const Vector& w) const {
  const Local<D> xc = x.segment<D>(c * D), wc = w.segment<D>(c * D);
  if constexpr (!D.rolls) {
    if (residual_ == Residual::kFischerBurmeister) {
      return fischer_burmeister<D>(xc, wc, scaling_.mu[c]);
    }
  }
  return alart_curnier<D>(xc, wc, friction_of<D>(scaling_, c));
}

/// Row block of contact c: Q G on the coupled columns (G: rows of W' or of H'ᵀ), then P + Q / kappa
/// on the contact's own columns.
template <int D>
void NewtonSystem::fill_contact(int c, const LocalResidual<D>& r, double* values) const {
  const auto contact = to_size(c);
  const std::size_t begin = coupling_start_[contact];
  const std::size_t width = coupling_start_[contact + 1] - begin;
  const typename LocalResidual<D>::Block own = r.P + r.Q / kappa_;
  for (int a = 0; a < D; ++a) {
    double* row = values + row_start_[to_size(dofs_ + c * D + a)];
    const double* G = coupling_.data() + begin * D;
    for (std::size_t k = 0; k < width; ++k, G += D) {
      double sum = 0;
      for (int b = 0; b < D; ++b) sum += r.Q(a, b) * G[b];
      row[k] = sum;
    }
    if (mixed_) {
      for (int b = 0; b < D; ++b) row[width + to_size(b)] = own(a, b);
    } else {
      for (int b = 0; b < D; ++b) row[own_position_[contact] + b] += own(a, b);
    }
  }
}

/// Merges columns and values of the D rows of contact c in `block_rows`. `own`: the contact's own
/// columns are stored even if the rows have no entry there.
void NewtonSystem::add_coupling(const SparseRows& block_rows, int contact, bool own) {
  const auto D = to_size(d_);
  std::map<int, std::vector<double>> block;  // column -> D values, sorted
  for (int b = 0; own && b < d_; ++b) block[contact * d_ + b].assign(D, 0.0);
  for (int a = 0; a < d_; ++a) {
    for (SparseRows::InnerIterator it(block_rows, contact * d_ + a); it; ++it) {
      std::vector<double>& column = block[static_cast<int>(it.col())];
      column.resize(D, 0.0);
      column[to_size(a)] += it.value();
    }
  }
  for (const auto& [column, value] : block) {
    coupling_column_.push_back(column);
    coupling_.insert(coupling_.end(), value.begin(), value.end());
  }
  coupling_start_.push_back(coupling_column_.size());
  if (own) {
    own_position_.push_back(
        static_cast<int>(std::distance(block.begin(), block.find(contact * d_))));
  }
}

void NewtonSystem::build_pattern() {
  row_start_.assign(1, 0);
  for (int i = 0; i < dofs_; ++i) {
    for (SparseRows::InnerIterator it(A_, i); it; ++it) {
      columns_.push_back(static_cast<int>(it.col()));
      fixed_values_.push_back(it.value());
    }
    for (SparseRows::InnerIterator it(H_rows_, i); it; ++it) {
      columns_.push_back(dofs_ + static_cast<int>(it.col()));
      fixed_values_.push_back(-it.value());
    }
    row_start_.push_back(static_cast<int>(columns_.size()));
  }
  coupling_start_.assign(1, 0);
  const SparseRows wrenches = H_.transpose();
  for (int c = 0; c < contacts_; ++c) {
    add_coupling(mixed_ ? wrenches : W_, c, /*own=*/!mixed_);
    const auto first = static_cast<std::ptrdiff_t>(coupling_start_[to_size(c)]);
    for (int a = 0; a < d_; ++a) {
      columns_.insert(columns_.end(), coupling_column_.begin() + first, coupling_column_.end());
      for (int b = 0; mixed_ && b < d_; ++b) columns_.push_back(dofs_ + c * d_ + b);
      row_start_.push_back(static_cast<int>(columns_.size()));
    }
  }
}

}  // namespace bipot
