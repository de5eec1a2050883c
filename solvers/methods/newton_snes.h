#pragma once

#include "solvers/methods/proximal_point.h"
#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kNewtonParameters[] = {
    {.name = "residual",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "alart-curnier",
     .choices = "alart-curnier|fischer-burmeister|snesvi",
     .help = "nonsmooth equation; snesvi: PETSc's reduced-space variational inequality, d = 1"},
    {.name = "form",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "auto",
     .choices = "auto|contact|mixed",
     .help = "unknowns: impulses with explicit W, or velocities and impulses with A and H"},
    {.name = "linear",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "auto",
     .choices = "auto|umfpack|mumps|petsc|gmres",
     .help = "sparse LU (auto: PETSc's own up to 4000 rows, then UMFPACK), or GMRES with ILU"},
    {.name = "line_search",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "basic",
     .choices = "basic|bt|l2|cp",
     .help = "SNES line search"},
    {.name = "start_sweeps",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "100",
     .minimum = 0,
     .maximum = 1e9,
     .help = "Gauss-Seidel sweeps before the first Newton step",
     .unit = "sweeps"},
    {.name = "inner_iterations",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "20",
     .minimum = 1,
     .maximum = 1e9,
     .help = "Newton steps in one proximal step before it counts as failed",
     .unit = "iterations"},
    kKappaParameter,
    kLargestKappaParameter,
    {.name = "petsc",
     .kind = ParameterSpec::Kind::kText,
     .default_value = "",
     .help = "PETSc options for this solve, for instance '-snes_monitor -ksp_view'"},
};

/// Nonsmooth Newton on PETSc's SNES: the residual of Alart and Curnier (1991) or the
/// Fischer-Burmeister function of the Jordan product, see contact_residual.h, one element of the
/// generalized Jacobian, inside the proximal loop of proximal_point.h (W is singular in every dense
/// packing), after a start by Gauss-Seidel sweeps. An iteration is one Newton step.
///
/// Unknowns are equilibrated, x = D^{1/2} s and y = diag(A)^{1/2} (v - v_free), over the norm of
/// the free violation: residuals have no unit. Every iterate is judged by the run; SNES's own
/// converged reasons decide nothing. The message reports the steps, the last kappa and PETSc's own
/// reason where a step failed.
///
/// The options string reaches PETSc's options database under the prefix `bipot_newton_`, for the
/// time of the solve; options that PETSc did not use are named in the message. PETSc's start, at
/// the first call of a process, counts as set-up; its errors become a status
/// (solvers/petsc/petsc_session.h).
///
/// The run's factor, where it has one, factors Newton's systems with linear = auto and mumps, not
/// with residual = snesvi, whose systems change their size. A matrix that it cannot factor is a
/// failed step, what it throws is thrown here.
void solve_newton_snes(SolveRun& run);

}  // namespace bipot
