"""Frictional contact problems: many solvers, one measure of error.

    p = bipot.Problem(A=A, H=H, v_free=v, u_free=b, mu=mu)   # or W=, u_free=, mu=
    r = bipot.solve(p, tol=1e-8)                              # r.s, r.status, r.epsilon, ...
    e = bipot.judge(p, s)                                     # of anybody's impulse
    rs = bipot.solve([p, p.update(v_free=v2)], threads=2)     # a list of results
    t = bipot.compare([p, "pile:18"], solvers=["apgd", mine], tols=[1e-2, 1e-6])
    for step in bipot.Simulation("scene.toml"): ...
    for state in bipot.Run("out/scene"): ...                  # what `bipot run` wrote

A problem of c contacts with d rows each (m = c d) asks for s with

    u = W s + u_free,    K* contains u + mu |u_t| n, orthogonal to s in K = { |s_t| <= mu s_n }

Contact i owns the entries [i d, (i + 1) d) of s and u: normal first, then tangents; s_n > 0 pushes
apart, u_n > 0 opens. SI units: s in N s, u in m/s. W = H^T A^-1 H in 1/kg.

Bad input raises ValueError or TypeError with the sentence of the command line, a file that cannot
be read or written OSError. How a solve ends is a status, never an exception; Ctrl-C raises
KeyboardInterrupt. Nothing prints. data/manual/tutorial/python.md is a tutorial,
data/manual/explanation/criterion.md defines the errors.
"""

try:
    from ._bipot import (
        Iteration,
        JudgedContact,
        Problem,
        Result,
        SphereState,
        SphereStep,
        State,
        Step,
        StepError,
        Verdict,
        __version__,
    )
except ModuleNotFoundError as error:
    if error.name != "bipot._bipot":
        raise
    from ._missing import how_to_build

    raise ImportError(how_to_build()) from None
from . import _display, _plot
from ._advise import Advice, advise
from ._compare import Comparison, compare, problems
from ._run import Run
from ._simulation import Simulation
from ._solve import judge, read, solve, solvers, write

__all__ = [
    "Advice",
    "Comparison",
    "Iteration",
    "JudgedContact",
    "Problem",
    "Result",
    "Run",
    "Simulation",
    "SphereState",
    "SphereStep",
    "State",
    "Step",
    "StepError",
    "Verdict",
    "advise",
    "compare",
    "judge",
    "problems",
    "read",
    "solve",
    "solvers",
    "write",
]
