"""A scene, step by step."""

from __future__ import annotations

import os
import pathlib
import tempfile
import warnings
from typing import Any, Iterator, Mapping

from . import _bipot
from ._bipot import SphereState, SphereStep, State, Step
from ._display import table
from ._names import flag, integer, number, optional, parameter_texts, refuse_unknown, text, wrong_type
from ._solve import Solver
from ._toml import to_toml

_OPTIONS = [
    "solver",
    "tol",
    "max_iterations",
    "warm_start",
    "step",
    "num_steps",
    "friction",
    "accuracy",
    "restart",
]


def _path(value: Any, name: str) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise wrong_type(name, "a path", value)
    return os.fspath(value)


class _SceneText(str):
    """The text of a scene in the place of its name."""


def _restored(
    cls: type, options: dict[str, Any], source: str, text: str, files: dict[str, bytes]
) -> Simulation:
    """The simulation of `Simulation.__reduce__`."""
    made = cls.__new__(cls)
    made._options = options
    made._make(source, text)
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files.items():
            path = pathlib.Path(folder, name)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(content)
        made._native.load(folder)
    return made


class Simulation:
    """A scene that is taken step by step: a scene file (TOML), a shipped scene by name, or a
    dictionary with the keys of a scene file. `Simulation.from_text` takes the text of a file.

        sim = bipot.Simulation("scene.toml")
        for step in sim:
            print(step.time, step.positions[:, 1].max())

    A simulation is its own iterator, so that `next(sim)` takes a step. Iterating goes on to the
    number of steps that the scene plans; `advance()` takes one step more.
    Each `Step` is a snapshot: its arrays are read-only views into it (problem, positions,
    velocities, angles, spins, radii, masses), its contacts and walls are copies. A scene in 3D
    has `SphereStep`s: positions, velocities and spins have three columns, `orientations` (unit
    quaternions w, x, y, z) stand for the angles, contacts have n_z and vectors s_tx to s_tz, u_tx
    to u_tz.

    solver: a name, or a callable f(problem, tol, callback) -> s (see `compare`); the scene's own
        where it is None, as are tol, max_iterations, warm_start (from the step before), step [s]
        (a duration stays), num_steps, friction (of all pairs) and accuracy. Other options are the
        solver's parameters.
    restart: the folder of a run of this scene, or a `Run`: the simulation goes on from its last
        frame, to the same number of steps.
        A scene of springs and dashpots (model dem) gets rigid contacts where a solver is named.

    copy.deepcopy and pickle keep the state bit for bit, with walls as Python set them.

    For one thread at a time. Raises FileNotFoundError, ValueError for a scene or an option that is
    refused, TypeError for one that does not exist.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str] | Mapping[str, Any],
        *,
        solver: Solver | None = None,
        tol: float | None = None,
        max_iterations: int | None = None,
        warm_start: bool | None = None,
        step: float | None = None,
        num_steps: int | None = None,
        friction: float | None = None,
        accuracy: float | None = None,
        restart: str | os.PathLike[str] | None = None,
        **parameters: float | int | str,
    ) -> None:
        refuse_unknown(parameters, [*_OPTIONS, *_bipot.parameter_names("")])
        self._options = dict(
            solver=solver,
            tol=optional(number, tol, "tol"),
            max_iterations=optional(integer, max_iterations, "max_iterations"),
            warm_start=optional(flag, warm_start, "warm_start"),
            parameters=parameter_texts(parameters),
            step=optional(number, step, "step"),
            num_steps=optional(integer, num_steps, "num_steps"),
            friction=optional(number, friction, "friction"),
            accuracy=optional(number, accuracy, "accuracy"),
            restart=optional(_path, restart, "restart"),
        )
        if isinstance(scene, Mapping):
            scene = _SceneText(to_toml(scene))
        if isinstance(scene, _SceneText):
            self._make("scene", str(scene))
        else:
            path = os.fspath(scene)
            if "\n" in path:
                raise ValueError(
                    "scene: this is the text of a scene; give it to Simulation.from_text"
                )
            self._make(path, None)
        if self._native.caution:  # copies are made without
            warnings.warn(self._native.caution, stacklevel=2)

    def _make(self, source: str, text: str | None) -> None:
        self._native = _bipot.make_simulation(source, text, **self._options)
        self._options["restart"] = None  # copies have the state

    @classmethod
    def from_text(cls, toml: str, **options: Any) -> Simulation:
        """The simulation of a scene that is given as text (TOML); options as above."""
        return cls(_SceneText(text(toml, "toml")), **options)

    def __reduce__(self) -> tuple[Any, ...]:
        with tempfile.TemporaryDirectory() as folder:
            self._native.save(folder)
            files = {
                str(path.relative_to(folder)): path.read_bytes()
                for path in pathlib.Path(folder).rglob("*.h5")
            }
        options = self._options | {"num_steps": self.num_steps}  # copies know of no restart
        return _restored, (type(self), options, self._native.source, self._native.text, files)

    def __repr__(self) -> str:
        return (
            f"<bipot.Simulation {self.title or self._native.source}: step {self.steps_done} of "
            f"{self.num_steps}, t = {self.time:g} s, {len(self.state.radii)} bodies>"
        )

    def _repr_html_(self) -> str:
        return table(
            f"bipot.Simulation {self.title}",
            [
                ("scene", self._native.source),
                ("steps", f"{self.steps_done} of {self.num_steps}, each {self.step_size:g} s"),
                ("t", f"{self.time:g} s"),
                ("bodies", len(self.state.radii)),
                ("walls", len(self.walls)),
            ],
        )

    def __iter__(self) -> Iterator[Step | SphereStep]:
        return self

    def __next__(self) -> Step | SphereStep:
        if self.steps_done >= self.num_steps:
            raise StopIteration
        return self.advance()

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

        The wall keeps it until it is set again. Raises ValueError for a wall that does not exist,
        moves otherwise, or follows a schedule of the scene.
        """
        which = wall if isinstance(wall, str) else integer(wall, "wall")
        self._native.set_wall(which, velocity, force)

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
