#include "solvers/analysis/linear_programme.h"

#include <Clp_C_Interface.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace bipot {

LinearProgramme::Optimum solve(const LinearProgramme& programme, double seconds) {
  SparseMatrix A = programme.A;
  A.makeCompressed();
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols());
  const Vector zero = Vector::Zero(std::max(rows, columns));
  const Vector upper = programme.upper.cwiseMin(std::numeric_limits<double>::max());

  const std::unique_ptr<Clp_Simplex, void (*)(Clp_Simplex*)> model(Clp_newModel(),
                                                                   &Clp_deleteModel);
  Clp_setLogLevel(model.get(), 0);
  Clp_loadProblem(model.get(), columns, rows, A.outerIndexPtr(), A.innerIndexPtr(), A.valuePtr(),
                  zero.data(), upper.data(), programme.cost.data(), zero.data(), zero.data());
  Clp_setPrimalTolerance(model.get(), 1e-9);
  Clp_setDualTolerance(model.get(), 1e-9);
  Clp_setMaximumSeconds(model.get(), std::min(seconds, 1e8));
  Clp_dual(model.get(), 0);

  LinearProgramme::Optimum optimum{.pivots = Clp_numberIterations(model.get())};
  const int status = Clp_status(model.get());
  if (status != 0) {
    optimum.message = status == 3 ? fmt::format("out of time after {} pivots", optimum.pivots)
                                  : fmt::format("CLP ended with status {}", status);
    return optimum;
  }
  optimum.found = true;
  optimum.value = Clp_objectiveValue(model.get());
  optimum.x = Eigen::Map<const Vector>(Clp_primalColumnSolution(model.get()), columns);
  optimum.y = Eigen::Map<const Vector>(Clp_dualRowSolution(model.get()), rows);
  return optimum;
}

}  // namespace bipot
