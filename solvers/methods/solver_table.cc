#include "solvers/auto/auto_solver.h"
#include "solvers/methods/accelerated_gradient.h"
#include "solvers/methods/accelerated_ssor.h"
#include "solvers/methods/admm.h"
#include "solvers/methods/anderson.h"
#include "solvers/methods/convex.h"
#include "solvers/methods/gauss_seidel.h"
#include "solvers/methods/homotopy.h"
#include "solvers/methods/interior_point.h"
#include "solvers/methods/lemke.h"
#include "solvers/methods/load_path.h"
#include "solvers/methods/multistart_newton.h"
#include "solvers/registry.h"
#ifdef BIPOT_WITH_PETSC
#include "solvers/methods/newton_snes.h"
#endif
#include "solvers/methods/pdas.h"
#include "solvers/methods/proximal_point.h"
#include "solvers/methods/pseudo_transient.h"
#ifdef BIPOT_WITH_SICONOS
#include "solvers/methods/siconos.h"
#endif
#include "solvers/methods/tresca.h"
#include "solvers/methods/uzawa.h"

namespace bipot {
namespace {

Parallel in_parallel(const Parameters&) { return Parallel::kYes; }
Parallel reproducible(const Parameters&) { return Parallel::kReproducible; }

// A new row is seen by the command, Python, completions, comparisons and tests over the table. By
// hand: tests/CMakeLists.txt and first_order_test.cc (first-order methods), the manual
// (reference/solvers.md, explanation/parallel.md), README's number of solvers, SOLVERS of
// results_pages.py, kVariants of bench/tune/measure_rows.cc.
const SolverEntry kSolvers[] = {
    {.name = "auto",
     .summary =
         "solvers below in turns, by a plan and by their progress; see bipot solve --explain",
     .run = &solve_auto,
     .parameters = kAutoParameters,
     .rolls = true,
     .parallel = &in_parallel},
    {.name = "uzawa",
     .summary = "bi-potential Uzawa, one predictor-corrector per contact (41)",
     .run = &solve_uzawa,
     .parameters = kUzawaParameters,
     .rolls = true,
     .path_ignores_tolerance = true,
     .parallel = &jacobi_in_parallel},
    {.name = "classical",
     .summary =
         "two predictor-correctors per contact, normal then friction (the paper's reference)",
     .run = &solve_classical,
     .parameters = kUzawaParameters,
     .rolls = true,
     .path_ignores_tolerance = true,
     .parallel = &jacobi_in_parallel},
    {.name = "pgs",
     .summary = "projected block Gauss-Seidel, NSGS (Jean 1999)",
     .run = &solve_gauss_seidel,
     .parameters = kGaussSeidelParameters,
     .rolls = true,
     .path_ignores_tolerance = true,
     .parallel = &sweeps_in_parallel},
    {.name = "apgd",
     .summary = "accelerated projected gradient with restart (Mazhar et al. 2015)",
     .run = &solve_accelerated_gradient,
     .parameters = kAcceleratedGradientParameters,
     .rolls = true,
     .path_ignores_tolerance = true,
     .parallel = &reproducible},
    {.name = "assor",
     .summary = "symmetric successive over-relaxation with momentum (Li, Sun and Toh 2019)",
     .run = &solve_accelerated_ssor,
     .parameters = kAcceleratedSsorParameters,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "anderson",
     .summary = "safeguarded Anderson acceleration of Gauss-Seidel sweeps (Walker and Ni 2011)",
     .run = &solve_anderson,
     .parameters = kAndersonParameters,
     .rolls = true,
     .path_ignores_tolerance = true,
     .parallel = &anderson_in_parallel},
    {.name = "admm",
     .summary = "operator splitting with sparse Cholesky factors (Boyd et al. 2011)",
     .run = &solve_admm,
     .parameters = kAdmmParameters,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "ppa",
     .summary = "proximal point around another solver (Rockafellar 1976)",
     .run = &solve_proximal_point,
     .parameters = kProximalPointParameters,
     .needs_delassus = true,
     .rolls = true},
#ifdef BIPOT_WITH_PETSC
    {.name = "newton",
     .summary = "nonsmooth Newton on PETSc SNES (Alart and Curnier 1991), proximal outer loop",
     .run = &solve_newton_snes,
     .parameters = kNewtonParameters,
     .rolls = true},
#endif
    {.name = "lemke",
     .summary = "exact pivoting reference for tiny problems (Stewart and Trinkle 1996)",
     .run = &solve_lemke,
     .needs_delassus = true,
     .max_dim = 2,
     .max_contacts = kLemkeMaxContacts,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "multistart",
     .summary = "semismooth Newton from many starts, for small problems (Alart and Curnier 1991)",
     .run = &solve_multistart_newton,
     .parameters = kMultistartNewtonParameters,
     .needs_delassus = true,
     .max_contacts = kMultistartMaxContacts,
     .rolls = true},
    {.name = "homotopy",
     .summary = "exact piecewise linear path through opening, stick and slip (Eaves 1976)",
     .run = &solve_homotopy,
     .parameters = kHomotopyParameters,
     .max_dim = 2,
     .rolls = true},
    {.name = "ipm",
     .summary =
         "interior point on the exact law, central path by Taylor series (Nguyen et al. 2025)",
     .run = &solve_interior_point,
     .parameters = kInteriorPointParameters,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "pdas",
     .summary = "primal-dual active sets: open, stick, slip (Abide, Barboteu et al. 2021)",
     .run = &solve_pdas,
     .parameters = kPdasParameters,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "ptc",
     .summary = "Newton's method in pseudo-time, a step a factorisation (Kelley and Keyes 1998)",
     .run = &solve_pseudo_transient,
     .rolls = true,
     .path_ignores_tolerance = true},
    {.name = "tresca",
     .summary = "fixed point on the bounds of friction (Haslinger 1983; Chen, Ly and Wojtan 2024)",
     .run = &solve_tresca,
     .parameters = kTrescaParameters,
     .rolls = true},
#ifdef BIPOT_WITH_SICONOS
    {.name = "siconos:nsgs",
     .summary = "Siconos Numerics: nonsmooth Gauss-Seidel",
     .run = siconos_solver("NSGS"),
     .needs_delassus = true},
    {.name = "siconos:nsn_ac",
     .summary = "Siconos Numerics: nonsmooth Newton, Alart-Curnier",
     .run = siconos_solver("NSN_AC"),
     .needs_delassus = true,
     .max_contacts = kSiconosNewtonMaxContacts},
    {.name = "siconos:admm",
     .summary = "Siconos Numerics: alternating directions",
     .run = siconos_solver("ADMM"),
     .needs_delassus = true},
    {.name = "siconos:prox",
     .summary = "Siconos Numerics: proximal point around its Newton",
     .run = siconos_solver("PROX"),
     .needs_delassus = true,
     .max_contacts = kSiconosNewtonMaxContacts},
    {.name = "siconos:lemke",
     .summary = "Siconos Numerics: Lemke's pivoting",
     .run = siconos_solver("LEMKE"),
     .needs_delassus = true,
     .max_dim = 2,
     .max_contacts = kLemkeMaxContacts},
#endif
};

const SolverEntry kSpecialSolvers[] = {
    {.name = "convex",
     .summary = "another law, for contrast: associated friction, which opens (Anitescu 2006)",
     .run = &solve_convex,
     .rolls = true},
    {.name = "load_path",
     .summary =
         "one pass down the load: ordered packings at rest alone (cf. Guendelman et al. 2003)",
     .run = &solve_load_path},
};

}  // namespace

std::span<const SolverEntry> solver_table() { return kSolvers; }
std::span<const SolverEntry> special_solvers() { return kSpecialSolvers; }

}  // namespace bipot
