#include "solvers/registry.h"

#include "solvers/accelerated_gradient.h"
#include "solvers/admm.h"
#include "solvers/anderson.h"
#include "solvers/classical.h"
#include "solvers/gauss_seidel.h"
#include "solvers/uzawa.h"

namespace bipot {
namespace {

const SolverEntry kSolvers[] = {
    {.name = "uzawa",
     .summary = "bi-potential Uzawa, one predictor-corrector per contact (41)",
     .run = &solve_uzawa,
     .parameters = kUzawaParameters},
    {.name = "classical",
     .summary = "two predictor-correctors per contact, normal then friction (the paper's reference)",
     .run = &solve_classical,
     .parameters = kClassicalParameters},
    {.name = "pgs",
     .summary = "projected block Gauss-Seidel, NSGS (Jean 1999)",
     .run = &solve_gauss_seidel,
     .parameters = kGaussSeidelParameters},
    {.name = "apgd",
     .summary = "accelerated projected gradient with restart (Mazhar et al. 2015)",
     .run = &solve_accelerated_gradient,
     .parameters = kAcceleratedGradientParameters},
    {.name = "anderson",
     .summary = "safeguarded Anderson acceleration of Gauss-Seidel sweeps (Walker and Ni 2011)",
     .run = &solve_anderson,
     .parameters = kAndersonParameters},
    {.name = "admm",
     .summary = "operator splitting with sparse Cholesky factors (Boyd et al. 2011)",
     .run = &solve_admm,
     .parameters = kAdmmParameters},
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
