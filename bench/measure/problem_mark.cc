#include "bench/measure/problem_mark.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/problem/delassus.h"

namespace bipot {

bool ProblemMark::fits(const ProblemMark& other) const {
  const auto near = [](double a, double b) {
    return !(std::abs(a - b) > 1e-6 * std::max(std::abs(a), std::abs(b)));
  };
  return near(velocity, other.velocity) && near(friction, other.friction) &&
         near(mobility, other.mobility);
}

ProblemMark mark_of(const ContactProblem& p) {
  return {.velocity = p.u_free.norm(),
          .friction = p.mu.sum() + p.mu_r.sum() + p.mu_spin.sum(),
          .mobility = p.num_rows() > 0 ? DelassusOperator(p).diagonal().sum() : 0.0};
}

std::string to_string(const ProblemMark& mark) {
  return fmt::format("|u_free| {:.6g}, friction {:.6g}, trace of W {:.6g}", mark.velocity,
                     mark.friction, mark.mobility);
}

}  // namespace bipot
