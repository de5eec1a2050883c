#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "bench/tradeoff/trade.h"
#include "core/base/types.h"

namespace bipot {

/// Analysis of the rows of one scene.
struct SceneTrade {
  /// All replicas of one setting on one scene.
  struct Cell {
    RunSetting setting;
    int runs = 0, completed = 0;
    std::string status;   ///< "completed", or that of the first replica that was not
    std::string message;  ///< of that replica
    /// Of the scene's quantities over the replicas; NaN unless all were completed.
    std::vector<double> means;
    double cpu = kNaN;  ///< mean of a run                                       [s]
    /// Of a whole run, by the steps that the time limit allowed.                              [s]
    double cpu_needed = kNaN;
    double cpu_per_second = kNaN;  ///< of simulated time
    double iterations = kNaN, penetration = kNaN, worst_guarded = kNaN, stiffness = kNaN;

    bool done() const { return runs > 0 && completed == runs; }
  };
  /// The three scales of error of one outcome, each relative to TradeQuantity::scale.
  struct Errors {
    double reference = kNaN;  ///< exact, or at the shortest step completed
    std::string reference_kind;
    /// Error of the scene's time step: against the exact value; else by Richardson extrapolation,
    /// if three steps halved twice reduce the differences like a power of h; else the largest
    /// difference to shorter steps; else that to twice the step.
    double step_error = kNaN;
    std::string step_error_kind;
    /// Twice the standard error of the difference of two means over the replicas: the difference of
    /// nearby runs. 0 with a single replica.
    double noise = 0;
    /// Largest difference of another solver's outcome at the tightest tolerance. Solvers that solve
    /// every step to it and still end elsewhere chose other answers. NaN if no other solver
    /// completed it.
    double choice = kNaN;
    std::string other_solver;          ///< which
    std::vector<double> solver_error;  ///< of each tolerance of SceneTrade::tols, to the tightest
    double negligible = 0;             ///< of Trade::Options
    /// Bound for the solver's error: max(step_error, noise, negligible, choice where it is known);
    /// NaN if step_error is.
    double bound() const;
    /// Other solvers alone set the bound.
    bool bound_by_choice() const { return choice > std::max({step_error, noise, negligible}); }
    /// Loosest tolerance from which on every solver error is below the bound; none from one
    /// tolerance alone, which is compared with nothing.
    std::optional<double> sufficient_tol;
  };
  const Trade::Scene* scene = nullptr;
  std::vector<Cell> cells;   ///< in the order of the rows
  std::string solver;        ///< the first one
  std::vector<double> tols;  ///< that it completed with the scene's step, loose to tight
  double step_tol = kNaN;    ///< of the runs at other time steps
  std::vector<Errors> quantities;
  /// The tightest of the quantities' sufficient tolerances; none where the errors are unknown.
  std::optional<double> sufficient_tol;
  std::string decided_by;                             ///< the quantity
  double cpu_sufficient = kNaN, cpu_tightest = kNaN;  ///< per simulated second

  const Cell* find(const RunSetting& setting) const;
  /// At the sufficient tolerance, else at the tightest; null if none was completed.
  const Cell* sufficient_cell() const;
  /// Error of a cell's outcome q against the reference; NaN if either is missing.
  double error(const Cell& cell, std::size_t q) const;
  /// The largest of them, and its quantity.
  double worst_error(const Cell& cell, std::size_t* which = nullptr) const;
  /// The answer in a sentence or two.
  std::string answer() const;

 private:
  std::string choice_sentence() const;
  std::string accuracy_sentence() const;
  /// ": give --time-limit 40", by the runs that it cut short; else empty.
  std::string what_is_needed() const;
};

/// The trade must outlive the result.
std::vector<SceneTrade> analyse_trade(const Trade& trade);
std::vector<SceneTrade> analyse_trade(Trade&&) = delete;

}  // namespace bipot
