#include "solvers/parallel/disk_frontier.h"

#include "core/problem/packed_motion.h"

namespace bipot {

template <int D>
std::optional<DiskStructure> DiskFrontier<D>::structure(DistributedSpace& space) {
  const ContactProblem& own = space.problem();
  std::optional<DiskStructure> disks;
  if (space.disks() && space.piece().everywhere_inverse_mass.empty()) {
    disks =
        own.num_contacts() > 0 ? disk_structure(own) : DiskStructure{{}, {DiskStructure::Body{}}};
  }
  if (space.group().any(!disks)) disks.reset();
  return disks;
}

template <int D>
DiskFrontier<D>::DiskFrontier(DistributedSpace& space)
    : space_(space), s_(Vector::Zero(space.problem().num_rows())) {
  constexpr int kPerBody = D == 1 ? 2 : 3;
  const ProblemPiece& piece = space.piece();
  if (piece.own.num_contacts() == 0) return;
  const DiskStructure& all = space.halo_disks();
  std::vector<int> here(all.bodies.size(), -1);
  for (std::size_t dof = 0; dof < piece.dof_with_halo.size(); dof += kPerBody) {
    const int body = static_cast<int>(dof) / kPerBody;
    here[to_size(piece.dof_with_halo[dof] / kPerBody)] = body;
    const int sharers = piece.sharers[dof];
    if (sharers > 1) shared_.push_back({body, 1 - 1.0 / sharers});
  }
  for (std::size_t k = 0; k < piece.halo.size(); ++k) {
    const DiskStructure::Contact& contact = all.contacts[to_size(piece.halo[k])];
    const int i = here[to_size(contact.i)], j = here[to_size(contact.j)];
    if (i >= 0 || j >= 0) pushes_.push_back({static_cast<int>(k), i, j, contact});
  }
}

/// Contacts of bodies shared with other processes: only those can be in a halo.
template <int D>
void DiskFrontier<D>::find_sent(const DiskTiles<D>& tiles) {
  found_ = true;
  const ProblemPiece& piece = space_.piece();
  for (int lane = 0; lane < tiles.num_batches() * kLanes; ++lane) {
    if (tiles.contact(lane) < 0) continue;
    for (SparseMatrix::InnerIterator it(piece.own.H, tiles.contact(lane) * D); it; ++it) {
      if (piece.sharers[to_size(it.row())] <= 1) continue;
      sent_.push_back(lane);
      break;
    }
  }
}

template <int D>
void DiskFrontier<D>::complete(const DiskTiles<D>& tiles, std::span<const ImpulseBatch<D>> x,
                               std::span<RowOf<D>> momentum) {
  if (!found_) find_sent(tiles);
  for (const int lane : sent_) {
    s_.template segment<D>(tiles.contact(lane) * D) = tiles.impulse(x, lane);
  }
  const std::vector<double>& halo = space_.halo(s_);
  for (const Pushed& by : pushes_) {
    const double* const s = halo.data() + to_size(by.halo) * D;
    const Push<D> p = push<D>(by.contact, s);
    const auto add = [&](int body, double along) {
      if (body < 0) return;
      double* const row = momentum[to_size(tiles.row(body))].value;
      row[kRowX] += along * p.force[0];
      row[kRowY] += along * p.force[1];
      row[kRowSpin] -= p.spin[0];
    };
    add(by.i, 1);
    add(by.j, -1);
  }
}

template <int D>
GradientKernel::Progress DiskFrontier<D>::total(const DiskTiles<D>& tiles,
                                                const GradientKernel::Progress& here,
                                                std::span<const RowOf<D>> now,
                                                std::span<const RowOf<D>> before) {
  double values[3] = {here.turn, here.change2, here.energy};
  for (const Shared& shared : shared_) {
    const std::size_t row = to_size(tiles.row(shared.body));
    double energy = 0;
    for (const int k : {kRowX, kRowY, kRowSpin}) {
      const double change = now[row].value[k] - before[row].value[k];
      energy += tiles.inverse()[row].value[k] * change * change;
    }
    values[2] -= shared.elsewhere * energy;
  }
  space_.sum(values);
  return {values[0], values[1], values[2]};
}

template class DiskFrontier<1>;
template class DiskFrontier<2>;

}  // namespace bipot
