"""The folder of a run: its states and tables."""

from __future__ import annotations

import csv
import json
import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, overload

from . import _bipot
from ._bipot import SphereState, State
from ._display import table
from ._names import integer, text

if TYPE_CHECKING:
    import numpy.typing as npt


def _column(cells: tuple[str, ...]) -> npt.NDArray[Any]:
    import numpy as np

    try:
        return np.array([float(cell) for cell in cells])
    except ValueError:
        return np.array(cells)


class Run(Sequence[Any]):
    """The folder that `bipot run` wrote, named by itself or by its run.h5: a sequence of the states
    of its frames, each read when it is asked for.

        run = bipot.Run("out/drum")
        print(run[-1].positions, run.summary["status"])
        ledger = run.table("ledger")
        axes.plot(ledger["time"], ledger["kinetic"])

    `State`s, in space `SphereState`s, are as those of a simulation. A run may go on meanwhile: its
    new frames join. Raises OSError for a folder that is no run or a file that cannot be read.
    """

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        path = pathlib.Path(os.fspath(folder))
        self.folder: pathlib.Path = path.parent if path.name == "run.h5" else path
        if not (self.folder / "run.h5").is_file():
            raise FileNotFoundError(f"{path}: not the folder of a run, nor the run.h5 in it")

    @property
    def steps(self) -> list[int]:
        """Of the frames, increasing."""
        return _bipot.run_steps(self.folder)

    @property
    def summary(self) -> dict[str, Any]:
        """summary.json, which a run writes at its end."""
        return json.loads((self.folder / "summary.json").read_text(encoding="utf-8"))

    @property
    def tables(self) -> list[str]:
        """Names for `table`."""
        return sorted(path.stem for path in self.folder.glob("*.csv"))

    def table(self, name: str) -> dict[str, npt.NDArray[Any]]:
        """The columns of a CSV file of the folder, e.g. "ledger": arrays of numbers, or of texts.
        `table("units")` has their units. Raises ValueError for a table that the run has not."""
        if text(name, "name") not in self.tables:
            raise ValueError(_bipot.unknown_name_message("table", name, self.tables))
        content = (self.folder / f"{name}.csv").read_text(encoding="utf-8")
        lines = content.splitlines(keepends=True)
        whole = lines if content.endswith("\n") else lines[:-1]  # a run may be writing the last one
        names, *rows = csv.reader(whole)
        columns = zip(*rows) if rows else [()] * len(names)
        return {key: _column(cells) for key, cells in zip(names, columns)}

    def at(self, step: int) -> State | SphereState:
        """The state after a step. Raises OSError where there is no frame of it."""
        step = integer(step, "step")
        if step < 0:
            raise ValueError(f"step = {step} is negative")
        return _bipot.read_run_state(self.folder, step)

    def __fspath__(self) -> str:
        return str(self.folder)

    def __len__(self) -> int:
        return len(self.steps)

    @overload
    def __getitem__(self, index: int) -> State | SphereState: ...
    @overload
    def __getitem__(self, index: slice) -> list[State | SphereState]: ...
    def __getitem__(self, index: Any) -> Any:
        chosen = self.steps[index]
        return [self.at(step) for step in chosen] if isinstance(index, slice) else self.at(chosen)

    def __repr__(self) -> str:
        return f"<bipot.Run {self.folder}: {len(self)} frames>"

    def _repr_html_(self) -> str:
        rows = [("folder", self.folder), ("frames", len(self)), ("tables", ", ".join(self.tables))]
        return table("bipot.Run", rows)
