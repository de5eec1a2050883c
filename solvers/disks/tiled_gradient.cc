#include "solvers/disks/tiled_gradient.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/disks/wavefront.h"
#include "solvers/kernels/spectral_estimate.h"

namespace bipot {
namespace {

/// Largest number of iterations between two common starts and ends of the threads.
constexpr int kTogether = 16;
/// Iterations of the first group.
constexpr int kAtFirst = 8;

}  // namespace

double next_momentum(double t) { return 0.5 * (1 + std::sqrt(1 + 4 * t * t)); }

template <int D>
TiledGradient<D>::TiledGradient(const ContactProblem& problem, const BodiesOf<D>& bodies,
                                const ContactScaling& scaling, const Execution& options,
                                TiledGradient<D>::Neighbours* neighbours)
    : u_free_(problem.u_free),
      blocks_(block_contacts(bodies)),
      disks_(problem, bodies, scaling, std::move(blocks_.tiles), options.threads),
      kernels_(disk_kernels<D>(options.path)),
      neighbours_(neighbours),
      threads_(options.threads),
      pipeline_(disks_.pipeline(threads_, kStreamed)),
      asks_ahead_(disks_.asks_ahead(kStreamed)),
      group_(neighbours != nullptr ? 1
             : threads_ > 1        ? std::max(pipeline_.depth, kTogether)
                                   : pipeline_.depth),
      velocity_(to_size(disks_.num_rows())),
      sums_(to_size(group_) * to_size(disks_.num_tiles())) {
  // Single iterations never use the last buffers.
  for (int k = 0; k < (group_ > 1 ? 4 : 3); ++k) {
    impulse_[k].resize(to_size(disks_.num_batches()));
    momentum_[k].resize(to_size(disks_.num_rows()));
  }
}

/// In variables that are √ρ times smaller a step of ρ is one of 1. This removes two products, and
/// shortens the chain from the velocities to the impulses.
template <int D>
void TiledGradient<D>::set_step(double rho) {
  if (rho == rho_) return;
  const double factor = std::sqrt(rho / rho_);
  disks_.rescale(factor);
  for (const int k : {roles_.now, roles_.before}) {
    for (ImpulseBatch<D>& batch : impulse_[k]) {
      for (auto& x : batch.x) {
        for (double& value : x) value /= factor;
      }
    }
  }
  rho_ = rho;
}

template <int D>
void TiledGradient<D>::reset(const Vector& s) {
  disks_.follow(1, {}, u_free_);
  roles_ = {};
  disks_.pack(s, impulse_[roles_.now]);
  disks_.push(impulse_[roles_.now], momentum_[roles_.now]);
  if (neighbours_ != nullptr) {
    neighbours_->complete(disks_, impulse_[roles_.now], momentum_[roles_.now]);
  }
  for (std::size_t row = 0; row < velocity_.size(); ++row) {
    const RowOf<D>& inverse = disks_.inverse()[row];
    if constexpr (kOfSpheres<D>) {
      put_inverses(inverse, velocity_[row]);
    } else if constexpr (D != kRollingDisks) {
      velocity_[row].value[kRowLast] = inverse.value[kRowX];
      momentum_[roles_.now][row].value[kRowLast] = inverse.value[kRowSpin];
    }
  }
  impulse_[roles_.before] = impulse_[roles_.now];
  momentum_[roles_.before] = momentum_[roles_.now];
  beta_ = change2_ = 0;
  since_restart_ = interval_ = 0;
}

template <int D>
const Vector& TiledGradient<D>::impulse() {
  disks_.unpack(impulse_[roles_.now], s_);
  return s_;
}

template <int D>
void TiledGradient<D>::follow(double kappa) {
  disks_.follow(kappa, momentum_[roles_.now], u_free_);
}

template <int D>
typename TiledGradient<D>::Roles TiledGradient<D>::after(int iterations) const {
  Roles r = roles_;
  for (int k = 0; k < iterations; ++k) {
    // The first two iterations keep the start of the group; later ones overwrite theirs.
    const int written = k < 2 ? roles_.free[k] : r.before;
    r.before = r.now;
    r.now = written;
  }
  int* free = r.free;
  for (int k = 0; k < 4; ++k) {
    if (k != r.now && k != r.before) *free++ = k;
  }
  return r;
}

template <int D>
void TiledGradient<D>::run(int iterations, const std::vector<double>& beta,
                           const GradientKernel::Control& control) {
  std::vector<Roles> roles;
  for (int k = 0; k <= iterations; ++k) roles.push_back(after(k));
  const int tiles = disks_.num_tiles();
  run_wavefront(threads_, tiles, iterations, pipeline_, [&](int k, int t) {
    const Roles& role = roles[to_size(k)];
    const std::size_t next = to_size(roles[to_size(k) + 1].now);

    GradientTask<D> task{disks_.packed()};
    task.begin = &blocks_.blocks[to_size(blocks_.first_block[to_size(t)])];
    task.end = &blocks_.blocks[to_size(blocks_.first_block[to_size(t) + 1])];
    task.ask_ahead = asks_ahead_;
    task.map = control.map;
    task.beta = beta[to_size(k)];
    task.now = impulse_[to_size(role.now)].data();
    task.before = impulse_[to_size(role.before)].data();
    task.next = impulse_[next].data();
    task.momentum = momentum_[to_size(role.now)].data();
    task.momentum_before = momentum_[to_size(role.before)].data();
    task.velocity = velocity_.data();
    task.next_momentum = momentum_[next].data();
    task.inverse = disks_.inverse();
    kernels_.gradient(task, sums_[to_size(k * tiles + t)]);
  });
  if (neighbours_ != nullptr) {
    const std::size_t next = to_size(roles.back().now);
    neighbours_->complete(disks_, impulse_[next], momentum_[next]);
  }
}

template <int D>
GradientKernel::Progress TiledGradient<D>::totals(int iteration, double beta) const {
  GradientSums sum;  // of all tiles
  for (int t = 0; t < disks_.num_tiles(); ++t) {
    const std::size_t at = to_size(iteration * disks_.num_tiles() + t);
    const GradientSums& part = sums_[at];
    for (int lane = 0; lane < kLanes; ++lane) {
      sum.along[lane] += part.along[lane];
      sum.change2[lane] += part.change2[lane];
    }
    for (int k = 0; k < 8; ++k) sum.energy[k] += part.energy[k];
  }
  GradientKernel::Progress total;
  double along = 0;
  for (int lane = 0; lane < kLanes; ++lane) {
    along += sum.along[lane];
    total.change2 += sum.change2[lane];
  }
  // (y - x⁺)·(x⁺ - x), as y = x + beta (x - x⁻).
  total.turn = rho_ * (beta * along - total.change2);
  total.change2 *= rho_;
  for (const int k : {kRowX, kRowY, kRowSpin})  // the last value moves nothing
    total.energy += sum.energy[k] + sum.energy[k + 4];
  if (neighbours_ == nullptr) return total;
  const Roles& r = roles_;
  return neighbours_->total(disks_, total, momentum_[r.now], momentum_[r.before]);
}

/// Number of iterations of the next group: up to the predicted restart. The restart indicator rises
/// almost linearly, so that few iterations are discarded.
template <int D>
int TiledGradient<D>::before_restart() const {
  if (since_restart_ < 2) {
    // Only the distance of the last two restarts is known.
    return std::clamp(interval_ > 0 ? interval_ / 2 : kAtFirst, 1, group_);
  }
  const double rise = turn_ - turn_before_;
  return -turn_ < rise * group_ ? 1 + static_cast<int>(-turn_ / rise) : group_;
}

template <int D>
void TiledGradient<D>::advance(int iterations, GradientKernel::Control& control) {
  std::vector<double> beta, t;
  while (iterations > 0) {
    set_step(control.step / control.lambda);
    const int group = std::min(iterations, before_restart());
    beta.assign(1, beta_);
    t.assign(1, control.t);
    for (int k = 1; k < group; ++k) {
      const double last = t.back();
      t.push_back(next_momentum(last));
      beta.push_back((last - 1) / t.back());
    }
    run(group, beta, control);

    int good = 0;  // iterations that stand
    bool restart = false, raised = false;
    double raised_to = 0, change2 = change2_;
    while (good < group && !restart) {
      const GradientKernel::Progress sums = totals(good, beta[to_size(good)]);
      if (sums.energy > control.lambda * change2) {
        // The estimate of the largest eigenvalue proved too small in the step before.
        raised = true;
        raised_to = kSpectralMargin * sums.energy / change2;
        break;
      }
      change2 = sums.change2;
      turn_before_ = turn_;
      turn_ = sums.turn;
      restart = sums.turn > 0;
      ++good;
    }
    if (good > 0 && good < group) run(good, beta, control);
    if (good > 0) {
      roles_ = after(good);
      change2_ = change2;
      const double last = restart ? 1 : t[to_size(good) - 1];
      control.t = next_momentum(last);
      beta_ = (last - 1) / control.t;
      since_restart_ += good;
      iterations -= good;
    }
    if (raised) {
      control.lambda = raised_to;
      control.t = 1;
      beta_ = 0;
    }
    if (restart || raised) {
      interval_ = since_restart_;
      since_restart_ = 0;
    }
  }
}

BIPOT_FOR_BODIES(template class TiledGradient);

}  // namespace bipot
