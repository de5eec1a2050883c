#pragma once

#include "solvers/methods/proximal_point.h"
#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kNewtonParameters[] = {
    ParameterSpec::choice(
        "residual", "alart-curnier", "alart-curnier|fischer-burmeister|snesvi",
        "nonsmooth equation; snesvi: PETSc's reduced-space variational inequality, d = 1"),
    ParameterSpec::choice(
        "form", "auto", "auto|contact|mixed",
        "unknowns: impulses with explicit W, or velocities and impulses with A and H"),
    ParameterSpec::choice(
        "linear", "auto", "auto|umfpack|mumps|petsc|gmres",
        "sparse LU (auto: PETSc's own up to 4000 rows, then UMFPACK), or GMRES with ILU"),
    ParameterSpec::choice("line_search", "basic", "basic|bt|l2|cp", "SNES line search"),
    ParameterSpec::integer("start_sweeps", "100", {0, 1e9},
                           "Gauss-Seidel sweeps before the first Newton step", "sweeps"),
    ParameterSpec::integer("inner_iterations", "20", {1, 1e9},
                           "Newton steps in one proximal step before it counts as failed",
                           "iterations"),
    kKappaParameter,
    kLargestKappaParameter,
    ParameterSpec::text("petsc", "",
                        "PETSc options for this solve, for instance '-snes_monitor -ksp_view'"),
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
