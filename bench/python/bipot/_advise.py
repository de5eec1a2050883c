"""Which solver, tolerance and time step a scene needs."""

from __future__ import annotations

import json
import os
from typing import Any, Sequence

from . import _bipot
from ._display import table
from ._names import count, flag, named_options, positive


class Advice(dict):
    """What `bipot advise --json` says (keys: data/manual/reference/files.md), and in short:

    status: "met", "not met", "undecided" (out of time), "no contacts". message: one sentence.
    solver, tol, warm_start, step [s]: what to take; None where there is nothing to recommend.
    """

    status: str = property(lambda self: self["status"])
    message: str = property(lambda self: self["message"])
    solver: str | None = property(lambda self: self._chosen("solver"))
    tol: float | None = property(lambda self: self._chosen("tol"))
    warm_start: bool | None = property(lambda self: self._chosen("warm_start"))
    step: float | None = property(lambda self: self._chosen("step"))

    def _chosen(self, key: str) -> Any:
        return self["advice"][key] if self["advice"] else None

    def __repr__(self) -> str:
        return f"<bipot.Advice {self.status}: {self.message}>"

    def _repr_html_(self) -> str:
        return table(
            "bipot.Advice",
            [
                ("status", self.status),
                ("why", self.message),
                ("solver", self.solver),
                ("tolerance", self.tol),
                ("warm start", self.warm_start),
                ("time step", self.step and f"{self.step:g} s"),
            ],
        )


@named_options
def advise(
    scene: str | os.PathLike[str],
    *,
    force_error: float | None = None,
    penetration: float | None = None,
    energy: float | None = None,
    load: float | None = None,
    coordination: float | None = None,
    stress_ratio: float | None = None,
    solvers: Sequence[str] = (),
    time_limit: float = 60,
    window: float | None = None,
    samples: int = 6,
    keep_step: bool = False,
) -> Advice:
    """Tries solvers, tolerances and time steps on stretches of the scene and says what to take.

    Goals, means over stretches: force_error of a body's contact force, over the largest one;
    penetration, the largest overlap over the smaller radius; relative errors of the dissipated
    energy, the load on a wall, the coordination, and stress_ratio, τ/P. None: 5 % in overlaps and in
    those means that the scene has. time_limit: wall seconds of the trials; window: length of a stretch in s;
    samples: number of stretches, more narrow the error bars; keep_step: the scene's own.

    Warns of what the scene leaves out and of overlaps at its start. Raises FileNotFoundError,
    ValueError for a scene or a goal that is refused, KeyboardInterrupt.
    """

    goals = {
        "force": force_error,
        "penetration": penetration,
        "energy": energy,
        "load": load,
        "coordination": coordination,
        "stress_ratio": stress_ratio,
    }
    text = _bipot.advise(
        os.fspath(scene),
        goal={
            key: positive(x, "force_error" if key == "force" else key)
            for key, x in goals.items()
            if x is not None
        },
        solvers=[solvers] if isinstance(solvers, str) else list(solvers),
        time_limit=positive(time_limit, "time_limit"),
        window=0 if window is None else positive(window, "window"),
        samples=count(samples, "samples", most=64),
        keep_step=flag(keep_step, "keep_step"),
    )
    return Advice(json.loads(text))
