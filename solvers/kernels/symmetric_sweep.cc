#include "solvers/kernels/symmetric_sweep.h"

#include <utility>

namespace bipot {

template <int D>
SymmetricSweep<D>::SymmetricSweep(const ContactProblem& problem, const DiskStructure& disks,
                                  const ContactScaling& equilibrated, double omega,
                                  const Execution& options)
    : disks_(problem, disks, equilibrated, order_contacts(disks)),
      kernels_(disk_kernels<D>(options.path)),
      omega_(omega),
      now_(to_size(disks_.num_batches())),
      next_(now_.size()),
      velocity_(to_size(disks_.num_rows())) {}

template <int D>
void SymmetricSweep<D>::reset(const Vector& s) {
  disks_.pack(s, now_);
  refresh();
}

template <int D>
void SymmetricSweep<D>::refresh() {
  disks_.velocities(now_, velocity_);
  before_ = now_;
  velocity_before_ = velocity_;
}

template <int D>
const Vector& SymmetricSweep<D>::impulse() {
  disks_.unpack(now_, s_);
  return s_;
}

template <int D>
double SymmetricSweep<D>::iterate(double beta) {
  // Velocities are linear in the impulses: those of y, over those of x⁻.
  for (std::size_t row = 0; row < velocity_.size(); ++row) {
    for (int k = 0; k < 4; ++k) {
      const double v = velocity_[row].value[k];
      double& before = velocity_before_[row].value[k];
      before = v + beta * (v - before);
    }
  }
  std::swap(velocity_, velocity_before_);
  const ContactTiles::Tile& tile = disks_.tile(0);
  SymmetricTask<D> task;
  task.batches = tile.last_batch;
  task.beta = beta;
  task.omega = omega_;
  task.contact = disks_.contacts(tile);
  task.law = disks_.law_numbers(tile);
  task.laws = disks_.laws();
  task.now = now_.data();
  task.before = before_.data();
  task.next = next_.data();
  task.velocity = velocity_.data();
  task.inverse = disks_.inverse();
  kernels_.sweep_forth(task);
  TurnSums sums;
  kernels_.sweep_back(task, sums);
  std::swap(before_, next_);  // x⁻ was used for the last time
  std::swap(now_, before_);
  double turn = 0;
  for (const double lane : sums.turn) turn += lane;
  return turn;
}

template class SymmetricSweep<1>;
template class SymmetricSweep<2>;

}  // namespace bipot
