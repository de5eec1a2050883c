#include "solvers/disks/deflated_sweep.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace bipot {
namespace {

/// Iterations between two updates of the set of contacts with stresses.
constexpr int kRenewal = 20;

double sum(const double (&parts)[4]) { return (parts[0] + parts[1]) + (parts[2] + parts[3]); }

}  // namespace

DeflatedSweep::DeflatedSweep(SymmetricSweep<2>& sweep, const DiskStructure& disks,
                             const Execution& options)
    : sweep_(sweep),
      options_(options),
      kernels_(stress_kernels(options.path)),
      tiles_in_order_(sweep.schedule({.up = 1})),
      modes_(sweep.disks(), disks, options.threads),
      mass_(to_size(sweep.disks().num_rows())),
      direction_(mass_.size()),
      stress_(mass_.size()),
      momentum_(mass_.size()),
      sums_((mass_.size() + kPieceItems - 1) / kPieceItems),
      loads_(to_size(sweep.disks().num_tiles())) {
  for (std::size_t row = 0; row < mass_.size(); ++row) {
    for (int k = 0; k < 4; ++k) {
      // Negative for the spin of a driven wall: its energy is that of the normal motion alone.
      const double inverse = sweep.disks().inverse()[row].value[k];
      mass_[row].value[k] = inverse != 0 ? 1 / inverse : 0;
    }
  }
}

bool DeflatedSweep::reset(const Vector& s) {
  sweep_.reset(s);
  std::fill(direction_.begin(), direction_.end(), BodyRow{});
  pp_ = 0;
  at_ = sweep_.sweep();
  std::fill(at_.spare.begin(), at_.spare.end(), ImpulseBatch<2>{});
  since_renewal_ = 0;
  carried_ = modes_.renew(at_.swept);
  return carried_;
}

const Vector& DeflatedSweep::impulse() {
  sweep_.disks().unpack(at_.swept, s_);
  return s_;
}

bool DeflatedSweep::iterate() {
  if (!carried_) return false;
  const DiskTiles<2>& disks = sweep_.disks();
  const int batches = disks.num_batches(), rows = disks.num_rows();
  const auto clear = [&](LargeVector<BodyRow>& of) {
    run_pieces(options_.threads, rows, [&](int first, int last) {
      std::fill(of.begin() + first, of.begin() + last, BodyRow{});
    });
  };
  // Tiles add to rows of bodies that they share: one after the other, as in a sweep.
  clear(stress_);
  tiles_in_order_.run(false, [&](int, int t) {
    const ContactTiles::Tile& tile = disks.tile(t);
    const int first = tile.first_batch;
    kernels_.rates({disks.packed(first), tile.last_batch - first, modes_.share() + first,
                    at_.swept_velocity.data(), stress_.data()});
  });
  if (!modes_.relax(stress_)) return false;
  clear(momentum_);
  tiles_in_order_.run(false, [&](int, int t) {
    const ContactTiles::Tile& tile = disks.tile(t);
    const int first = tile.first_batch;
    kernels_.impulse(
        {disks.packed(first), tile.last_batch - first, modes_.share() + first, stress_.data(),
         at_.y.data() + first, at_.swept.data() + first, momentum_.data()},
        loads_[to_size(t)]);
  });
  run_pieces(options_.threads, rows, [&](int first, int last) {
    kernels_.conjugate(
        {last - first, disks.inverse() + first, mass_.data() + first, momentum_.data() + first,
         at_.velocity.data() + first, direction_.data() + first, at_.swept_velocity.data() + first},
        sums_[to_size(first / kPieceItems)]);
  });
  double yz = 0, zz = 0, zp = 0;
  for (const StressKernels::ConjugateSums& part : sums_) {
    yz += sum(part.yz);
    zz += sum(part.zz);
    zp += sum(part.zp);
  }
  for (const StressKernels::LoadSums& of : loads_) {
    for (const double lane : of.load) yz += lane;  // now g·z
  }

  // y = y⁻ + alpha⁻ p⁻ with p⁻ = z⁻ + beta⁻ p⁻⁻: g·z⁻ follows from earlier products. The previous
  // direction is conjugate: g·p⁻ = 0.
  double beta = 0;
  if (pp_ > 0) {
    const double before = gz_ + alpha_ * (zz_ + beta_ * zp_);
    beta = std::max(0.0, (yz - before) / gz_);
  }
  const double pp = zz + beta * (2 * zp + beta * pp_), alpha = -yz / pp;
  if (!(pp > 0) || !std::isfinite(alpha) || !std::isfinite(beta)) return false;
  zz_ = zz;
  zp_ = zp;
  pp_ = pp;
  gz_ = yz;
  alpha_ = alpha;
  beta_ = beta;

  run_pieces(options_.threads, rows, [&](int first, int last) {
    kernels_.follow_rows({last - first, alpha, beta, at_.swept_velocity.data() + first,
                          direction_.data() + first, at_.velocity.data() + first});
  });
  run_pieces(options_.threads, batches, [&](int first, int last) {
    kernels_.follow({last - first, alpha, beta, at_.swept.data() + first, at_.spare.data() + first,
                     at_.y.data() + first});
  });
  at_ = sweep_.sweep();
  if (++since_renewal_ == kRenewal) {
    since_renewal_ = 0;
    carried_ = modes_.renew(at_.swept);  // if not, the next iteration reports it: this one is done
  }
  return true;
}

}  // namespace bipot
