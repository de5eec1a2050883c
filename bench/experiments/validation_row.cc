#include "bench/experiments/validation_row.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/experiments/validation_experiments.h"

namespace bipot {

ValidationRow validation_row(std::string group, std::string name, std::string quantity,
                             std::string source, std::string formula, Expectation range,
                             double allowed, std::string allowed_why, std::string bar,
                             bool takes_tolerance) {
  return {.claim = {.name = std::move(name),
                    .quantity = std::move(quantity),
                    .expected = std::move(formula),
                    .source = std::move(source),
                    .bar_is = std::move(bar)},
          .group = std::move(group),
          .range = range,
          .allowed = allowed,
          .allowed_why = std::move(allowed_why),
          .takes_tolerance = takes_tolerance};
}

SolverChoice ValidationContext::choice(double tol) const {
  return SolverChoice{.name = solver,
                      .tol = tol,
                      .max_iterations = max_iterations,
                      .parameters = {{"islands", "off"}}};
}

std::vector<double> decades(int first, int last) {
  std::vector<double> tols;
  for (int k = first; k <= last; ++k) tols.push_back(std::pow(10.0, -k));
  return tols;
}

std::vector<ValidationExperiment> validation_experiments() {
  std::vector<ValidationExperiment> all;
  for (const auto& group : {slope_experiments(), standing_experiments(), impact_experiments(),
                            chain_experiments(), indeterminacy_experiments(), packing_experiments(),
                            force_experiments(), flow_experiments(), silo_experiments()}) {
    all.insert(all.end(), group.begin(), group.end());
  }
  return all;
}

}  // namespace bipot
