#include "tests/support/side_by_side.h"

#include <algorithm>

#include "core/base/triplets.h"

namespace bipot {

SideBySide side_by_side(const std::vector<ContactProblem>& parts) {
  SideBySide out;
  ContactProblem& p = out.problem;
  p.dim = parts.front().dim;
  int contacts = 0, dofs = 0, most = 0;
  for (const ContactProblem& part : parts) {
    contacts += part.num_contacts();
    dofs += part.num_dofs();
    most = std::max(most, part.num_contacts());
    out.place.emplace_back(to_size(part.num_contacts()));
  }
  for (int c = 0, next = 0; c < most; ++c) {
    for (std::size_t k = 0; k < parts.size(); ++k) {
      if (c < parts[k].num_contacts()) out.place[k][to_size(c)] = next++;
    }
  }
  const int d = p.dim;
  Triplets a, h, w;
  p.v_free.resize(dofs);
  p.u_free.resize(contacts * d);
  p.mu.resize(contacts);
  if (parts.front().row_scale.size() > 0) p.row_scale.resize(contacts * d);
  int first_dof = 0;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const ContactProblem& part = parts[k];
    const auto row = [&](Eigen::Index i) {
      return out.place[k][to_size(i / d)] * d + static_cast<int>(i % d);
    };
    for (int i = 0; i < part.num_rows(); ++i) {
      p.u_free[row(i)] = part.u_free[i];
      if (p.row_scale.size() > 0) p.row_scale[row(i)] = part.row_scale[i];
    }
    for (int c = 0; c < part.num_contacts(); ++c) p.mu[out.place[k][to_size(c)]] = part.mu[c];
    for (int i = 0; part.has_delassus() && i < part.num_rows(); ++i) {
      for (SparseRows::InnerIterator it(part.W, i); it; ++it) {
        w.emplace_back(row(i), row(it.col()), it.value());
      }
    }
    for (int i = 0; i < part.num_dofs(); ++i) p.v_free[first_dof + i] = part.v_free[i];
    for (int i = 0; i < part.A.outerSize(); ++i) {
      for (SparseMatrix::InnerIterator it(part.A, i); it; ++it) {
        a.emplace_back(first_dof + it.row(), first_dof + i, it.value());
      }
    }
    for (int i = 0; i < part.H.outerSize(); ++i) {
      for (SparseMatrix::InnerIterator it(part.H, i); it; ++it) {
        h.emplace_back(first_dof + it.row(), row(i), it.value());
      }
    }
    first_dof += part.num_dofs();
  }
  if (dofs > 0) {
    p.A = from_triplets(dofs, dofs, a);
    p.H = from_triplets(dofs, contacts * d, h);
  }
  if (!w.empty()) p.W = from_triplets<SparseRows>(contacts * d, contacts * d, w);
  return out;
}

}  // namespace bipot
