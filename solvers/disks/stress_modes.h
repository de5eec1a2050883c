#pragma once

#include <array>
#include <compare>
#include <span>
#include <vector>

#include "core/base/large_pages.h"
#include "core/linear/sparse_factor.h"
#include "solvers/disks/disk_tiles.h"
#include "solvers/disks/stress_kernels.h"

namespace bipot {

/// Impulses of smooth stress fields in a packing of disks: what sweeps through the contacts are slow
/// to find, as a field that fills the packing is nearly in balance.
///
/// The nodes of a grid have a stress each, bodies that of their centre, bilinear between the nodes;
/// a contact carries what stress_kernels.h says. P: from the stresses of the nodes to scaled
/// impulses. Contacts that are open or at the edge of their cone carry nothing.
class StressModes {
 public:
  StressModes(const DiskTiles<2>& tiles, const DiskStructure& disks);

  int num_nodes() const { return static_cast<int>(nodes_.size()); }
  const ShareBatch* share() const { return share_.data(); }
  /// Which contacts carry at x, which obeys Coulomb's law to the bit where it is at an edge; then PᵀWP
  /// and its factor, unless nearly all are as they were. False where there is none, or there are no modes.
  [[nodiscard]] bool renew(std::span<const ImpulseBatch<2>> x);
  /// PᵀWP as of the last renew(): node after node σ_xx, σ_xy, σ_yy.
  const SparseMatrix& matrix() const { return matrix_; }

  /// Rows of rates (StressRatesTask) become stresses, those of -(PᵀWP)⁻¹ Pᵀw. Requires a successful
  /// renew(). False where they would grow without bound: stresses that move nobody, along which there is a
  /// rate all the same, as where restitution differs in a jammed place and no solution exists.
  [[nodiscard]] bool relax(std::span<BodyRow> rows) const;
  /// Rows of stresses for those of the nodes.
  void interpolate(const Vector& nodes, std::span<BodyRow> rows) const;

 private:
  struct Node {
    int x, y;
    auto operator<=>(const Node&) const = default;
  };
  /// In which cell a body is, and where in it, 0 to 1. Bodies outside of all have no cell.
  struct Place {
    int cell = -1;
    float x = 0, y = 0;
    /// Of the cell's corners.
    std::array<double, 4> weights() const;
  };
  /// The nodes at the corners (0, 0), (1, 0), (0, 1), (1, 1).
  using Cell = std::array<int, 4>;
  /// Neighbours of a node in columns of matrix_, two at most away in x and y: -1, or how many come before.
  using Neighbours = std::array<int, 25>;

  void place_bodies(const DiskStructure& disks);
  void list_contacts();
  void set_pattern();
  void assemble();
  void add_body(int row, const std::array<double, 3>& inverse);

  const DiskTiles<2>& tiles_;
  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  std::vector<Place> place_;       // of each row
  std::vector<int> first_, lane_;  // lanes of the contacts of each row
  LargeVector<ShareBatch> share_;
  std::vector<Neighbours> neighbours_;
  SparseMatrix matrix_;
  SparseCholesky factor_;
  bool factored_ = false;
  double shift_ = 0;
};

}  // namespace bipot
