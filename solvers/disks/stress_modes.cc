#include "solvers/disks/stress_modes.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/base/parallel.h"
#include "solvers/disks/disk_positions.h"

namespace bipot {
namespace {

/// Mean diameters along a cell of the grid. Fewer nodes are cheaper.
constexpr double kCellDiameters = 12;
/// Largest arms along a cell: all neighbours of a body are then within two cells each way.
constexpr double kCellArms = 4.2;
/// Number of cells from the first body to the end of cell numbers.
constexpr double kFarthest = 1e8;
/// Least number of bodies of a packing with stresses: fewer are in balance at once.
constexpr int kFewestCompanions = 400;
/// Keeps PᵀWP definite for stresses that move no body, such as a uniform one in a packing without
/// walls.
constexpr double kShift = 1e-10;
/// Largest part of the energy gained by the stresses that may be due to the shift.
constexpr double kIdle = 0.1;

/// Reciprocal of the fraction of contacts whose membership may be outdated.
constexpr std::size_t kUnchanged = 100;

constexpr int kPatch = 3;  ///< nodes each way around a body and its neighbours
constexpr int kReach = 2;  ///< nodes between two that the same body joins

/// Cells this far apart join no two nodes twice: they may be assembled at the same time.
constexpr int kApart = kPatch + 1;
constexpr int kColours = kApart * kApart;

int stencil(int dx, int dy) { return dx + kReach + (2 * kReach + 1) * (dy + kReach); }

/// Places of σ_xx, σ_xy, σ_yy, or of their rates, in a row.
constexpr int kSlots[] = {kRowX, kRowSpin, kRowY};

int row_at(unsigned offset) { return static_cast<int>(offset / sizeof(BodyRow)); }

/// Surroundings and walls: they have no stress.
bool is_outside(const DiskTiles<2>& tiles, int row) {
  const BodyRow& inverse = tiles.inverse()[row];
  return inverse.value[kRowX] == 0 || inverse.value[kRowSpin] < 0;
}

}  // namespace

std::array<double, 4> StressModes::Place::weights() const {
  const double fx = x, fy = y;
  return {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
}

StressModes::StressModes(const DiskTiles<2>& tiles, const DiskStructure& disks, int threads)
    : tiles_(tiles),
      threads_(threads),
      place_(to_size(tiles.num_rows())),
      share_(to_size(tiles.num_batches())) {
  place_bodies(disks);
  list_rows();
  list_contacts();
  set_pattern();
}

/// Cells and nodes of the grid that bodies need, in ascending order.
void StressModes::place_bodies(const DiskStructure& disks) {
  const int bodies = disks.surroundings();
  double sum = 0, largest = 0;
  int touching = 0;  // bodies without contacts have no arm
  for (int k = 0; k < bodies; ++k) {
    const double arm = std::abs(disks.bodies[to_size(k)].arm);  // negative in a hollow drum
    sum += arm;
    largest = std::max(largest, arm);
    if (arm > 0) ++touching;
  }
  const double cell =
      std::max(2 * kCellDiameters * sum / std::max(touching, 1), kCellArms * largest);
  if (!(cell > 0) || !std::isfinite(cell)) return;
  const DiskPositions positions = disk_positions(disks, 2 * cell);
  std::vector<Node> corner(to_size(bodies)), cells;  // the first of each cell
  for (int k = 0; k < bodies; ++k) {
    if (positions.companions[to_size(k)] < kFewestCompanions) continue;
    const Vec2 at = positions.centre[to_size(k)] / cell;
    const double x = std::floor(at.x()), y = std::floor(at.y());
    if (!(std::max(std::abs(x), std::abs(y)) < kFarthest)) continue;
    corner[to_size(k)] = {static_cast<int>(x), static_cast<int>(y)};
    Place& place = place_[to_size(tiles_.row(k))];
    place.cell = 0;
    place.x = static_cast<float>(at.x() - x);
    place.y = static_cast<float>(at.y() - y);
    // Bodies follow the packing: mostly several of one cell in sequence.
    if (cells.empty() || cells.back() != corner[to_size(k)]) cells.push_back(corner[to_size(k)]);
  }
  const auto make_unique = [](std::vector<Node>& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  };
  const auto find = [](const std::vector<Node>& list, Node node) {
    return static_cast<int>(std::lower_bound(list.begin(), list.end(), node) - list.begin());
  };
  make_unique(cells);
  for (const Node& c : cells) {
    for (const int dy : {0, 1}) {
      for (const int dx : {0, 1}) nodes_.push_back({c.x + dx, c.y + dy});
    }
  }
  make_unique(nodes_);
  for (const Node& c : cells) {
    cells_.push_back({find(nodes_, c), find(nodes_, {c.x + 1, c.y}), find(nodes_, {c.x, c.y + 1}),
                      find(nodes_, {c.x + 1, c.y + 1})});
  }
  for (int k = 0; k < bodies; ++k) {
    Place& place = place_[to_size(tiles_.row(k))];
    if (place.cell == 0) place.cell = find(cells, corner[to_size(k)]);
  }
}

void StressModes::list_rows() {
  rows_ = make_lists(static_cast<int>(cells_.size()), [&](const auto& put) {
    for (std::size_t row = 0; row < place_.size(); ++row) {
      if (place_[row].cell >= 0) put(place_[row].cell, static_cast<int>(row));
    }
  });
  const auto colour = [&](int cell) {
    const Node low = nodes_[to_size(cells_[to_size(cell)][0])];
    // Places are negative too.
    const auto part = [](int place) { return (place % kApart + kApart) % kApart; };
    return part(low.x) + kApart * part(low.y);
  };
  coloured_ = make_lists(kColours, [&](const auto& put) {
    for (int cell = 0; cell < rows_.count(); ++cell) put(colour(cell), cell);
  });
}

/// Lists the contacts of each row that may carry. Excluded are contacts of a body whose neighbours
/// are not within two cells each way, as in packings with a periodic side.
void StressModes::list_contacts() {
  const int rows = tiles_.num_rows();
  const ContactBatch<2>* const contacts = tiles_.packed().contact;
  const auto each_lane = [&](auto&& visit) {
    for (int lane = 0; lane < tiles_.num_batches() * kLanes; ++lane) {
      if (tiles_.contact(lane) < 0) continue;
      const ContactBatch<2>& c = contacts[lane / kLanes];
      visit(lane, row_at(c.i[lane % kLanes]), row_at(c.j[lane % kLanes]));
    }
  };
  const auto corner = [&](int row) {
    return nodes_[to_size(cells_[to_size(place_[to_size(row)].cell)][0])];
  };
  struct Range {
    Node low{0, 0}, high{0, 0};
    void add(Node n) {
      low = {std::min(low.x, n.x), std::min(low.y, n.y)};
      high = {std::max(high.x, n.x), std::max(high.y, n.y)};
    }
    bool wide() const { return high.x - low.x > 1 || high.y - low.y > 1; }
  };
  std::vector<Range> range(to_size(rows));
  const auto placed = [&](int row) { return place_[to_size(row)].cell >= 0; };
  for (int row = 0; row < rows; ++row) {
    if (placed(row)) range[to_size(row)] = {corner(row), corner(row)};
  }
  each_lane([&](int, int i, int j) {
    if (!placed(i) || !placed(j)) return;
    range[to_size(i)].add(corner(j));
    range[to_size(j)].add(corner(i));
  });
  const auto may_carry = [&](int i, int j) {
    if (!placed(i) || range[to_size(i)].wide()) return false;
    return is_outside(tiles_, j) || (placed(j) && !range[to_size(j)].wide());
  };
  lanes_ = make_lists(rows, [&](const auto& put) {
    each_lane([&](int lane, int i, int j) {
      if (!may_carry(i, j)) return;
      put(i, lane);
      if (!is_outside(tiles_, j)) put(j, lane);
    });
  });
}

void StressModes::set_pattern() {
  const int nodes = num_nodes();
  std::vector<int> rows, per_column(to_size(nodes), 0);
  neighbours_.resize(to_size(nodes));
  for (int b = 0; b < nodes; ++b) {
    Neighbours& known = neighbours_[to_size(b)];
    known.fill(-1);
    // In the order of the nodes: x before y.
    for (int dx = -kReach; dx <= kReach; ++dx) {
      for (int dy = -kReach; dy <= kReach; ++dy) {
        const Node at{nodes_[to_size(b)].x + dx, nodes_[to_size(b)].y + dy};
        const auto found = std::lower_bound(nodes_.begin(), nodes_.end(), at);
        if (found == nodes_.end() || *found != at) continue;
        known[to_size(stencil(dx, dy))] = per_column[to_size(b)]++;
        rows.push_back(static_cast<int>(found - nodes_.begin()));
      }
    }
  }
  matrix_.resize(3 * nodes, 3 * nodes);
  matrix_.resizeNonZeros(static_cast<Eigen::Index>(9 * rows.size()));
  int entry = 0, neighbour = 0;
  for (int b = 0; b < nodes; ++b) {
    for (int k = 0; k < 3; ++k) {
      matrix_.outerIndexPtr()[3 * b + k] = entry;
      for (int n = 0; n < per_column[to_size(b)]; ++n) {
        for (int r = 0; r < 3; ++r) {
          matrix_.innerIndexPtr()[entry++] = 3 * rows[to_size(neighbour + n)] + r;
        }
      }
    }
    neighbour += per_column[to_size(b)];
  }
  matrix_.outerIndexPtr()[3 * nodes] = entry;
}

bool StressModes::renew(std::span<const ImpulseBatch<2>> x) {
  if (lanes_.items.empty()) return false;
  const auto tiles = tiles_.packed();
  const auto share_at = [&](int lane) {
    const int batch = lane / kLanes, at = lane % kLanes;
    const double normal = x[to_size(batch)].x[0][at], tangential = x[to_size(batch)].x[1][at];
    const bool within =
        normal > 0 && std::abs(tangential) < tiles.laws[tiles.law[batch]].mu[at] * normal;
    const bool pair = !is_outside(tiles_, row_at(tiles.contact[batch].j[at]));
    return !within ? 0 : pair ? 0.5 : 1;
  };
  std::atomic<std::size_t> changed = 0;
  run_pieces(threads_, static_cast<int>(lanes_.items.size()), [&](int first, int last) {
    std::size_t here = 0;
    for (int k = first; k < last; ++k) {
      const int lane = lanes_.items[to_size(k)];
      if (share_at(lane) != share_[to_size(lane / kLanes)].share[lane % kLanes]) ++here;
    }
    changed += here;
  });
  if (factored_ && changed * kUnchanged < lanes_.items.size()) return true;
  for (const int lane : lanes_.items) {
    share_[to_size(lane / kLanes)].share[lane % kLanes] = share_at(lane);
  }
  assemble();
  factored_ = factor_.factor(matrix_);
  return factored_;
}

void StressModes::assemble() {
  std::fill_n(matrix_.valuePtr(), matrix_.nonZeros(), 0.0);
  const int* const starts = coloured_.start.data();
  run_phases(threads_, kColours, starts, starts + 1, [&](int, int k) {
    for (const int row : rows_.of(coloured_.items[to_size(k)])) {
      if (lanes_.of(row).empty()) continue;
      const BodyRow& inverse = tiles_.inverse()[row];
      add_body(row, {inverse.value[kRowX], inverse.value[kRowSpin], inverse.value[kRowY]});
    }
  });
  shift_ = kShift * matrix_.diagonal().maxCoeff();
  for (int k = 0; k < matrix_.rows(); ++k) matrix_.coeffRef(k, k) += shift_;
}

/// Adds (wrench of P)ᵀ inverse (wrench of P) of one body.
void StressModes::add_body(int row, const std::array<double, 3>& inverse) {
  const auto tiles = tiles_.packed();
  const Place& own = place_[to_size(row)];
  const std::array<double, 4> own_weights = own.weights();
  const auto cell = [&](const Place& place) -> const Cell& { return cells_[to_size(place.cell)]; };
  Node low = nodes_[to_size(cell(own)[0])];
  const auto place_of_other = [&](int lane) -> const Place& {
    const ContactBatch<2>& c = tiles.contact[lane / kLanes];
    const int i = row_at(c.i[lane % kLanes]), j = row_at(c.j[lane % kLanes]);
    return place_[to_size(i == row ? j : i)];
  };
  for (const int lane : lanes_.of(row)) {
    const Place& other = place_of_other(lane);
    if (other.cell < 0) continue;  // fixed
    const Node corner = nodes_[to_size(cell(other)[0])];
    low = {std::min(low.x, corner.x), std::min(low.y, corner.y)};
  }
  // Sums over the contacts of weight n_x, n_y, n_x n_y, n_x² - n_y² for each node around.
  struct Moments {
    int node = -1;
    double x = 0, y = 0, product = 0, difference = 0;
  };
  std::array<Moments, kPatch * kPatch> patch;
  const auto add = [&](const Place& place, const std::array<double, 4>& weights,
                       const Moments& carried) {
    const Cell& corners = cell(place);
    const Node first = nodes_[to_size(corners[0])];
    for (int k = 0; k < 4; ++k) {
      Moments& to = patch[to_size(first.x - low.x + k % 2 + kPatch * (first.y - low.y + k / 2))];
      to.node = corners[to_size(k)];
      to.x += weights[to_size(k)] * carried.x;
      to.y += weights[to_size(k)] * carried.y;
      to.product += weights[to_size(k)] * carried.product;
      to.difference += weights[to_size(k)] * carried.difference;
    }
  };
  Moments all;
  for (const int lane : lanes_.of(row)) {
    const int at = lane % kLanes;
    const ContactBatch<2>& c = tiles.contact[lane / kLanes];
    const double share = share_[to_size(lane / kLanes)].share[at];
    if (share == 0) continue;
    const double length = tiles.laws[tiles.law[lane / kLanes]].ratio[at] / c.turns[kTurnSpin][at];
    const double nx = length * c.gx[at], ny = length * c.gy[at];
    const double sign = row_at(c.i[at]) == row ? share : -share;
    const Moments carried{-1, sign * nx, sign * ny, share * nx * ny, share * (nx * nx - ny * ny)};
    all.x += carried.x;
    all.y += carried.y;
    all.product += carried.product;
    all.difference += carried.difference;
    const Place& other = place_of_other(lane);
    if (other.cell >= 0) add(other, other.weights(), carried);
  }
  add(own, own_weights, all);

  // The wrench on the body of the stresses xx, xy, yy of a node: force, and moment / a with the
  // opposite sign, which has no effect in a square.
  using Wrench = Eigen::Matrix3d;
  const auto wrench = [](const Moments& m) {
    Wrench w;
    w << m.x, m.y, 0,                         //
        -m.product, m.difference, m.product,  //
        0, m.x, m.y;
    return w;
  };
  const Vec3 weight(inverse[0], inverse[1], inverse[2]);
  double* const values = matrix_.valuePtr();
  const int* const starts = matrix_.outerIndexPtr();
  for (int b = 0; b < kPatch * kPatch; ++b) {
    const Moments& of_b = patch[to_size(b)];
    if (of_b.node < 0) continue;
    const Wrench weighed = weight.asDiagonal() * wrench(of_b);
    for (int a = 0; a < kPatch * kPatch; ++a) {
      const Moments& of_a = patch[to_size(a)];
      if (of_a.node < 0) continue;
      const Eigen::Matrix3d block = wrench(of_a).transpose() * weighed;
      const int dx = a % kPatch - b % kPatch, dy = a / kPatch - b / kPatch;
      const int before = neighbours_[to_size(of_b.node)][to_size(stencil(dx, dy))];
      for (int k = 0; k < 3; ++k) {
        double* const to = values + starts[3 * of_b.node + k] + 3 * before;
        for (int r = 0; r < 3; ++r) to[r] += block(r, k);
      }
    }
  }
}

bool StressModes::relax(std::span<BodyRow> rows) const {
  // Of each cell: sums for its corners.
  std::vector<Eigen::Matrix<double, 3, 4>> sums(cells_.size());
  run_tasks(threads_, static_cast<int>(cells_.size()), [&](int cell) {
    auto& sum = sums[to_size(cell)];
    sum.setZero();
    for (const int row : rows_.of(cell)) {
      const std::array<double, 4> weights = place_[to_size(row)].weights();
      for (int corner = 0; corner < 4; ++corner) {
        for (int r = 0; r < 3; ++r) {
          sum(r, corner) += weights[to_size(corner)] * rows[to_size(row)].value[kSlots[r]];
        }
      }
    }
  });
  Vector rates = Vector::Zero(matrix_.rows());
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    for (int corner = 0; corner < 4; ++corner) {
      rates.segment<3>(3 * cells_[cell][to_size(corner)]) += sums[cell].col(corner);
    }
  }
  const Vector stress = -factor_.solve(rates);
  const double gained = -stress.dot(rates), shifted = shift_ * stress.squaredNorm();
  interpolate(stress, rows);
  return shifted <= kIdle * gained;
}

void StressModes::interpolate(const Vector& nodes, std::span<BodyRow> rows) const {
  const auto stress_of = [&](const Place& place) {
    BodyRow stress;
    if (place.cell < 0) return stress;
    const std::array<double, 4> weights = place.weights();
    const Cell& corners = cells_[to_size(place.cell)];
    for (int k = 0; k < 4; ++k) {
      for (int r = 0; r < 3; ++r) {
        stress.value[kSlots[r]] += weights[to_size(k)] * nodes[3 * corners[to_size(k)] + r];
      }
    }
    return stress;
  };
  run_pieces(threads_, static_cast<int>(rows.size()), [&](int first, int last) {
    for (int row = first; row < last; ++row) rows[to_size(row)] = stress_of(place_[to_size(row)]);
  });
}

}  // namespace bipot
