"""A scene, step by step."""

from __future__ import annotations

import os
from typing import Any, Iterator

from . import _bipot
from ._bipot import SphereState, SphereStep, State, Step
from ._names import parameter_texts, refuse_unknown
from ._solve import Solver

_OPTIONS = [
    "solver",
    "tol",
    "max_iterations",
    "warm_start",
    "step",
    "num_steps",
    "friction",
]


class Simulation:
    """A scene file (TOML), or a shipped scene by name, that is taken step by step.

        sim = bipot.Simulation("scene.toml")
        for step in sim:
            print(step.time, step.positions[:, 1].max())

    Iterating goes on to the number of steps that the scene plans; `advance()` takes one step more.
    Each `Step` is a snapshot: its arrays are read-only views into it (problem, positions,
    velocities, angles, spins, radii, masses), its contacts and walls are copies. A scene in 3D
    has `SphereStep`s: positions, velocities and spins have three columns, `orientations` (unit
    quaternions w, x, y, z) stand for the angles, contacts have n_z and vectors s_tx to s_tz, u_tx
    to u_tz.

    solver: a name, or a callable f(problem, tol, callback) -> s (see `compare`); the scene's own
        where it is None, as are tol, max_iterations, warm_start (from the step before), step [s],
        num_steps and friction (of all pairs). Other options are the solver's parameters. A scene of
        springs and dashpots (model dem) gets rigid contacts where a solver is named.

    For one thread at a time. Raises ValueError for a scene or an option that is refused, TypeError
    for one that does not exist.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str],
        *,
        solver: Solver | None = None,
        tol: float | None = None,
        max_iterations: int | None = None,
        warm_start: bool | None = None,
        step: float | None = None,
        num_steps: int | None = None,
        friction: float | None = None,
        **parameters: float | int | str,
    ) -> None:
        refuse_unknown(parameters, [*_OPTIONS, *_bipot.parameter_names("")])
        self._native = _bipot.make_simulation(
            os.fspath(scene),
            solver,
            tol,
            max_iterations,
            warm_start,
            parameter_texts(parameters),
            step,
            num_steps,
            friction,
        )

    def __iter__(self) -> Iterator[Step | SphereStep]:
        while self.steps_done < self.num_steps:
            yield self.advance()

    def advance(self) -> Step | SphereStep:
        """Takes one step. A step whose solve did not converge is taken and says so (`converged`,
        `message`). Raises StepError, leaving everything at the end of the step before, where the
        solver failed, and KeyboardInterrupt likewise."""
        return self._native.advance()

    def set_wall(
        self, wall: str | int, *, velocity: Any = None, force: float | None = None
    ) -> None:
        """From the next step on: velocity (x, y), in space (x, y, z) [m/s], of a wall that the scene moves by a
        `velocity`, force [N] along the direction of one that it drives by a `force`.

        The wall keeps it until it is set again. Raises ValueError for a wall that does not exist or
        moves otherwise.
        """
        self._native.set_wall(wall, velocity, force)

    @property
    def state(self) -> State | SphereState:
        """Where everything is now: a copy, with positions, velocities, angles (in space
        orientations), spins, radii, masses, contacts (of the last step) and walls."""
        return self._native.state

    @property
    def walls(self) -> list[dict[str, Any]]:
        """name, shape, motion ("fixed", "moving", "driven"), a, b, normal (of cylinders the axis),
        radius, velocity, force of each; copies."""
        return self._native.walls

    @property
    def title(self) -> str:
        """The scene's."""
        return self._native.title

    @property
    def time(self) -> float:
        """[s]"""
        return self._native.time

    @property
    def steps_done(self) -> int:
        """Since the scene's beginning."""
        return self._native.steps_done

    @property
    def num_steps(self) -> int:
        """That the scene plans."""
        return self._native.num_steps

    @property
    def step_size(self) -> float:
        """h [s]"""
        return self._native.step_size
