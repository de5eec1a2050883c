"""One problem: files, solve, judge."""

from __future__ import annotations

import os
from typing import Any, Callable, Iterable, Sequence, overload

from . import _bipot
from ._bipot import Iteration, Problem, Result, Verdict
from ._names import (
    a_problem,
    count,
    integer,
    named_options,
    number,
    parameter_texts,
    refuse_unknown,
    text,
    wrong_type,
)

Solver = str | Callable[[Problem, float, Callable[[Any], bool]], Any]

_SOLVE_OPTIONS = ["solver", "tol", "s0", "time_limit", "stop", "max_iterations", "threads", "callback"]


def read(path: str | os.PathLike[str], *, accept_indefinite: bool = False) -> Problem:
    """The problem of a file: FCLIB HDF5 or Siconos text, the content decides.

    accept_indefinite: take a W that is no Delassus operator; every verdict says so.
    `solution` and `guesses` of what is returned are the file's, where it has any.
    Raises FileNotFoundError, and ValueError with the reason for a file that is no sound problem.
    """
    return _bipot.read(os.fspath(path), accept_indefinite)


@named_options
def write(
    problem: Problem,
    path: str | os.PathLike[str],
    *,
    s: Any = None,
    title: str = "",
    description: str = "",
    guesses: Iterable[Any] = (),
) -> None:
    """Writes an FCLIB file (HDF5): global form where the problem has bodies, else W.

    s: (m,) impulse for /solution [N s]; guesses: impulses for /guesses, each (m,).
    An existing file is replaced, whole or not at all. Raises OSError, and ValueError for arrays that
    do not fit. FCLIB has no problem without contacts.
    """
    _bipot.write(
        a_problem(problem),
        os.fspath(path),
        s,
        text(title, "title"),
        text(description, "description"),
        list(guesses),
    )


@overload
def solve(problem: Problem, **options: Any) -> Result: ...
@overload
def solve(problem: Sequence[Problem], **options: Any) -> list[Result]: ...
def solve(
    problem: Problem | Sequence[Problem],
    *,
    solver: Solver = "auto",
    tol: float = 1e-8,
    s0: Any = None,
    time_limit: float = 10,
    stop: str = "guarded",
    max_iterations: int = 1_000_000,
    threads: int = 1,
    callback: Callable[[Iteration], bool | None] | None = None,
    **parameters: float | int | str,
) -> Result | list[Result]:
    """Solves a problem, or each of a list of problems, to the guarded error max(epsilon, eta) <= tol.

    solver: a name of `solvers()`, or a callable f(problem, tol, callback) -> s, see `compare`.
    s0: (m,) impulse to start from [N s]; None: 0. Of a list of problems, a list.
    time_limit: wall seconds of a solve, > 0; float("inf"): none.
    stop: what is held against tol: "guarded", "raw42" (the paper's) or "impulse" (its change).
    threads: problems of a list that are solved at a time. Results are the same bits for any number.
    callback: called with every judged iteration of a single problem, by the fields of
        `Result.history`; returning True ends the solve with the status "interrupted". What it
        raises is raised here, once the solver has stopped.
    parameters: the solver's own, by name: `omega=1.5`.

    How it ended is `status` of the result, also where it failed; the result is true in a condition
    if it converged. Bad input is refused: ValueError, TypeError for an option or parameter that
    does not exist. Ctrl-C: KeyboardInterrupt. Other Python threads run on while a built-in solver
    works.
    """
    if parameters:
        own = _bipot.parameter_names(solver) if isinstance(solver, str) else []
        refuse_unknown(parameters, [*own, *_SOLVE_OPTIONS])
        parameters = parameter_texts(parameters)
    tol, time_limit = number(tol, "tol"), number(time_limit, "time_limit")
    stop, max_iterations = text(stop, "stop"), integer(max_iterations, "max_iterations")
    threads = integer(threads, "threads")
    if threads < 1:
        raise ValueError(f"threads = {threads}, expected >= 1")
    if isinstance(problem, Problem):
        if threads > 1:
            raise ValueError("threads are for a list of problems")
        return _bipot.solve(
            problem, solver, tol, s0, time_limit, stop, max_iterations, parameters, callback
        )
    if not isinstance(problem, (list, tuple)):
        raise wrong_type("problem", "a bipot.Problem or a list of them", problem)
    for k, one in enumerate(problem):
        a_problem(one, f"problem {k}")
    if callback is not None:
        raise ValueError("a callback is for a single problem")
    starts = [] if s0 is None else list(s0)
    if starts and len(starts) != len(problem):
        raise ValueError(f"s0 has {len(starts)} starts for {len(problem)} problems")
    return _bipot.solve_all(
        problem, solver, tol, starts, time_limit, stop, max_iterations, parameters, threads
    )


@named_options
def judge(problem: Problem, s: Any, *, worst: int = 5) -> Verdict:
    """How wrong the impulse s is, whoever computed it, and where.

    s: (m,) finite numbers [N s], contact by contact, normal first, s_n > 0 pushing.
    worst: how many contacts are named at most.

    All of the verdict is that of s projected on the friction cone, as the criterion asks, but for
    `cone`, `cone_violation` and `siconos_map`, which are those of s as it is. Raises ValueError for
    a wrong size or a number that is not finite.
    """
    return _bipot.judge(a_problem(problem), s, count(worst, "worst", least=0))


def solvers() -> list[dict[str, Any]]:
    """The solvers of this build, each with name, summary, max_dim, max_contacts and parameters
    (name, kind, default, minimum, maximum, choices, unit, help)."""
    return _bipot.solvers()
