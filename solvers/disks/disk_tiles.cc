#include "solvers/disks/disk_tiles.h"

#include <unistd.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "core/base/large_pages.h"
#include "core/base/parallel.h"

namespace bipot {
namespace {

constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
constexpr std::size_t kDeepest = 16;
constexpr std::size_t kMostPlaces = 4;  // of a wave

/// Bytes of a cache as the system reports, else `otherwise`. The size affects the order of work in
/// time, but no bit.
std::size_t cache_bytes(int level, std::size_t otherwise) {
  long bytes = 0;
#if defined(_SC_LEVEL2_CACHE_SIZE) && defined(_SC_LEVEL3_CACHE_SIZE)
  bytes = sysconf(level == 2 ? _SC_LEVEL2_CACHE_SIZE : _SC_LEVEL3_CACHE_SIZE);
#endif
  return bytes > 0 ? static_cast<std::size_t>(bytes) : otherwise;
}

/// The cache of one core.
std::size_t own_cache() {
  static const std::size_t bytes = cache_bytes(2, std::size_t{1} << 20);
  return bytes;
}

/// A quarter of the next cache, which others use too but which is much faster than memory; half of
/// it for two threads. If several caches serve a processor, the system may report their sum; 32 MiB
/// are common for one.
std::size_t shared_cache() {
  static const std::size_t bytes = std::min(cache_bytes(3, 0), std::size_t{32} << 20) / 4;
  return bytes;
}

/// Gives numbers that are equal to rounding the same bits: those of the first of them.
class Snap {
 public:
  double operator()(double x) {
    for (const double known : known_) {
      if (std::abs(x - known) <= kRounding * std::abs(known)) return known;
    }
    if (known_.size() < kMost) known_.push_back(x);
    return x;
  }

