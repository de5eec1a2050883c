#pragma once

#include <type_traits>

#include "core/base/execution.h"
#include "solvers/kernels/gradient_map.h"

namespace bipot {

/// Values of one body: x, a ω, y and an unused one. In this order a single instruction (addsub)
/// subtracts x and y and adds a ω.
struct alignas(32) BodyRow {
  double value[4] = {0, 0, 0, 0};
};
inline constexpr int kRowX = 0, kRowSpin = 1, kRowY = 2, kRowLast = 3;

/// Values of a sphere, one line of the cache: x, y, z and 1/m, then a ω in x, y, z and a²/I. The
/// two inverses stand in velocities; momenta have zeros there.
struct alignas(64) SphereRow {
  double value[8] = {0, 0, 0, 0, 0, 0, 0, 0};
};
inline constexpr int kRowInverseMass = 3, kRowTurn = 4, kRowInverseInertia = 7;

/// D of bodies with rolling friction; else D is the dim of the problem.
inline constexpr int kRollingDisks = 4, kRollingSpheres = 6;
template <int D>
inline constexpr bool kOfSpheres = D == 3 || D == kRollingSpheres;
// Instantiates a template for all bodies: BIPOT_FOR_BODIES(template class Name);
#define BIPOT_FOR_BODIES(name) \
  name<1>;                     \
  name<2>;                     \
  name<3>;                     \
  name<kRollingDisks>;         \
  name<kRollingSpheres>
/// Rows of a contact.
template <int D>
inline constexpr int kRowsOf = D == kRollingDisks ? 3 : D;

/// The row of a body of a problem. With rolling friction the last value of a disk is a ω once more.
template <int D>
using RowOf = std::conditional_t<kOfSpheres<D>, SphereRow, BodyRow>;

/// Offset of a row in bytes.
template <class Row>
unsigned row_offset(int row) {
  return static_cast<unsigned>(sizeof(Row)) * static_cast<unsigned>(row);
}

/// The wrench map of kLanes contacts of disks (core/problem/disk_structure.h) in variables that the
/// caller has scaled: with the bodies' rows v,
///
///     w_n = g·(V_i - V_j) + b_n,     w_t = ratio g x (V_i - V_j) - spin (w_i + w_j) + b_t.
///
/// with w_i = a_i ω_i. With rolling friction w_m = r (ω_i - ω_j) + b_m is half = (r/a_i + r/a_j)/2
/// times the difference w_i - w_j, plus lean = (r/a_i - r/a_j)/2 times their sum, plus b_m. So x_m
/// adds (lean + half) x_m to the turning of body i and (lean - half) x_m to that of j. x_t changes
/// w_m by coupling x_t, and x_m changes w_t alike. A lane without a contact has g = turns = b = 0 and
/// the surroundings as both bodies.
template <int D>
struct alignas(64) ContactBatch {
  unsigned i[kLanes], j[kLanes];  ///< rows, counted in bytes: see row_offset()
  double gx[kLanes], gy[kLanes];
  double turns[D == kRollingDisks ? 4 : 1][kLanes];  ///< of kTurnSpin, kTurnHalf …
  double b[static_cast<unsigned>(kRowsOf<D>)][kLanes];
};
inline constexpr int kTurnSpin = 0, kTurnHalf = 1, kTurnLean = 2, kTurnCoupling = 3;
/// The same for spheres (core/problem/sphere_structure.h). Impulses and velocities of a contact are
/// vectors in space, so that no tangents are needed: with v = V_i - V_j and Ω = w_i + w_j,
///
///     w = scale ((n·v) n + ratio (v - (n·v) n - Ω x n)) + b.
///
/// A lane without a contact has n = scale = b = 0 and the surroundings as both bodies.
template <>
struct alignas(64) ContactBatch<3> {
  unsigned i[kLanes], j[kLanes];
  double n[3][kLanes];
  double scale[kLanes];
  double b[3][kLanes];
};
/// With rolling friction moments are vectors in space too. With turned = r_i w_i - r_j w_j, where r =
/// 1/a in the scaled variables,
///
///     w_m = turned + b_m,  b_m the last three of b.
///
/// So a moment M turns body i by r_i M, and body j by -r_j M. A torque T on either body changes w_m
/// by coupling T; alike M changes Ω.
template <>
struct alignas(64) ContactBatch<kRollingSpheres> {
  unsigned i[kLanes], j[kLanes];
  double n[3][kLanes];
  double scale[kLanes];
  double roll[2][kLanes];  ///< r_i, r_j
  double coupling[kLanes];
  double b[6][kLanes];
};
/// Impulses of a batch in the scaled variables. Normal, tangential and rolling parts, for spheres
/// x, y, z of the forces, then of the moments.
template <int D>
struct alignas(64) ImpulseBatch {
  double x[static_cast<unsigned>(kRowsOf<D>)][kLanes] = {};
};
/// Laws of the contacts of a batch: a few of these serve all batches.
struct alignas(64) LawBatch {
  double ratio[kLanes] = {};
  double mu[kLanes] = {};
  double cone[kLanes] = {};                                                      ///< 1 / (1 + mu²)
  double mu_r[kLanes] = {}, rolling_cone[kLanes] = {}, both_cones[kLanes] = {};  ///< alike
  double mu_spin[kLanes] = {};
};

/// Contacts of some batches, a part of tasks.
template <int D>
struct PackedContacts {
  const ContactBatch<D>* contact = nullptr;
  const int* law = nullptr;  ///< of each batch
  const LawBatch* laws = nullptr;
};

/// kLanes consecutive rows, and batches whose lanes each have one of these as their first body
/// (body_blocks.h). Then follow batches with any bodies, up to those of the next block.
struct BodyBlock {
  unsigned row = 0;          ///< offset of the first one
  int first = 0, loose = 0;  ///< batches
};
/// The row in a block of the body of each lane: kernels of eight lanes transpose such pairs of rows
/// with the fewest shuffles.
inline constexpr int kRowOfLane[kLanes] = {0, 2, 1, 3, 4, 6, 5, 7};
/// Number of blocks whose rows a step of the gradient sets before their contacts, which may use any
/// of them.
inline constexpr int kWindowBlocks = 4;

/// One step of an accelerated projected gradient over blocks, window after window. It sets the
/// velocities of their bodies at the extrapolated momentum. Then x⁺ = P(y - w(y)) with y = x + beta
/// (x - x⁻) is added to the next momentum. For all other bodies of these contacts velocities and
/// next momenta must be set. P: solvers/methods/accelerated_gradient.h.
template <int D>
struct GradientTask : PackedContacts<D> {
  const BodyBlock *begin = nullptr, *end = nullptr;  ///< windows; there is one more at the end
  bool ask_ahead = false;
  GradientMap map = GradientMap::kSplit;
  double beta = 0;
  // Arrays over all batches and rows.
  const ImpulseBatch<D>*now = nullptr, *before = nullptr;  ///< x, x⁻
  ImpulseBatch<D>* next = nullptr;                         ///< x⁺, may be `before`
  // The fourth value of a disk's row holds an inverse: 1/m in a velocity, a²/I in a momentum. This
  // saves the memory traffic of separate rows.
  const RowOf<D>*momentum = nullptr, *momentum_before = nullptr;  ///< of x, x⁻
  RowOf<D>* velocity = nullptr;
  RowOf<D>* next_momentum = nullptr;  ///< of x⁺, may be that of x⁻
  const RowOf<D>* inverse = nullptr;  ///< with rolling friction alone
};
/// Partial sums of one tile, for each lane: they must be added in a fixed order.
struct alignas(64) GradientSums {
  double along[kLanes] = {};    ///< (x - x⁻)·(x⁺ - x)
  double change2[kLanes] = {};  ///< ‖x⁺ - x‖²
  /// ‖momentum - momentum before‖² in 1/mass, of two rows at once; for spheres of one.
  double energy[8] = {};
};

/// Velocities of y = x + beta (x - x⁻), which are linear in the impulses: `before` of x⁻ becomes
/// now + beta (now - before). A row of a sphere counts as two here.
struct ExtrapolationTask {
  int rows = 0;
  bool ask_ahead = false;
  double beta = 0;
  const BodyRow* now = nullptr;
  BodyRow* before = nullptr;
};

/// A forward or backward sweep of projected Gauss-Seidel over some of the batches; the lists cover
/// all. x_n <- max(0, x_n - ω w_n), x_t <- x_t - ω w_t cut off at mu x_n, with velocities updated
/// after each batch. `next` is updated in place; with momentum, the first forward sweep starts from
/// y = x + beta (x - x⁻) and writes it.
template <int D>
struct SymmetricTask : PackedContacts<D> {
  int first_batch = 0, last_batch = 0;  ///< half open
  bool outer = true;       ///< the first forward sweep of an iteration, the last backward one
  bool ask_ahead = false;  ///< for lists, and rows in a sweep back
  double beta = 0, omega = 1;
  const ImpulseBatch<D>*now = nullptr, *before = nullptr;  ///< x, x⁻
  ImpulseBatch<D>* next = nullptr;                         ///< x⁺
  RowOf<D>* velocity = nullptr;                            ///< all rows
  /// All rows: 1/m, a²/I, 1/m, and 0 or with rolling friction a²/I; not used for spheres.
  const RowOf<D>* inverse = nullptr;
  /// Offsets of rows, one for each line of the cache, that a backward sweep uses after these
  /// batches.
  const unsigned* coming = nullptr;
  int num_coming = 0;
};
/// Partial sums of (y - x⁺)·(x⁺ - x) for each lane.
struct alignas(64) TurnSums {
  double turn[kLanes] = {};
};

template <int D>
struct DiskKernels {
  void (*gradient)(const GradientTask<D>& task, GradientSums& sums);
  void (*extrapolate_velocity)(const ExtrapolationTask& task);
  void (*sweep_forth)(const SymmetricTask<D>& task);
  /// Adds to the sums in the last sweep.
  void (*sweep_back)(const SymmetricTask<D>& task, TurnSums& sums);
};

/// The kernels of one path. Every path gives the same bits: a lane does the same operations in the
/// same order, products and sums are never contracted, and each lane has its own partial sum.
/// Throws std::invalid_argument for a path that this machine does not have.
template <int D>
const DiskKernels<D>& disk_kernels(SimdPath path);

}  // namespace bipot
