#pragma once

#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/problem/contact_problem.h"
#include "core/problem/disk_structure.h"
#include "solvers/disks/contact_tiles.h"
#include "solvers/disks/disk_kernels.h"
#include "solvers/disks/wavefront.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

/// Writes the inverse masses of a row of DiskTiles::inverse() into velocities.
inline void put_inverses(const SphereRow& inverse, SphereRow& velocity) {
  velocity.value[kRowInverseMass] = inverse.value[0];
  velocity.value[kRowInverseInertia] = inverse.value[kRowTurn];
}

/// A problem of disks or of spheres (D = 3), with rolling friction kRollingDisks and
/// kRollingSpheres, packed for the vector kernels, tile by tile: 48 constant bytes for each contact
/// and 32 for each body, 64 for either in space. Arrays of the kernels are indexed by batch and by row.
template <int D>
class DiskTiles {
 public:
  /// `scaling`: the variables x = impulse ∘ s of the kernels, with impulse = 1 / velocity. Ratios
  /// and friction coefficients that are equal to rounding (16 ε) are taken as equal, so that few
  /// LawBatch serve all. In space `bodies` must live as long: its frames turn impulses.
  DiskTiles(const ContactProblem& problem, const BodiesOf<D>& bodies, const ContactScaling& scaling)
      : DiskTiles(problem, bodies, scaling, tile_contacts(bodies)) {}
  /// The same with given tiles. `threads`: at most, of the functions below.
  DiskTiles(const ContactProblem& problem, const BodiesOf<D>& bodies, const ContactScaling& scaling,
            ContactTiles tiles, int threads = 1);

  static constexpr int kRows = kRowsOf<D>;
  using Rows = Eigen::Matrix<double, kRows, 1>;
  using Tile = ContactTiles::Tile;
  const ContactTiles& order() const { return tiles_; }
  int num_tiles() const { return static_cast<int>(tiles_.tiles.size()); }
  const Tile& tile(int t) const { return tiles_.tiles[to_size(t)]; }
  int num_rows() const { return tiles_.num_rows; }
  int num_batches() const { return tiles_.num_batches(); }

  /// The contacts from this batch on.
  PackedContacts<D> packed(int batch = 0) const {
    return {&contacts_[to_size(batch)], law_.data() + batch, laws_.data()};
  }
  const RowOf<D>* inverse() const { return inverse_.data(); }
  int row(int body) const { return tiles_.row[to_size(body)]; }
  /// The contact in a lane, kLanes for each batch; -1: none.
  int contact(int lane) const { return tiles_.contact[to_size(lane)]; }
  /// s of the contact in a lane.
  Rows impulse(std::span<const ImpulseBatch<D>> x, int lane) const {
    const int c = contact(lane);
    Rows s;
    for (int k = 0; k < kRows; ++k) s[k] = x[to_size(lane / kLanes)].x[k][lane % kLanes];
    if constexpr (kOfSpheres<D>) s = in_rows(lane, s);
    return s.cwiseProduct(velocity_scale_.template segment<kRows>(c * kRows));
  }

  /// Divides the variables by `factor`: x, the impulses of this packing, too.
  void rescale(double factor);

  /// With sigma in the offset of w_n, sigma <- sigma + kappa (mu |w_t| - sigma). w: the velocity at
  /// the impulses of this momentum; without any, sigma <- (1 - kappa) sigma.
  void follow(double kappa, std::span<const RowOf<D>> momentum, const Vector& u_free);

  /// Writes x = impulse ∘ s into the lanes.
  void pack(const Vector& s, std::span<ImpulseBatch<D>> x) const;
  /// Sets the rows to Σ ± g x.
  void push(std::span<const ImpulseBatch<D>> x, std::span<RowOf<D>> momentum) const;
  /// Sets the rows to the same times inverse().
  void velocities(std::span<const ImpulseBatch<D>> x, std::span<RowOf<D>> velocity) const;
  /// s = x / impulse.
  void unpack(std::span<const ImpulseBatch<D>> x, Vector& s) const;

  /// Bytes that an iteration streams, for each batch and for each row.
  struct Streamed {
    std::size_t batch, row;
  };
  /// True if these data should be prefetched. For data in near caches prefetching costs more than
  /// it saves.
  bool asks_ahead(Streamed bytes) const;
  /// Pipeline that fits the caches.
  Pipeline pipeline(int threads, Streamed bytes) const;

 private:
  /// Of the contact in a lane: the rows are n, t1 and t2, with the lane's normal. Spheres alone.
  Eigen::Matrix3d frame(int lane) const;
  /// Impulses or velocities of a contact of spheres by its rows, from vectors in space; and back.
  Rows in_rows(int lane, const Rows& in_space) const;
  Rows in_space(int lane, const Rows& in_rows) const;
  int law_number(const LawBatch& law);
  std::size_t in_all(Streamed bytes) const;

  ContactTiles tiles_;
  int threads_;
  Vector velocity_scale_;
  LargeVector<ContactBatch<D>> contacts_;
  std::vector<int> law_;
  std::vector<LawBatch> laws_;
  LargeVector<RowOf<D>> inverse_;
  const BodiesOf<D>* bodies_;
};

}  // namespace bipot
