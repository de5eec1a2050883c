#include "solvers/parallel/distributed_space.h"

#include <algorithm>

namespace bipot {

DistributedSpace::DistributedSpace(const ProblemPiece& piece, ProcessGroup& group, bool exact)
    : piece_(piece),
      group_(group),
      exact_(exact),
      exchange_(group.make_exchange(piece.own.num_contacts(), piece.copies)),
      inverse_mass_(piece.with_halo.A.diagonal().cwiseInverse()),
      velocity_(piece.with_halo.num_dofs()),
      any_everywhere_(!piece.everywhere_inverse_mass.empty()),
      momentum_(piece.everywhere_inverse_mass.size()),
      halo_(piece.halo.size() * to_size(piece.own.dim)),
      s_all_(Vector::Zero(piece.with_halo.num_rows())),
      u_all_(Vector::Zero(piece.with_halo.num_rows())) {
  const ContactProblem& p = piece.with_halo;
  if (piece.disks && p.num_contacts() > 0) disks_.emplace(p, DelassusOperator::Form::kTwoPass);
  // All take the packed form or none does: it rounds in other places.
  all_disks_ = !group.any(p.num_contacts() > 0 && !(disks_ && disks_->disks()));
  if (!all_disks_) disks_.reset();
  const Vector inverse_own = piece.own.A.diagonal().cwiseInverse();
  diagonal_ = Vector::Zero(piece.own.num_rows());
  for (int i = 0; i < piece.own.num_rows(); ++i) {
    for (SparseMatrix::InnerIterator it(piece.own.H, i); it; ++it) {
      diagonal_[i] += it.value() * it.value() * inverse_own[it.row()];
    }
  }
}

const std::vector<double>& DistributedSpace::halo(const Vector& s) {
  exchange_->copy({s.data(), to_size(s.size())}, halo_, piece_.own.dim);
  return halo_;
}

/// s_all_ <- the impulses of the owned contacts and of the halo.
void DistributedSpace::fill(const Vector& s) {
  const int d = piece_.own.dim;
  halo(s);
  const double* from = s.data();
  for (const int place : piece_.owned) {
    for (int k = 0; k < d; ++k) s_all_[place * d + k] = *from++;
  }
  from = halo_.data();
  for (const int place : piece_.halo) {
    for (int k = 0; k < d; ++k) s_all_[place * d + k] = *from++;
  }
}

const std::vector<double>& DistributedSpace::everywhere_momentum(const Vector& s) {
  if (!any_everywhere_) return momentum_;
  if (exact_) {
    std::vector<ExactSum> sums(momentum_.size());
    for (const auto& e : piece_.everywhere) sums[to_size(e.dof)] += e.value * s[e.row];
    totals(sums, momentum_);
    return momentum_;
  }
  std::fill(momentum_.begin(), momentum_.end(), 0.0);
  for (const auto& e : piece_.everywhere) momentum_[to_size(e.dof)] += e.value * s[e.row];
  group_.sum(momentum_);
  return momentum_;
}

/// u_all_ <- W s_all_, right in the rows of the owned contacts.
void DistributedSpace::product() {
  if (disks_) {
    disks_->apply(s_all_, u_all_);
    return;
  }
  const ContactProblem& p = piece_.with_halo;
  velocity_.noalias() = p.H * s_all_;
  velocity_.array() *= inverse_mass_.array();
  u_all_.noalias() = p.H.transpose() * velocity_;
}

void DistributedSpace::apply(const Vector& s, Vector& u) {
  fill(s);
  product();
  const int d = piece_.own.dim;
  u.resize(s.size());
  double* to = u.data();
  for (const int place : piece_.owned) {
    for (int k = 0; k < d; ++k) *to++ = u_all_[place * d + k];
  }
  everywhere_momentum(s);
  for (const auto& e : piece_.everywhere) {
    const std::size_t dof = to_size(e.dof);
    u[e.row] += e.value * (piece_.everywhere_inverse_mass[dof] * momentum_[dof]);
  }
}

void DistributedSpace::with_halo(const Vector& s, Vector& all) {
  fill(s);
  all = s_all_;
}

void DistributedSpace::velocity(const Vector& s, Vector& u) {
  apply(s, u);
  u += piece_.own.u_free;
}

void DistributedSpace::body_velocities(const Vector& s, Vector& v) {
  fill(s);
  const Vector wrench = piece_.with_halo.H * s_all_;
  everywhere_momentum(s);
  v = piece_.own.v_free;
  for (std::size_t k = 0; k < momentum_.size(); ++k) {
    const int dof = piece_.everywhere_own_dof[k];
    if (dof >= 0) v[dof] += piece_.everywhere_inverse_mass[k] * momentum_[k];
  }
  for (int dof = 0; dof < v.size(); ++dof) {
    const int place = piece_.dof_with_halo[to_size(dof)];
    if (place >= 0) v[dof] += inverse_mass_[place] * wrench[place];
  }
}

double DistributedSpace::total(ExactSum& sum) {
  group_.sum(sum.digits());
  return sum.value();
}

void DistributedSpace::totals(std::span<ExactSum> sums, std::span<double> values) {
  digits_.clear();
  for (ExactSum& sum : sums) {
    const auto part = sum.digits();
    digits_.insert(digits_.end(), part.begin(), part.end());
  }
  group_.sum(digits_);
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const auto first = digits_.begin() + static_cast<std::ptrdiff_t>(k * ExactSum::kDigits);
    std::copy_n(first, ExactSum::kDigits, sums[k].digits().begin());
    values[k] = sums[k].value();
  }
}

}  // namespace bipot
