#pragma once

#include <optional>
#include <span>
#include <vector>

#include "solvers/disks/tiled_gradient.h"
#include "solvers/parallel/distributed_space.h"

namespace bipot {

/// What the vector kernels for disks do not have of a problem that lies on several processes: the
/// halo's impulses, pushed into the rows of the bodies here after every iteration, and the parts that
/// other processes have of the sums.
///
/// A body that several processes push has its row on each of them, summed in another order: the rows
/// agree to rounding, and so do iterates and those of one process. (DistributedSpace's own product
/// has the same bits for any number of processes, at about three times the time of an iteration.)
template <int D>
class DiskFrontier final : public GradientNeighbours<D> {
 public:
  /// The structure of the owned contacts where the vector kernels can take the whole problem, which
  /// all processes find together: disks everywhere, and no degree of freedom that every process has.
  static std::optional<DiskStructure> structure(DistributedSpace& space);

  /// Keeps a reference to the space, which must have a structure.
  explicit DiskFrontier(DistributedSpace& space);

  void complete(const DiskTiles<D>& tiles, std::span<const ImpulseBatch<D>> x,
                std::span<BodyRow> momentum) override;
  GradientProgress total(const DiskTiles<D>& tiles, const GradientProgress& here,
                         std::span<const BodyRow> now, std::span<const BodyRow> before) override;

 private:
  /// A contact of the halo and the bodies here that it pushes; -1: none.
  struct Push {
    int halo = 0, i = -1, j = -1;
    DiskStructure::Contact contact;
  };
  /// A body here that other processes push as well.
  struct Shared {
    int body = 0;
    double elsewhere = 0;  ///< the part of its energy that they count
  };

  void find_sent(const DiskTiles<D>& tiles);

  DistributedSpace& space_;
  std::vector<Push> pushes_;
  std::vector<Shared> shared_;
  std::vector<int> sent_;  ///< lanes of the contacts that are in others' halos, perhaps
  bool found_ = false;
  Vector s_;  ///< in the rows of the owned contacts; those sent are up to date
};

}  // namespace bipot
