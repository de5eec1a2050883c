#include "solvers/parallel/distributed_monitor.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/stop_rule.h"

namespace bipot {
namespace {

constexpr double ErrorSums::*kErrorFields[] = {&ErrorSums::friction,    &ErrorSums::gap,
                                               &ErrorSums::gap_clipped, &ErrorSums::penetration,
                                               &ErrorSums::natural,     &ErrorSums::moved,
                                               &ErrorSums::natural_rel, &ErrorSums::impulse2,
                                               &ErrorSums::free_energy, &ErrorSums::free_impulse2};
constexpr std::size_t kFields = std::size(kErrorFields);

}  // namespace

DistributedError::DistributedError(DistributedSpace& space)
    : space_(space), weights_(error_weights(space.problem(), space.diagonal())) {}

/// Sums of the contacts that are here, or, with `exact`, each contact's terms put into these.
ErrorSums DistributedError::local_sums(ExactSum* exact) {
  const ContactProblem& p = space_.problem();
  const bool scaled = p.row_scale.size() != 0;
  worst_ = {};
  ErrorSums sums;
  dispatch_dim(p.dim, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c < p.num_contacts(); ++c) {
      ErrorSums part;
      ErrorSums& to = exact != nullptr ? part : sums;
      const auto add = [&](auto is_scaled) {
        return add_error_terms<D, is_scaled()>(p, c, s_, u_, weights_.w_nn[c], weights_.rho_nn[c],
                                               weights_.rho_nat[c], to);
      };
      const ContactTerms terms = scaled ? add(std::true_type{}) : add(std::false_type{});
      add_free_terms(p, weights_, c, to);
      if (exact != nullptr) {
        for (std::size_t k = 0; k < kFields; ++k) exact[k] += part.*kErrorFields[k];
      }
      if (terms.violation > worst_.violation)
        worst_ = {terms.violation, worst_.natural, c, worst_.eta};
      if (terms.natural > worst_.natural)
        worst_ = {worst_.violation, terms.natural, worst_.epsilon, c};
    }
  });
  return sums;
}

ContactError DistributedError::operator()(const Vector& s, std::span<double> more) {
  const ContactProblem& p = space_.problem();
  s_ = s;
  dispatch_dim(p.dim, [&](auto d) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      if (p.row_scale.size() != 0) {
        project_physically<d(), true>(p, c, s_);
      } else {
        project_physically<d(), false>(p, c, s_);
      }
    }
  });
  space_.velocity(s_, u_);
  ErrorSums whole;
  if (space_.exact()) {
    std::vector<ExactSum> sums(kFields + more.size());
    local_sums(sums.data());
    for (std::size_t k = 0; k < more.size(); ++k) sums[kFields + k] += more[k];
    std::vector<double> totals(sums.size());
    space_.totals(sums, totals);
    for (std::size_t k = 0; k < kFields; ++k) whole.*kErrorFields[k] = totals[k];
    for (std::size_t k = 0; k < more.size(); ++k) more[k] = totals[kFields + k];
  } else {
    const ErrorSums local = local_sums(nullptr);
    std::vector<double> values;
    for (const auto field : kErrorFields) values.push_back(local.*field);
    values.insert(values.end(), more.begin(), more.end());
    space_.sum(values);
    for (std::size_t k = 0; k < kFields; ++k) whole.*kErrorFields[k] = values[k];
    for (std::size_t k = 0; k < more.size(); ++k) more[k] = values[kFields + k];
  }
  return error_of(whole);
}

/// The whole's number of the contact with the largest value; the smallest number of equal ones.
int DistributedError::number_of_largest(double value, int contact) {
  double largest = value;
  space_.group().largest({&largest, 1});
  double number = -kInfinity;
  if (contact >= 0 && value == largest) number = -space_.piece().number[to_size(contact)];
  space_.group().largest({&number, 1});
  return std::isfinite(number) ? static_cast<int>(-number) : -1;
}

ContactError DistributedError::with_worst(const Vector& s) {
  ContactError error = (*this)(s);
  error.worst_epsilon = number_of_largest(worst_.violation, worst_.epsilon);
  error.worst_eta = number_of_largest(worst_.natural, worst_.eta);
  return error;
}

