"""Types of the native part; `bipot` names what of it is public. Classes with _ are parts of others."""

import os
from typing import Any, Callable, Final

import numpy as np
import numpy.typing as npt
import scipy.sparse as sparse

Array = npt.NDArray[np.float64]

__version__: str

class StepError(RuntimeError): ...

class Problem:
    def __init__(
        self,
        *,
        A: Any = None,
        H: Any = None,
        W: Any = None,
        R: Any = None,
        G: Any = None,
        b: Any = None,
        v_free: Any = None,
        u_free: Any = None,
        mu: Any = None,
        mu_r: Any = None,
        mu_spin: Any = None,
        dim: int | None = None,
        M: Any = None,
        J: Any = None,
        restitution: Any = None,
        e: Any = None,
        v_before: Any = None,
        u_before: Any = None,
        row_scale: Any = None,
        name: str = "",
        accept_indefinite: bool = False,
    ) -> None: ...
    def update(
        self,
        *,
        u_free: Any = None,
        v_free: Any = None,
        mu: Any = None,
        b: Any = None,
        v_before: Any = None,
        u_before: Any = None,
    ) -> Problem: ...
    dim: Final[int]
    num_contacts: Final[int]
    num_rows: Final[int]
    num_dofs: Final[int]
    name: Final[str]
    A: Final[sparse.csc_matrix | None]
    H: Final[sparse.csc_matrix | None]
    W: Final[sparse.csr_matrix | None]
    G: Final[sparse.csr_matrix | None]
    b: Final[Array | None]
    v_free: Final[Array | None]
    u_free: Final[Array]
    mu: Final[Array]
    mu_r: Final[Array | None]
    mu_spin: Final[Array | None]
    row_scale: Final[Array | None]
    solution: Final[Array | None]
    guesses: Final[list[Array]]
    def delassus(self) -> sparse.csr_matrix: ...
    def velocity(self, s: Any) -> Array: ...
    def body_velocity(self, s: Any) -> Array: ...

class _StepErrors:
    epsilon: Final[float]
    eta: Final[float]
    guarded: Final[float]
    raw42: Final[float]

class _Errors(_StepErrors):
    natural_map: Final[float]

class _Counts:
    take_off: Final[int]
    stick: Final[int]
    slip: Final[int]

class Iteration(_Errors, _Counts):
    iteration: Final[int]
    seconds: Final[float]
    step: Final[float]

class Result(_Errors, _Counts):
    def __bool__(self) -> bool: ...
    solver: Final[str]
    tol: Final[float]
    s: Final[Array]
    u: Final[Array]
    impulse: Final[Array]
    v: Final[Array | None]
    multipliers: Final[Array | None]
    equality_residual: Final[float]
    status: Final[str]
    converged: Final[bool]
    message: Final[str]
    iterations: Final[int]
    setup_seconds: Final[float]
    solve_seconds: Final[float]
    worst_contact: Final[int | None]
    history: Final[npt.NDArray[np.void]]
    def plot(self, axes: Any = None) -> Any: ...

class JudgedContact:
    contact: Final[int]
    mu: Final[float]
    s: Final[Array]
    u: Final[Array]
    share: Final[float]
    faults: Final[list[dict[str, Any]]]

class Verdict(_Errors, _Counts):
    siconos_map: Final[float]
    cone: Final[float]
    cone_violation: Final[float]
    cone_contact: Final[int | None]
    penetration_velocity: Final[float]
    penetration_contact: Final[int | None]
    worst: Final[list[JudgedContact]]
    worst_contact: Final[int | None]
    s: Final[Array]
    u: Final[Array]
    def within(self, tol: float) -> bool: ...
    def sentence(self, tol: float) -> str: ...

class _State:
    def plot(self, axes: Any = None) -> Any: ...
    step: Final[int]
    time: Final[float]
    positions: Final[Array]
    velocities: Final[Array]
    spins: Final[Array]
    radii: Final[Array]
    masses: Final[Array]
    numbers: Final[npt.NDArray[np.int64]]
    contacts: Final[npt.NDArray[np.void]]
    walls: Final[list[dict[str, Any]]]

