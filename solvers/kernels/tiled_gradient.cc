#include "solvers/kernels/tiled_gradient.h"

#include <algorithm>
#include <cmath>

#include "solvers/kernels/spectral_estimate.h"
#include "solvers/kernels/wavefront.h"

namespace bipot {
namespace {

/// Iterations in flight for each iteration between restarts: few are thrown away.
constexpr int kCaution = 6;
/// Threads begin and end together: at most so many iterations are done in between.
constexpr int kTogether = 16;

}  // namespace

double next_momentum(double t) { return 0.5 * (1 + std::sqrt(1 + 4 * t * t)); }

template <int D>
TiledGradient<D>::TiledGradient(const ContactProblem& problem, const DiskStructure& disks,
                                const ContactScaling& scaling, const Execution& options,
                                GradientNeighbours<D>* neighbours)
    : disks_(problem, disks, scaling),
      kernels_(disk_kernels<D>(options.path)),
      neighbours_(neighbours),
      threads_(options.threads),
      depth_(disks_.pipeline_depth(threads_, kStreamed)),
      asks_ahead_(disks_.asks_ahead(kStreamed)),
      group_(neighbours != nullptr ? 1
             : threads_ > 1        ? std::max(depth_, kTogether)
                                   : depth_),
      velocity_(to_size(disks_.num_rows())),
      sums_(to_size(group_) * to_size(disks_.num_tiles())),
      energy_(sums_.size()) {
  // One iteration at a time never comes to the last buffers.
  for (int k = 0; k < (group_ > 1 ? 4 : 3); ++k) {
    impulse_[k].resize(to_size(disks_.num_batches()));
    momentum_[k].resize(to_size(disks_.num_rows()));
  }
}

template <int D>
void TiledGradient<D>::reset(const Vector& s) {
  roles_ = {};
  disks_.pack(s, impulse_[roles_.now]);
  disks_.push(impulse_[roles_.now], momentum_[roles_.now]);
  if (neighbours_ != nullptr) {
    neighbours_->complete(disks_, impulse_[roles_.now], momentum_[roles_.now]);
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
typename TiledGradient<D>::Roles TiledGradient<D>::after(int iterations) const {
  Roles r = roles_;
  for (int k = 0; k < iterations; ++k) {
    // The first two iterations keep what the group started from, the later ones write over theirs.
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
                           const GradientControl& control) {
  std::vector<Roles> roles;
  for (int k = 0; k <= iterations; ++k) roles.push_back(after(k));
  const int tiles = disks_.num_tiles(), middle = first_upper_tile(tiles);
  const auto extrapolate = [&](int k, int t) {
    const ContactTiles::Tile& tile = disks_.tile(t);
    const std::size_t row = to_size(tile.first_row);
    MomentumTask task;
    task.rows = tile.last_row - tile.first_row;
    task.ask_ahead = asks_ahead_;
    task.beta = beta[to_size(k)];
    task.now = &momentum_[to_size(roles[to_size(k)].now)][row];
    task.before = &momentum_[to_size(roles[to_size(k)].before)][row];
    task.inverse = disks_.inverse() + row;
    task.velocity = &velocity_[row];
    task.next = &momentum_[to_size(roles[to_size(k) + 1].now)][row];
    kernels_.extrapolate(task, energy_[to_size(k * tiles + t)]);
  };
  run_wavefront(threads_, tiles, iterations, depth_, [&](int k, int t) {
    // The contacts of a tile touch its bodies and those of the tile below.
    if (t < middle || t == tiles - 1) extrapolate(k, t);
    if (t > middle) extrapolate(k, t - 1);
    const ContactTiles::Tile& tile = disks_.tile(t);
    const std::size_t batch = to_size(tile.first_batch);
    const Roles& role = roles[to_size(k)];
    const std::size_t next = to_size(roles[to_size(k) + 1].now);
    GradientTask<D> task;
    task.batches = tile.last_batch - tile.first_batch;
    task.beta = beta[to_size(k)];
    task.ask_ahead = asks_ahead_;
    task.rho = control.step / control.lambda;
    task.cone = control.cone;
    task.contact = disks_.contacts(tile);
    task.law = disks_.law_numbers(tile);
    task.laws = disks_.laws();
    task.now = &impulse_[to_size(role.now)][batch];
    task.before = &impulse_[to_size(role.before)][batch];
    task.next = &impulse_[next][batch];
    task.velocity = velocity_.data();
    task.momentum = momentum_[next].data();
    kernels_.gradient(task, sums_[to_size(k * tiles + t)]);
  });
  if (neighbours_ != nullptr) {
    const std::size_t next = to_size(roles.back().now);
    neighbours_->complete(disks_, impulse_[next], momentum_[next]);
  }
}

template <int D>
GradientProgress TiledGradient<D>::totals(int iteration) const {
  GradientSums sum;
  EnergySums energy;
  for (int t = 0; t < disks_.num_tiles(); ++t) {
    const std::size_t at = to_size(iteration * disks_.num_tiles() + t);
    const GradientSums& part = sums_[at];
    for (int lane = 0; lane < kLanes; ++lane) {
      sum.turn[lane] += part.turn[lane];
      sum.change2[lane] += part.change2[lane];
    }
    for (int k = 0; k < 4; ++k) energy.energy[k] += energy_[at].energy[k];
  }
  GradientProgress total;
  for (int lane = 0; lane < kLanes; ++lane) {
    total.turn += sum.turn[lane];
    total.change2 += sum.change2[lane];
  }
  for (const int k : {kRowX, kRowY, kRowSpin}) total.energy += energy.energy[k];
  if (neighbours_ == nullptr) return total;
  const Roles& r = roles_;
  return neighbours_->total(disks_, total, momentum_[r.now], momentum_[r.before]);
}

template <int D>
void TiledGradient<D>::advance(int iterations, GradientControl& control) {
  std::vector<double> beta, t;
  while (iterations > 0) {
    const int cautious =
        control.momentum ? 1 + std::max(interval_, since_restart_) / kCaution : group_;
    const int group = std::min({iterations, group_, cautious});
    beta.assign(1, beta_);
    t.assign(1, control.t);
    for (int k = 1; k < group; ++k) {
      const double last = control.momentum ? t.back() : 1;
      t.push_back(next_momentum(last));
      beta.push_back((last - 1) / t.back());
    }
    run(group, beta, control);

    int good = 0;  // iterations that stand
    bool restart = false, raised = false;
    double raised_to = 0, change2 = change2_;
    while (good < group && !restart) {
      const GradientProgress sums = totals(good);
      if (sums.energy > control.lambda * change2) {
        // A larger eigenvalue than the estimate has shown itself in the step before.
        raised = true;
        raised_to = kSpectralMargin * sums.energy / change2;
        break;
      }
      change2 = sums.change2;
      restart = sums.turn > 0;
      ++good;
    }
    if (good > 0 && good < group) run(good, beta, control);
    if (good > 0) {
      roles_ = after(good);
      change2_ = change2;
      const double last = restart || !control.momentum ? 1 : t[to_size(good) - 1];
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

template class TiledGradient<1>;
template class TiledGradient<2>;

}  // namespace bipot
