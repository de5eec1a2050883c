"""Solvers on problems at tolerances."""

from __future__ import annotations

import json
import os
from typing import Any, Callable, Iterable, Mapping, Sequence

from . import _bipot
from ._bipot import Problem
from ._names import (
    count,
    flag,
    named_options,
    not_negative,
    number,
    optional,
    positive,
    solver_name,
    text,
)
from ._solve import Solver

Target = str | os.PathLike[str] | Problem | tuple[str, Problem]


class Comparison(dict):
    """Columns by name, one entry for each problem, solver and tolerance, as numpy arrays (text as
    lists): `pandas.DataFrame(comparison)` takes it as it is. The columns are those of `rows.csv` of
    `bipot compare`, times in s, errors without unit; what is undefined is nan.
    """

    def __init__(self, native: Any) -> None:
        import numpy as np

        columns = native.columns()
        super().__init__(
            (name, values if values and isinstance(values[0], str) else np.array(values))
            for name, values in columns.items()
        )
        self._native = native

    @property
    def complete(self) -> bool:
        """Whether every row was made."""
        return self._native.complete

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The same as a list of rows."""
        return [dict(zip(self, values)) for values in zip(*self.values())]

    @property
    def details(self) -> dict[str, Any]:
        """All that `comparison.json` of the command holds: problems with their references, counts,
        profiles, growth; keys in data/manual/reference/files.md."""
        return json.loads(self._native.json())

    def report(self, folder: str | os.PathLike[str]) -> None:
        """Writes report.html, comparison.csv, comparison.json and success.csv into the folder, which
        is made where it is missing. Raises OSError, also where gnuplot is not installed."""
        self._native.report(os.fspath(folder))

    def __str__(self) -> str:
        return self._native.text()

    def __repr__(self) -> str:
        return f"<bipot.Comparison: {len(self['problem'])} rows>"


@named_options
def compare(
    targets: Target | Iterable[Target] | Mapping[str, Problem],
    *,
    solvers: Sequence[Solver] | Mapping[str, Solver] = ("auto",),
    tols: Sequence[float] = (1e-2, 1e-4, 1e-6, 1e-8),
    time_limit: float = 2,
    reference_time_limit: float = 5,
    repeat: int = 1,
    min_time: float = 0.02,
    try_all: bool = False,
    warm: bool = False,
    out: str | os.PathLike[str] | None = None,
    scene_problems: int = 3,
    scene_steps: int | None = None,
    on_row: Callable[[dict[str, Any], int, int], Any] | None = None,
) -> Comparison:
    """Every solver on every problem at every tolerance, judged alike.

    targets: problems, pairs (name, problem), or what `bipot compare` takes: files, folders, scenes,
        families such as "pile:18". A problem's first guess is its warm start.
    solvers: names, and callables f(problem, tol, callback) -> s, by __name__ or as {name: callable}.
        callback(s) judges an iterate and returns True when f should stop: the tolerance is met or
        the time is over. It is what makes iterations and histories; without it the answer is a claim
        of convergence. Whatever comes back is projected on the cone and judged like any other: a
        false claim, nan, a wrong size or an exception is a row with the status "numerical failure"
        and a message. A callable that never calls callback cannot be stopped in time.
    tols: > 0. time_limit, reference_time_limit: CPU seconds of one solve, of one attempt at a
        reference. repeat, min_time: solves behind a time, at least; CPU seconds that they take
        together. try_all: also where it was out of time before. warm: each row once more from the
        problem's start. out: folder of the rows, from which a stopped comparison goes on.
        scene_problems, scene_steps: of scenes: problems taken, steps run.
    on_row: called as on_row(row, done, total).

    Warns of what scenes leave out and of overlaps at their start. Raises ValueError for a target or
    solver that does not exist, OSError, KeyboardInterrupt (rows in `out` are kept).
    """
    if isinstance(targets, (str, os.PathLike, Problem)) or _is_pair(targets):
        targets = [targets]
    if isinstance(targets, Mapping):
        targets = list(targets.items())
    if isinstance(solvers, str) or callable(solvers):
        solvers = [solvers]
    given = dict(solvers) if isinstance(solvers, Mapping) else {}
    if not given:
        for solver in solvers:
            name = solver_name(solver)
            if name in given:
                raise ValueError(f"solver '{name}' is named twice")
            given[name] = solver
    for name, solver in given.items():
        if isinstance(solver, str) and solver != name:
            raise ValueError(f"solvers: '{solver}' keeps its own name, '{name}' is for a callable")
        solver_name(solver)
    names = [solver for solver in given.values() if isinstance(solver, str)]
    callables = [(name, solver) for name, solver in given.items() if not isinstance(solver, str)]
    sources = [_source(target, k) for k, target in enumerate(targets)]
    shown = ", ".join(repr(source if isinstance(source, str) else source[0]) for source in sources)
    native = _bipot.compare(
        sources,
        names,
        callables,
        [number(tol, "tols") for tol in tols],
        positive(time_limit, "time_limit"),
        positive(reference_time_limit, "reference_time_limit"),
        count(repeat, "repeat", most=1000),
        not_negative(min_time, "min_time"),
        flag(try_all, "try_all"),
        flag(warm, "warm"),
        os.fspath(out) if out is not None else "",
        count(scene_problems, "scene_problems", most=1000),
        optional(count, scene_steps, "scene_steps"),
        on_row,
        f"bipot.compare([{shown}], solvers={list(given)}, tols={list(tols)})",
    )
    return Comparison(native)


@named_options
def problems(
    *targets: str, scene_problems: int = 3, scene_steps: int | None = None
) -> list[Problem]:
    """The problems of what `compare` takes as text: files, folders, scenes, families ("pile:18").
    Warns as `compare`."""
    return _bipot.problems(
        [text(target, "target") for target in targets],
        count(scene_problems, "scene_problems", most=1000),
        optional(count, scene_steps, "scene_steps"),
    )


def _is_pair(target: Any) -> bool:
    return isinstance(target, tuple) and len(target) == 2 and isinstance(target[1], Problem)


def _source(target: Any, place: int) -> Any:
    """A target as the native part takes it: text, or (name, problem, start)."""
    if isinstance(target, (str, os.PathLike)):
        return os.fspath(target)
    if isinstance(target, Problem):
        target = (target.name or f"problem_{place}", target)
    if not _is_pair(target):
        raise TypeError(f"target {target!r}: expected a text, a Problem or (name, Problem)")
    name, problem = target
    return name, problem, problem.guesses[0] if problem.guesses else None
