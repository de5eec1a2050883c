#include "solvers/analysis/linear_programme.h"

#include <fmt/format.h>

#include <ClpEventHandler.hpp>
#include <ClpSimplex.hpp>
#include <algorithm>
#include <limits>

#include "core/linear/dense_turn.h"

namespace bipot {
namespace {

/// Ends the pivoting when told to. (CLP's own limit of time is looked at rarely.)
class StopHandler : public ClpEventHandler {
 public:
  StopHandler(const std::function<bool()>& stopped, DenseTurn& turn)
      : stopped_(stopped), turn_(turn) {}
  int event(Event happened) override {
    return happened == endOfIteration && turn_.outside(stopped_) ? 0 : -1;
  }
  ClpEventHandler* clone() const override { return new StopHandler(*this); }

 private:
  const std::function<bool()>& stopped_;
  DenseTurn& turn_;  // CLP factors by LAPACK
};

}  // namespace

LinearProgramme::Optimum solve(const LinearProgramme& programme,
                               const std::function<bool()>& stopped) {
  SparseMatrix A = programme.A;
  A.makeCompressed();
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols());
  const Vector zero = Vector::Zero(std::max(rows, columns));
  const Vector upper = programme.upper.cwiseMin(std::numeric_limits<double>::max());

  ClpSimplex model;
  model.setLogLevel(0);
  model.scaling(0);  // its own scaling takes rounding for data; the programmes come equilibrated
  model.loadProblem(columns, rows, A.outerIndexPtr(), A.innerIndexPtr(), A.valuePtr(), zero.data(),
                    upper.data(), programme.cost.data(), zero.data(), zero.data());
  model.setPrimalTolerance(1e-9);
  model.setDualTolerance(1e-9);
  DenseTurn turn;
  const StopHandler handler(stopped, turn);
  model.passInEventHandler(&handler);
  model.dual();

  LinearProgramme::Optimum optimum{.pivots = model.numberIterations()};
  if (model.status() != 0) {
    optimum.message = model.status() == 5 ? fmt::format("stopped after {} pivots", optimum.pivots)
                                          : fmt::format("CLP ended with status {}", model.status());
    return optimum;
  }
  optimum.found = true;
  optimum.value = model.objectiveValue();
  optimum.x = Eigen::Map<const Vector>(model.primalColumnSolution(), columns);
  optimum.y = Eigen::Map<const Vector>(model.dualRowSolution(), rows);
  return optimum;
}

}  // namespace bipot
