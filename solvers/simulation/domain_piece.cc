#include "solvers/simulation/domain_piece.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/problem/packed_bodies.h"

namespace bipot {
namespace {

/// Rows of the bodies: their places with the halo, and the processes that need them.
template <int D>
void follow_rows(const LocalBodies<D>& local, const Midpoint<D>& mid,
                 const LocalContacts<D>& contacts, int bodies, DomainPiece& out) {
  const DofMap& own = out.own.dofs;
  ProblemPiece& piece = out.piece;
  // Processes with contacts of a body: all of these contacts are here.
  std::vector<std::pair<int, int>> pushes;  // body, owner
  for (const Contact<D>& c : contacts.all) {
    const int owner = local.owner[to_size(c.i)];
    pushes.emplace_back(c.i, owner);
    if (to_size(c.j) < mid.bodies.size()) pushes.emplace_back(c.j, owner);
  }
  std::sort(pushes.begin(), pushes.end());
  pushes.erase(std::unique(pushes.begin(), pushes.end()), pushes.end());
  std::vector<int> sharers(mid.bodies.size(), 0);
  for (const auto& [body, owner] : pushes) ++sharers[to_size(body)];
  const std::size_t rows = to_size(own.size);
  piece.dof_with_halo.assign(rows, -1);
  piece.dof_number.assign(rows, 0);
  piece.sharers.assign(rows, 1);
  for (std::size_t k = 0; k < mid.bodies.size(); ++k) {
    if (own.disk[k] < 0) continue;
    for (int x = 0; x < own.per_disk; ++x) {
      const std::size_t row = to_size(own.disk[k] + x);
      piece.dof_with_halo[row] = out.with_halo.disk[k] + x;
      piece.dof_number[row] = local.numbers[k] * own.per_disk + x;
      piece.sharers[row] = std::max(1, sharers[k]);
    }
  }
  for (std::size_t w = 0; w < mid.walls.size(); ++w) {
    if (own.wall[w] < 0) continue;
    piece.dof_number[to_size(own.wall[w])] = bodies * own.per_disk + static_cast<int>(w);
  }
}

/// Driven walls in contact are on every process.
template <int D>
void follow_walls(const Midpoint<D>& mid, ProcessGroup& group, DomainPiece& out) {
  const DofMap& own = out.own.dofs;
  ProblemPiece& piece = out.piece;
  std::vector<std::int64_t> touched;
  for (const int row : own.wall) touched.push_back(row >= 0 ? 1 : 0);
  const bool driven = std::any_of(mid.walls.begin(), mid.walls.end(), [](const Wall<D>& w) {
    return w.motion == Wall<D>::Motion::kDriven;
  });
  if (!driven) return;
  group.sum(touched);
  std::vector<int> place(to_size(own.size), -1);
  for (std::size_t w = 0; w < touched.size(); ++w) {
    if (touched[w] == 0) continue;
    if (own.wall[w] >= 0) {
      place[to_size(own.wall[w])] = static_cast<int>(out.wall.size());
      piece.sharers[to_size(own.wall[w])] = static_cast<int>(touched[w]);
    }
    out.wall.push_back(static_cast<int>(w));
    piece.everywhere_inverse_mass.push_back(1 / mid.walls[w].mass);
    piece.everywhere_own_dof.push_back(own.wall[w]);
  }
  for (int row = 0; row < piece.own.num_rows(); ++row) {
    for (SparseMatrix::InnerIterator it(piece.own.H, row); it; ++it) {
      const int dof = place[to_size(it.row())];
      if (dof >= 0) piece.everywhere.push_back({row, dof, it.value()});
    }
  }
}

}  // namespace

void exchange(ContactProblem& a, ContactProblem& b) {
  std::swap(a.dim, b.dim);
  a.A.swap(b.A);
  a.H.swap(b.H);
  a.W.swap(b.W);
  a.v_free.swap(b.v_free);
  a.u_free.swap(b.u_free);
  a.mu.swap(b.mu);
  a.mu_r.swap(b.mu_r);
  a.mu_spin.swap(b.mu_spin);
  a.row_scale.swap(b.row_scale);
}

template <int D>
DomainPiece assemble_piece(const Scene<D>& scene, const LocalBodies<D>& local,
                           const Midpoint<D>& mid, const LocalContacts<D>& contacts, int bodies,
                           ProcessGroup& group) {
  DomainPiece out;
  StepInput<D> input{scene, mid.bodies, mid.walls, contacts.own, mid.disk_v_free, mid.wall_v_free};
  out.own = assemble_step(input);
  // With the halo no wall has a row of its own: its terms are summed over all processes
  // (everywhere).
  std::vector<Wall<D>> standing = mid.walls;
  for (Wall<D>& w : standing) {
    if (w.motion == Wall<D>::Motion::kDriven) w.motion = Wall<D>::Motion::kMoving;
  }
  input.walls = standing;
  input.contacts = contacts.all;
  AssembledStep with_halo = assemble_step(input);
  ProblemPiece& piece = out.piece;
  piece.whole_contacts = contacts.whole;
  exchange(piece.own, out.own.problem);
  exchange(piece.with_halo, with_halo.problem);
  out.with_halo = std::move(with_halo.dofs);
  piece.owned = contacts.owned;
  piece.halo = contacts.halo;
  piece.number = contacts.number;
  piece.copies = contacts.copies;
  // If one process has contacts that are not of disks, DistributedSpace uses the general form on
  // all.
  piece.packed =
      piece.own.num_contacts() == 0 || disk_structure(piece.own) || sphere_structure(piece.own);
  follow_rows(local, mid, contacts, bodies, out);
  follow_walls(mid, group, out);
  return out;
}

template DomainPiece assemble_piece(const Scene<2>&, const LocalBodies<2>&, const Midpoint<2>&,
                                    const LocalContacts<2>&, int, ProcessGroup&);
template DomainPiece assemble_piece(const Scene<3>&, const LocalBodies<3>&, const Midpoint<3>&,
                                    const LocalContacts<3>&, int, ProcessGroup&);

}  // namespace bipot
