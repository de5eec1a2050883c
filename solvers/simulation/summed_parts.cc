#include "solvers/simulation/summed_parts.h"

#include <algorithm>
#include <utility>

namespace bipot {
namespace {

/// Both lists are sorted by (i, j). Frames, velocities and statuses are those of the later part.
template <int D>
std::vector<ContactOutcome<D>> added(const std::vector<ContactOutcome<D>>& first,
                                     const std::vector<ContactOutcome<D>>& second) {
  std::vector<ContactOutcome<D>> sum;
  const auto add_opened = [&](ContactOutcome<D> c) {
    c.bonded = false;
    sum.push_back(c);
  };
  auto a = first.begin();
  for (const ContactOutcome<D>& b : second) {
    for (; a != first.end() && a->contact.pair() < b.contact.pair(); ++a) add_opened(*a);
    ContactOutcome<D> both = b;
    if (a != first.end() && a->contact.pair() == b.contact.pair()) {
      both.s_n += a->s_n;
      both.s_t += a->s_t;
      both.moment += a->moment;
      ++a;
    }
    sum.push_back(both);
  }
  for (; a != first.end(); ++a) add_opened(*a);
  return sum;
}

}  // namespace

template <int D>
void SummedParts<D>::add(const StepReport<D>& part,
                         const std::vector<ContactOutcome<D>>& contacts) {
  const StepReport<D> before = std::exchange(total_, part);
  if (count_++ > 0) {
    total_.add_cost(before);
    if (!before.converged) {
      total_.converged = false;
      total_.message = before.message;
    }
    total_.energy.imbalance += before.energy.imbalance;
    total_.momentum_imbalance += before.momentum_imbalance;
    total_.unsolvable = total_.unsolvable || before.unsolvable;
    total_.penetration = std::max(total_.penetration, before.penetration);
    if (before.overlap > total_.overlap) {
      total_.overlap = before.overlap;
      total_.overlap_pair = before.overlap_pair;
    }
    total_.travel += before.travel;
    total_.joint_loss += before.joint_loss;
    total_.force_energy += before.force_energy;
    total_.from_rest += before.from_rest;
    total_.passages += before.passages;
    if (before.passages > 0) total_.passage = before.passage;
    total_.contacts = std::max(total_.contacts, before.contacts);
    total_.active = std::max(total_.active, before.active);
    if (before.error.guarded() > total_.error.guarded()) total_.error = before.error;
  }
  contacts_ = added(contacts_, contacts);
}

template <int D>
StepReport<D> SummedParts<D>::finish(const State<D>& before, double h, State<D>& state) {
  state.time = total_.time = time_after_step(before, h);
  state.step = total_.step = before.step + 1;
  state.contacts = std::move(contacts_);
  total_.add_cost(attempts_);
  return std::move(total_);
}

template class SummedParts<2>;
template class SummedParts<3>;

}  // namespace bipot