DistributedMonitor::DistributedMonitor(DistributedSpace& space, DistributedError& evaluate,
                                       const SolverOptions& options, Claim claim, Lead lead)
    : space_(space),
      evaluate_(evaluate),
      options_(options),
      claim_(std::move(claim)),
      lead_(std::move(lead)),
      best_s_(Vector::Zero(space.problem().num_rows())) {
  free_energy_ = evaluate_(best_s_).energy;
}

bool DistributedMonitor::due(int iteration) {
  if (options_.stop == StopTest::kImpulse || iteration >= next_ ||
      iteration >= options_.max_iterations) {
    return true;
  }
  if (iteration < next_poll_) return false;
  next_poll_ = iteration + kPolled;
  if (space_.group().any(late() || cancelled())) next_ = iteration;
  return iteration >= next_;
}

int DistributedMonitor::undue(int iteration, int most) const {
  if (options_.stop == StopTest::kImpulse) return 1;
  return std::clamp(std::min(next_, options_.max_iterations) - iteration, 1, most);
}

bool DistributedMonitor::stop(int iteration, const Vector& s, double step, bool moving) {
  iterations_ = iteration;
  if (!due(iteration)) return false;
  next_ = next_judged(iteration);

  const bool comparable =
      previous_.size() == s.size() && previous_iteration_ >= 0 && previous_iteration_ < iteration;
  // Norms of the iterate and of its change ride along; so do the processes' wishes to stop.
  double norm2 = 0, change2 = 0;
  if (space_.exact()) {
    norm2 = space_.dot(s, s);
    if (comparable) change2 = space_.dot(s - previous_, s - previous_);
  }
  double more[4] = {0, 0, cancelled() ? 1.0 : 0.0, late() ? 1.0 : 0.0};
  if (!space_.exact()) {
    more[0] = s.squaredNorm();
    if (comparable) more[1] = (s - previous_).squaredNorm();
  }
  last_ = evaluate_(s, more);
  if (!space_.exact()) {
    norm2 = more[0];
    change2 = more[1];
  }
  double change = kInfinity;
  if (comparable && norm2 > 0) change = std::sqrt(change2) / std::sqrt(norm2);

  const double error = last_.guarded();
  if (error < best_error_) {
    best_error_ = error;
    best_s_ = evaluate_.impulse();
  }
  bool met = false;
  if (options_.stop == StopTest::kImpulse) {
    met = previous_iteration_ == iteration - 1 && change <= options_.tol;
  } else {
    met = meets(options_, last_) && claim_(evaluate_.impulse(), last_);
  }
  if (options_.on_iteration) {
    const ContactCount here = count_contacts(space_.problem(), evaluate_.impulse());
    std::int64_t counts[3] = {here.take_off, here.stick, here.slip};
    space_.group().sum(counts);
    options_.on_iteration({.iteration = iteration,
                           .seconds = watch_.seconds(),
                           .error = last_,
                           .step = step,
                           .count = {static_cast<int>(counts[0]), static_cast<int>(counts[1]),
                                     static_cast<int>(counts[2])}});
  }
  if (met) {
    best_s_ = evaluate_.impulse();
    best_error_ = error;
  }
  free_energy_ = divergence_reference(iteration, last_, free_energy_);
  StopVerdict verdict = stop_verdict(options_, {.iteration = iteration,
                                                .error = last_,
                                                .best_error = best_error_,
                                                .free_energy = free_energy_,
                                                .change = change,
                                                .moving = moving,
                                                .met = met});
  if (verdict.status == SolveStatus::kNotRun) {
    verdict = out_of_time_verdict(options_, more[2] > 0, more[3] > 0, iteration, best_error_);
  }
  status_ = verdict.status;
  message_ = std::move(verdict.message);
  previous_ = s;
  previous_iteration_ = iteration;
  return status_ != SolveStatus::kNotRun;
}

SolveResult DistributedMonitor::finish() {
  SolveResult result;
  result.status = status_;
  result.message = message_;
  result.s = best_s_;
  result.iterations = iterations_;
  result.setup_seconds = setup_seconds_;
  result.solve_seconds = watch_.seconds() - setup_seconds_;
  return result;
}

}  // namespace bipot
