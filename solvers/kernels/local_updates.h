#pragma once

#include <vector>

#include "core/problem/delassus.h"
#include "solvers/kernels/contact_sweep.h"
#include "solvers/kernels/local_coulomb.h"

namespace bipot {

/// How a Gauss-Seidel sweep updates one contact.
struct LocalSettings {
  bool exact = false;        ///< solve_local() instead of improve_local()
  int local_iterations = 1;  ///< of improve_local()
  double omega = 1;          ///< relaxation

  /// Without relaxation one round of projections solves a diagonal block.
  bool one_round() const { return omega == 1 || (!exact && local_iterations == 1); }
};

/// Local problems of all contacts and the update of one of them.
template <ContactRows D>
class LocalUpdates {
 public:
  LocalUpdates(const ContactProblem& p, const DelassusOperator& delassus,
               const LocalSettings& settings)
      : settings_(settings) {
    problems_.reserve(to_size(p.num_contacts()));
    for (int c = 0; c < p.num_contacts(); ++c) {
      problems_.push_back(local_problem<D>(delassus.diagonal_block(c), friction_of<D>(p, c)));
    }
  }

  template <class Sweep>
  void operator()(int c, Sweep& sweep) {
    LocalProblem<D>& local = problems_[to_size(c)];
    const Local<D> s = sweep.impulse(c);
    const Local<D> u = sweep.velocity(c);
    if (settings_.exact) {
      local.q = u - local.w * s;
      Local<D> solution = s;
      if (solve_local<D>(local, solution)) {
        const Local<D> relaxed = s + settings_.omega * (solution - s);
        sweep.set(c, settings_.omega == 1 ? solution : project_coulomb_cone<D>(relaxed, local.mu));
        return;
      }
    }
    sweep.set(c, improve_local<D>(local, s, u, settings_.omega,
                                  settings_.exact ? 1 : settings_.local_iterations));
  }

 private:
  LocalSettings settings_;
  std::vector<LocalProblem<D>> problems_;
};

/// Calls f(sweep, visit) with the fastest sweep for the structure of the problem, at the impulse s
/// = 0. visit(c) updates contact c.
template <ContactRows D, class F>
void with_local_updates(const ContactProblem& p, const DelassusOperator& delassus,
                        const LocalSettings& settings, bool explicit_delassus, F&& f) {
  if constexpr (D < 3) {
    // For diagonal blocks with omega = 1, one round of projections is the exact solution.
    if (delassus.disks() && !explicit_delassus && settings.one_round()) {
      DiskSweep<D> sweep(p, *delassus.disks());
      const Vector diagonal = delassus.diagonal();
      for (int c = 0; c < p.num_contacts(); ++c) {
        const Local<D> w = diagonal.segment<D>(c * D);
        sweep.set_steps(c, settings.omega * w.cwiseInverse(), p.mu[c]);
      }
      f(sweep, [&](int c) { sweep.relax(c); });
      return;
    }
  }
  LocalUpdates<D> update(p, delassus, settings);
  const auto call = [&](auto sweep) { f(sweep, [&](int c) { update(c, sweep); }); };
  if (explicit_delassus) {
    with_explicit_sweep<D>(p, delassus, call);
  } else {
    with_sweep<D>(p, delassus, call);
  }
}

}  // namespace bipot
