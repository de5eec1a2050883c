#pragma once

#include <array>
#include <compare>
#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/lists.h"
#include "core/linear/sparse_factor.h"
#include "solvers/disks/disk_tiles.h"
#include "solvers/disks/stress_kernels.h"

namespace bipot {

/// Coarse space of the deflation: impulses of smooth stress fields in a packing of disks. Sweeps
/// through the contacts find these slowly, since a field that fills the packing is nearly in
/// balance.
///
/// The nodes of a grid have a stress each, bodies that of their centre, bilinear between the nodes.
/// A contact carries the impulse of stress_kernels.h. P maps stresses of the nodes to scaled
/// impulses. Contacts that are open or at the edge of their cone carry nothing.
class StressModes {
 public:
  /// `threads`: at most.
  StressModes(const DiskTiles<2>& tiles, const DiskStructure& disks, int threads = 1);

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  const StressKernels::ShareBatch* share() const { return share_.data(); }
  /// Determines the contacts that carry at x, which obeys Coulomb's law exactly at edges; then PᵀWP
  /// and its factor, unless nearly all are unchanged. False if there is no factor, or no modes.
  [[nodiscard]] bool renew(std::span<const ImpulseBatch<2>> x);
  /// PᵀWP of the last renew(): node after node σ_xx, σ_xy, σ_yy.
  const SparseMatrix& matrix() const { return matrix_; }

  /// Replaces rows of rates (StressKernels::RatesTask) by stresses, those of -(PᵀWP)⁻¹ Pᵀw. Requires
  /// a successful renew(). False if they would grow without bound, along stresses that move no body
  /// but have a rate. This happens for different restitution in a jammed place, where no solution
  /// exists.
  [[nodiscard]] bool relax(std::span<BodyRow> rows) const;
  /// Rows of stresses from those of the nodes.
  void interpolate(const Vector& nodes, std::span<BodyRow> rows) const;

 private:
  struct Node {
    int x, y;
    auto operator<=>(const Node&) const = default;
  };
  /// Cell of a body, and its position in it, 0 to 1. Bodies outside of the grid have no cell.
  struct Place {
    int cell = -1;
    float x = 0, y = 0;
    /// Weights of the cell's corners.
    std::array<double, 4> weights() const;
  };
  /// The nodes at the corners (0, 0), (1, 0), (0, 1), (1, 1).
  using Cell = std::array<int, 4>;
  /// Neighbours of a node in columns of matrix_, at most two away in x and y: -1, or their position
  /// in the column.
  using Neighbours = std::array<int, 25>;

  void place_bodies(const DiskStructure& disks);
  void list_rows();
  void list_contacts();
  void set_pattern();
  void assemble();
  void add_body(int row, const std::array<double, 3>& inverse);

  const DiskTiles<2>& tiles_;
  int threads_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  std::vector<Place> place_;  // of each row
  Lists<> rows_;              // of each cell
  Lists<> coloured_;          // the cells of each colour
  Lists<> lanes_;             // of the contacts of each row
  LargeVector<StressKernels::ShareBatch> share_;
  std::vector<Neighbours> neighbours_;
  SparseMatrix matrix_;
  SparseCholesky factor_;
  bool factored_ = false;
  double shift_ = 0;
};

}  // namespace bipot