 private:
  static constexpr std::size_t kMost = 16;  // beyond, numbers stay as they are
  std::vector<double> known_;
};

}  // namespace

template <int D>
DiskTiles<D>::DiskTiles(const ContactProblem& p, const BodiesOf<D>& bodies,
                        const ContactScaling& scaling, ContactTiles tiles, int threads)
    : tiles_(std::move(tiles)),
      threads_(threads),
      velocity_scale_(large_copy(scaling.velocity)),
      contacts_(to_size(tiles_.num_batches()) + 1),
      law_(to_size(tiles_.num_batches())),
      inverse_(to_size(tiles_.num_rows)),
      bodies_(&bodies) {
  if constexpr (D == kRollingSpheres) {
    // The kernels know one scale of all moments: that of the spin differs by rounding.
    for (int c = 0; c < p.num_contacts(); ++c)
      velocity_scale_[6 * c + 5] = velocity_scale_[6 * c + 3];
  }
  for (int body = 0; body < bodies.surroundings(); ++body) {
    const auto& from = bodies.bodies[to_size(body)];
    auto& inverse = inverse_[to_size(tiles_.row[to_size(body)])].value;
    if constexpr (kOfSpheres<D>) {
      std::fill_n(inverse, 3, from.inverse_mass);
      std::fill_n(inverse + kRowTurn, 3, from.inverse_inertia);
    } else {
      inverse[kRowX] = inverse[kRowY] = from.inverse_mass;
      inverse[kRowSpin] = from.inverse_inertia;
    }
    if constexpr (D == kRollingDisks) inverse[kRowLast] = inverse[kRowSpin];
  }
  const auto offset = [](int row) { return row_offset<RowOf<D>>(row); };
  const auto inverse_at = [&](unsigned at, int k) {
    return inverse_[at / sizeof(RowOf<D>)].value[k];
  };
  const auto over_arm = [&](double roll, int body) {
    return body == bodies.surroundings() ? 0 : roll / bodies.bodies[to_size(body)].arm;
  };
  Snap snap_ratio, snap_mu;
  for (const Tile& tile : tiles_.tiles) {
    for (int batch = tile.first_batch; batch < tile.last_batch; ++batch) {
      ContactBatch<D>& to = contacts_[to_size(batch)];
      to = {};
      LawBatch law;
      for (int lane = 0; lane < kLanes; ++lane) {
        const int c = tiles_.contact[to_size(batch * kLanes + lane)];
        const unsigned outside = offset(tile.last_row - 1 - lane % tiles_.outside_rows);
        const int own = tiles_.first_body_row(batch, lane);
        to.i[lane] = own >= 0 ? offset(own) : outside;
        to.j[lane] = outside;
        // An empty lane uses the law of its neighbour, which saves a LawBatch.
        if (c < 0) {
          for (auto* const of : {&law.ratio, &law.mu, &law.cone, &law.mu_r, &law.rolling_cone,
                                 &law.both_cones, &law.mu_spin}) {
            (*of)[lane] = (*of)[0];
          }
          continue;
        }
        const auto& from = bodies.contacts[to_size(c)];
        to.i[lane] = offset(tiles_.row[to_size(from.i)]);
        if (from.j != bodies.surroundings()) to.j[lane] = offset(tiles_.row[to_size(from.j)]);
        const bool swapped = own >= 0 && to.i[lane] != offset(own);
        if (swapped) std::swap(to.i[lane], to.j[lane]);
        const double normal = from.normal * scaling.velocity[c * kRows];
        if constexpr (D > 1) {
          law.ratio[lane] = snap_ratio(from.tangential * scaling.velocity[c * kRows + 1] / normal);
        }
        law.mu[lane] = snap_mu(scaling.mu[c]);
        law.cone[lane] = 1 / (1 + law.mu[lane] * law.mu[lane]);
        const double sign = swapped ? -1 : 1;
        const Rows b = velocity_scale_.template segment<kRows>(c * kRows).cwiseProduct(
            p.u_free.template segment<kRows>(c * kRows));
        if constexpr (kOfSpheres<D>) {
          to.scale[lane] = normal;
          for (int x = 0; x < 3; ++x) to.n[x][lane] = sign * from.frame[0][x];
          const Rows vectors = in_space(batch * kLanes + lane, b);
          for (int x = 0; x < kRows; ++x) to.b[x][lane] = vectors[x];
          if constexpr (D == kRollingSpheres) {
            law.mu_r[lane] = snap_mu(scaling.mu_r[c]);
            law.mu_spin[lane] = snap_mu(scaling.mu_spin[c]);
            Vec3 axis = Vec3::Zero();
            for (int k = 0; k < 3; ++k) axis[k] = p.H.coeff(6 * from.i + 3 + k, 6 * c + 3);
            const double roll = axis.norm() * velocity_scale_[6 * c + 3];
            to.roll[0][lane] = over_arm(roll, swapped ? from.j : from.i);
            to.roll[1][lane] = over_arm(roll, swapped ? from.i : from.j);
            to.coupling[lane] = inverse_at(to.i[lane], kRowTurn) * to.roll[0][lane] -
                                inverse_at(to.j[lane], kRowTurn) * to.roll[1][lane];
          }
        } else {
          to.gx[lane] = sign * normal * from.n[0];
          to.gy[lane] = sign * normal * from.n[1];
          if constexpr (D > 1)
            to.turns[kTurnSpin][lane] = from.tangential * scaling.velocity[c * kRows + 1];
          if constexpr (D == kRollingDisks) {
            const double mu_r = law.mu_r[lane] = snap_mu(scaling.mu_r[c]);
            law.rolling_cone[lane] = 1 / (1 + mu_r * mu_r);
            law.both_cones[lane] = 1 / (1 + law.mu[lane] * law.mu[lane] + mu_r * mu_r);
            const double roll =
                std::abs(p.H.coeff(3 * from.i + 2, 3 * c + 2)) * scaling.velocity[3 * c + 2];
            double own_roll = sign * over_arm(roll, from.i);
            double other_roll = sign * over_arm(roll, from.j);
            if (swapped) std::swap(own_roll, other_roll);
            to.turns[kTurnHalf][lane] = 0.5 * (own_roll + other_roll);
            to.turns[kTurnLean][lane] = 0.5 * (own_roll - other_roll);
            to.turns[kTurnCoupling][lane] =
                -to.turns[kTurnSpin][lane] * (inverse_at(to.i[lane], kRowSpin) * own_roll -
                                              inverse_at(to.j[lane], kRowSpin) * other_roll);
          }
          for (int k = 0; k < kRows; ++k) to.b[k][lane] = b[k];
        }
      }
      law_[to_size(batch)] = law_number(law);
    }
  }
}

template <int D>
Eigen::Matrix3d DiskTiles<D>::frame(int lane) const {
  Eigen::Matrix3d frame;
  if constexpr (kOfSpheres<D>) {
    const auto& from = bodies_->contacts[to_size(contact(lane))].frame;
    const ContactBatch<D>& batch = contacts_[to_size(lane / kLanes)];
    double along = 0;
    for (int x = 0; x < 3; ++x) along += batch.n[x][lane % kLanes] * from[0][x];
    for (int k = 0; k < 3; ++k) {
      for (int x = 0; x < 3; ++x) frame(k, x) = std::copysign(1.0, along) * from[k][x];
    }
  }
  return frame;
}

template <int D>
typename DiskTiles<D>::Rows DiskTiles<D>::in_rows(int lane, const Rows& in_space) const {
  Rows rows = in_space;
  if constexpr (kOfSpheres<D>) {
    const Eigen::Matrix3d axes = frame(lane);
    rows.template head<3>() = axes * in_space.template head<3>();
    if constexpr (D == kRollingSpheres) {
      const Vec3 moments = axes * in_space.template tail<3>();
      rows.template tail<3>() = Vec3(moments[1], moments[2], moments[0]);
    }
  }
  return rows;
}

template <int D>
typename DiskTiles<D>::Rows DiskTiles<D>::in_space(int lane, const Rows& in_rows) const {
  Rows vectors = in_rows;
  if constexpr (kOfSpheres<D>) {
    const Eigen::Matrix3d axes = frame(lane);
    vectors.template head<3>() = axes.transpose() * in_rows.template head<3>();
    if constexpr (D == kRollingSpheres) {
      vectors.template tail<3>() = axes.transpose() * Vec3(in_rows[5], in_rows[3], in_rows[4]);
    }
  }
  return vectors;
}

/// The index of an equal LawBatch among the last ones, or of a new one.
template <int D>
int DiskTiles<D>::law_number(const LawBatch& law) {
  constexpr std::size_t kLook = 32;
  for (std::size_t k = laws_.size(); k > 0 && k + kLook > laws_.size(); --k) {
    if (std::memcmp(&laws_[k - 1], &law, sizeof(LawBatch)) == 0) return static_cast<int>(k) - 1;
  }
  laws_.push_back(law);
  return static_cast<int>(laws_.size()) - 1;
}

template <int D>
void DiskTiles<D>::rescale(double factor) {
  const auto scale = [&](double(&values)[kLanes]) {
    for (double& value : values) value *= factor;
  };
  run_pieces(threads_, num_batches(), [&](int first, int last) {
    for (int k = first; k < last; ++k) {
      ContactBatch<D>& batch = contacts_[to_size(k)];
      if constexpr (kOfSpheres<D>) {
        scale(batch.scale);
        if constexpr (D == kRollingSpheres) {
          for (auto& roll : batch.roll) scale(roll);
          scale(batch.coupling);
        }
      } else {
        scale(batch.gx);
        scale(batch.gy);
        for (auto& turn : batch.turns) scale(turn);
        if constexpr (D == kRollingDisks) scale(batch.turns[kTurnCoupling]);  // of two impulses
      }
      for (auto& b : batch.b) scale(b);
    }
  });
  velocity_scale_ *= factor;
}

template <int D>
void DiskTiles<D>::follow(double kappa, std::span<const RowOf<D>> momentum, const Vector& u_free) {
  const auto follow_lane = [&](int at) {
    const int c = contact(at), lane = at % kLanes;
    if (c < 0) return;
    ContactBatch<D>& batch = contacts_[to_size(at / kLanes)];
    const LawBatch& law = laws_[to_size(law_[to_size(at / kLanes)])];
    const std::size_t i = batch.i[lane] / sizeof(RowOf<D>), j = batch.j[lane] / sizeof(RowOf<D>);
    const auto of_body = [&](std::size_t row, int k) {
      return inverse_[row].value[k] * momentum[row].value[k];
    };
    const auto velocity = [&](int k, double sign) { return of_body(i, k) + sign * of_body(j, k); };
    const auto stepped = [&](double sigma, double speed) {
      return sigma + kappa * (speed - sigma);
    };
    if constexpr (kOfSpheres<D>) {
      const Vec3 n(batch.n[0][lane], batch.n[1][lane], batch.n[2][lane]);
      const Vec3 without =
          frame(at).transpose() * velocity_scale_.template segment<3>(c * kRows).cwiseProduct(
                                      u_free.template segment<3>(c * kRows));
      Vec3 b(batch.b[0][lane], batch.b[1][lane], batch.b[2][lane]);
      double slip = 0;
      if (!momentum.empty()) {
        const Vec3 v(velocity(0, -1), velocity(1, -1), velocity(2, -1));
        const Vec3 turn(velocity(kRowTurn, 1), velocity(kRowTurn + 1, 1),
                        velocity(kRowTurn + 2, 1));
        const Vec3 w = batch.scale[lane] * law.ratio[lane] * (v - turn.cross(n)) + b;
        slip = law.mu[lane] * (w - n.dot(w) * n).norm();
        if constexpr (D == kRollingSpheres) {
          Vec3 turned;
          for (int k = 0; k < 3; ++k) {
            turned[k] = batch.roll[0][lane] * of_body(i, kRowTurn + k) -
                        batch.roll[1][lane] * of_body(j, kRowTurn + k) + batch.b[3 + k][lane];
          }
          const double spin = n.dot(turned);
          slip += law.mu_r[lane] * (turned - spin * n).norm() + law.mu_spin[lane] * std::abs(spin);
        }
      }
      b = without + stepped(n.dot(b - without), slip) * n;
      for (int k = 0; k < 3; ++k) batch.b[k][lane] = b[k];
    } else {
      const double without = velocity_scale_[c * kRows] * u_free[c * kRows];
      double speed = 0;
      if constexpr (D > 1) {
        if (!momentum.empty()) {
          const double along =
              batch.gx[lane] * velocity(kRowY, -1) - batch.gy[lane] * velocity(kRowX, -1);
          speed = law.mu[lane] *
                  std::abs(law.ratio[lane] * along -
                           batch.turns[kTurnSpin][lane] * velocity(kRowSpin, 1) + batch.b[1][lane]);
          if constexpr (D == kRollingDisks) {
            const double rolls = batch.turns[kTurnHalf][lane] * velocity(kRowLast, -1) +
                                 batch.turns[kTurnLean][lane] * velocity(kRowSpin, 1) +
                                 batch.b[2][lane];
            speed += law.mu_r[lane] * std::abs(rolls);
          }
        }
      }
      batch.b[0][lane] = without + stepped(batch.b[0][lane] - without, speed);
    }
  };
  run_pieces(threads_, num_batches() * kLanes, [&](int first, int last) {
    for (int lane = first; lane < last; ++lane) follow_lane(lane);
  });
}

template <int D>
void DiskTiles<D>::pack(const Vector& s, std::span<ImpulseBatch<D>> x) const {
  run_pieces(threads_, num_batches() * kLanes, [&](int first, int last) {
    for (int lane = first; lane < last; ++lane) {
      const int c = contact(lane);
      Rows scaled = Rows::Zero();
      if (c >= 0) {
        scaled = s.template segment<kRows>(c * kRows).cwiseQuotient(
            velocity_scale_.template segment<kRows>(c * kRows));
        if constexpr (kOfSpheres<D>) scaled = in_space(lane, scaled);
      }
      for (int k = 0; k < kRows; ++k) x[to_size(lane / kLanes)].x[k][lane % kLanes] = scaled[k];
    }
  });
}

template <int D>
void DiskTiles<D>::push(std::span<const ImpulseBatch<D>> x, std::span<RowOf<D>> momentum) const {
  std::fill(momentum.begin(), momentum.end(), RowOf<D>{});
  for (int batch = 0; batch < num_batches(); ++batch) {
    const ContactBatch<D>& contact = contacts_[to_size(batch)];
    const LawBatch& law = laws_[to_size(law_[to_size(batch)])];
    const ImpulseBatch<D>& impulse = x[to_size(batch)];
    for (int lane = 0; lane < kLanes; ++lane) {
      double* const i = momentum[contact.i[lane] / sizeof(RowOf<D>)].value;
      double* const j = momentum[contact.j[lane] / sizeof(RowOf<D>)].value;
      if constexpr (kOfSpheres<D>) {
        const Vec3 n(contact.n[0][lane], contact.n[1][lane], contact.n[2][lane]);
        const Vec3 s(impulse.x[0][lane], impulse.x[1][lane], impulse.x[2][lane]);
        const double tangential = contact.scale[lane] * law.ratio[lane];
        const Vec3 pushed = tangential * s;
        const Vec3 force = pushed + (contact.scale[lane] - tangential) * n.dot(s) * n;
        const Vec3 torque = pushed.cross(n);
        for (int k = 0; k < 3; ++k) {
          i[k] += force[k];
          j[k] -= force[k];
          i[kRowTurn + k] += torque[k];
          j[kRowTurn + k] += torque[k];
          if constexpr (D == kRollingSpheres) {
            i[kRowTurn + k] += contact.roll[0][lane] * impulse.x[3 + k][lane];
            j[kRowTurn + k] -= contact.roll[1][lane] * impulse.x[3 + k][lane];
          }
        }
      } else {
        const double normal = impulse.x[0][lane];
        double px = contact.gx[lane] * normal, py = contact.gy[lane] * normal, spin = 0;
        if constexpr (D > 1) {
          const double tangential = law.ratio[lane] * impulse.x[1][lane];
          px -= contact.gy[lane] * tangential;
          py += contact.gx[lane] * tangential;
          spin = contact.turns[kTurnSpin][lane] * impulse.x[1][lane];
        }
        i[kRowX] += px;
        i[kRowY] += py;
        i[kRowSpin] -= spin;
        j[kRowX] -= px;
        j[kRowY] -= py;
        j[kRowSpin] -= spin;
        if constexpr (D == kRollingDisks) {
          const double half = contact.turns[kTurnHalf][lane] * impulse.x[2][lane];
          const double lean = contact.turns[kTurnLean][lane] * impulse.x[2][lane];
          i[kRowLast] = i[kRowSpin] += lean + half;
          j[kRowLast] = j[kRowSpin] += lean - half;
        }
      }
    }
  }
}

template <int D>
void DiskTiles<D>::velocities(std::span<const ImpulseBatch<D>> x,
                              std::span<RowOf<D>> velocity) const {
  push(x, velocity);
  run_pieces(threads_, num_rows(), [&](int first, int last) {
    for (int row = first; row < last; ++row) {
      const RowOf<D>& inverse = inverse_[to_size(row)];
      auto& value = velocity[to_size(row)].value;
      for (std::size_t k = 0; k < std::size(value); ++k) value[k] *= inverse.value[k];
      if constexpr (kOfSpheres<D>) put_inverses(inverse, velocity[to_size(row)]);
    }
  });
}

template <int D>
void DiskTiles<D>::unpack(std::span<const ImpulseBatch<D>> x, Vector& s) const {
  if (s.size() != velocity_scale_.size()) s = large_vector(velocity_scale_.size());
  run_pieces(threads_, num_batches() * kLanes, [&](int first, int last) {
    for (int lane = first; lane < last; ++lane) {
      if (contact(lane) >= 0) s.template segment<kRows>(contact(lane) * kRows) = impulse(x, lane);
    }
  });
}

template <int D>
std::size_t DiskTiles<D>::in_all(Streamed bytes) const {
  return to_size(num_batches()) * bytes.batch + to_size(num_rows()) * bytes.row;
}

template <int D>
bool DiskTiles<D>::asks_ahead(Streamed bytes) const {
  return in_all(bytes) > std::max(own_cache(), shared_cache());
}

template <int D>
Pipeline DiskTiles<D>::pipeline(int threads, Streamed bytes) const {
  const std::size_t team = to_size(std::max(threads, 1));
  const std::size_t all = in_all(bytes);
  if (all <= own_cache() * team) return {};
  // Data from the shared cache gain only by iterations in the core's own cache.
  const std::size_t share = std::min(shared_cache(), 2 * shared_cache() / team);
  const std::size_t cache = all <= shared_cache() ? own_cache() : std::max(own_cache(), share);
  const std::size_t tile = std::max<std::size_t>(all / to_size(num_tiles()), 1);
  const std::size_t places = std::clamp<std::size_t>(own_cache() / tile, 2, kMostPlaces);
  const std::size_t others = places - 1;  // beside one of each iteration
  const std::size_t depth = std::clamp(cache / tile, 2 + others, kDeepest + others) - others;
  return {static_cast<int>(depth), static_cast<int>(places)};
}

BIPOT_FOR_BODIES(template class DiskTiles);

}  // namespace bipot