class State(_State):
    angles: Final[Array]

class _Step(_StepErrors):
    problem: Final[Problem]
    converged: Final[bool]
    message: Final[str]
    iterations: Final[int]
    penetration: Final[float]
    parts: Final[int]
    solve_seconds: Final[float]
    energy: Final[dict[str, float]]

class Step(State, _Step): ...

class SphereState(_State):
    orientations: Final[Array]

class SphereStep(SphereState, _Step): ...

class Comparison:
    complete: Final[bool]
    def columns(self) -> dict[str, list[Any]]: ...
    def text(self) -> str: ...
    def json(self) -> str: ...
    def report(self, folder: str) -> None: ...

class _Simulation:
    def set_wall(self, wall: str | int, velocity: Any, force: float | None) -> None: ...
    def save(self, folder: str | os.PathLike[str]) -> None: ...
    def load(self, folder: str | os.PathLike[str]) -> None: ...
    text: Final[str]
    source: Final[str]
    title: Final[str]
    caution: Final[str]
    time: Final[float]
    steps_done: Final[int]
    num_steps: Final[int]
    step_size: Final[float]
    walls: Final[list[dict[str, Any]]]

class Simulation(_Simulation):
    def advance(self) -> Step: ...
    state: Final[State]

class SphereSimulation(_Simulation):
    def advance(self) -> SphereStep: ...
    state: Final[SphereState]

def make_simulation(
    scene: str,
    text: str | None,
    solver: Any,
    tol: float | None,
    max_iterations: int | None,
    warm_start: bool | None,
    parameters: dict[str, str],
    step: float | None,
    num_steps: int | None,
    friction: float | None,
    accuracy: float | None,
    restart: str | None,
) -> Simulation | SphereSimulation: ...
def unknown_name_message(kind: str, name: str, candidates: list[str]) -> str: ...
def name_of_callable(callable: Any) -> str: ...
def parameter_names(solver: str) -> list[str]: ...
def run_steps(run: str | os.PathLike[str]) -> list[int]: ...
def read_run_state(run: str | os.PathLike[str], step: int) -> State | SphereState: ...
def read(path: str | os.PathLike[str], accept_indefinite: bool) -> Problem: ...
def write(
    problem: Problem,
    path: str | os.PathLike[str],
    s: Any,
    title: str,
    description: str,
    guesses: list[Any],
) -> None: ...
def solve(
    problem: Problem,
    solver: Any,
    tol: float,
    s0: Any,
    time_limit: float,
    stop: str,
    max_iterations: int,
    parameters: dict[str, str],
    callback: Callable[[Iteration], bool | None] | None,
) -> Result: ...
def solve_all(
    problems: list[Problem],
    solver: Any,
    tol: float,
    s0: list[Any],
    time_limit: float,
    stop: str,
    max_iterations: int,
    parameters: dict[str, str],
    threads: int,
) -> list[Result]: ...
def solvers() -> list[dict[str, Any]]: ...
def judge(problem: Problem, s: Any, worst: int) -> Verdict: ...
def compare(
    targets: list[Any],
    solvers: list[str],
    callables: list[tuple[str, Any]],
    tols: list[float],
    time_limit: float,
    reference_time_limit: float,
    repeat: int,
    min_time: float,
    try_all: bool,
    warm: bool,
    out: str,
    scene_problems: int,
    scene_steps: int | None,
    on_row: Callable[[dict[str, Any], int, int], Any] | None,
    command: str,
) -> Comparison: ...
def problems(
    targets: list[str], scene_problems: int, scene_steps: int | None
) -> list[Problem]: ...
def advise(
    scene: str,
    goal: dict[str, float],
    solvers: list[str],
    time_limit: float,
    window: float,
    samples: int,
    keep_step: bool,
) -> str: ...
