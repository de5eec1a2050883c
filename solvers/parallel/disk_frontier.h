#pragma once

#include <optional>
#include <span>
#include <vector>

#include "solvers/disks/tiled_gradient.h"
#include "solvers/parallel/distributed_space.h"

namespace bipot {

/// Parallel part of the vector kernels for disks. It adds the halo's impulses to the rows of the
/// bodies here after every iteration, and the other processes' parts to the sums.
///
/// A body shared by several processes has its row on each of them, summed in another order. The
/// rows agree to rounding, and so do iterates and those of one process. (DistributedSpace's own
/// product has the same bits for any number of processes, but is slower.)
template <int D>
class DiskFrontier final : public TiledGradient<D>::Neighbours {
 public:
  /// The structure of the owned contacts if the vector kernels can handle the whole problem, as all
  /// processes determine together: disks everywhere, and no degree of freedom that every process
  /// has.
  static std::optional<DiskStructure> structure(DistributedSpace& space);

  /// Keeps a reference to the space, which must have a structure.
  explicit DiskFrontier(DistributedSpace& space);

  void complete(const DiskTiles<D>& tiles, std::span<const ImpulseBatch<D>> x,
                std::span<RowOf<D>> momentum) override;
  GradientKernel::Progress total(const DiskTiles<D>& tiles, const GradientKernel::Progress& here,
                                 std::span<const RowOf<D>> now,
                                 std::span<const RowOf<D>> before) override;

 private:
  /// A contact of the halo, and the bodies here on which it acts; -1: none.
  struct Pushed {
    int halo = 0, i = -1, j = -1;
    DiskStructure::Contact contact;
  };
  /// A body here that other processes share.
  struct Shared {
    int body = 0;
    double elsewhere = 0;  ///< the part of its energy that they count
  };

  void find_sent(const DiskTiles<D>& tiles);

  DistributedSpace& space_;
  std::vector<Pushed> pushes_;
  std::vector<Shared> shared_;
  std::vector<int> sent_;  ///< lanes of the contacts that may be in others' halos
  bool found_ = false;
  Vector s_;  ///< in the rows of the owned contacts; those sent are up to date
};

}  // namespace bipot
