#include "solvers/registry.h"

#include "solvers/gauss_seidel.h"
#include "solvers/interior_point.h"
#include "solvers/uzawa.h"

namespace bipot {
namespace {

const SolverEntry kSolvers[] = {
    {.name = "uzawa",
     .summary = "bi-potential Uzawa, one predictor-corrector per contact (41)",
     .run = &solve_uzawa,
     .parameters = kUzawaParameters},
    {.name = "pgs",
     .summary = "projected block Gauss-Seidel, NSGS (Jean 1999)",
     .run = &solve_gauss_seidel,
     .parameters = kGaussSeidelParameters},
    {.name = "ipm",
     .summary = "primal-dual interior point on the exact law, arclength continuation, Newton polish",
     .run = &solve_interior_point,
     .parameters = kInteriorPointParameters},
};

}  // namespace

std::span<const SolverEntry> solver_table() { return kSolvers; }

const SolverEntry* find_solver(std::string_view name) {
  for (const SolverEntry& entry : solver_table()) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const SolverEntry& entry : solver_table()) names.emplace_back(entry.name);
  return names;
}

}  // namespace bipot
