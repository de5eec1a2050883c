"""Every example, as a person runs it, in its quick form."""

import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).parents[3] / "bench" / "python" / "examples"
MADE = {
    "error_against_steps.py": ["error_against_steps.svg"],
    "own_solver.py": ["work_precision.svg"],
    "moving_wall.py": ["moving_wall.svg"],
    "delassus_spectrum.py": ["spectrum.svg"],
    "friction_sweep.py": ["base_load.svg"],
    "submit_solver.py": ["index.html"],
}


def test_every_example_is_run():
    assert {path.name for path in EXAMPLES.glob("*.py")} == set(MADE)


@pytest.mark.parametrize("name", MADE)
def test_an_example_runs_and_draws(name, tmp_path):
    run = subprocess.run(
        [sys.executable, str(EXAMPLES / name), "--quick", "--out", str(tmp_path)],
        capture_output=True, text=True, timeout=240,
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip()
    for picture in MADE[name]:
        assert (tmp_path / picture).stat().st_size > 5000
