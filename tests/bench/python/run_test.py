"""The folder of a run, read again."""

import copy
import os
import subprocess

import numpy as np
import pytest

import bipot
from conftest import DATA, refused


@pytest.fixture(params=["bouncing_ball", "four_spheres"])
def folder(request, tmp_path):
    text = (DATA / "scenes" / f"{request.param}.toml").read_text()
    scene, out = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text(text.split("[output]")[0] + "\n[output]\nevery = 2\n")
    command = [os.environ["BIPOT_COMMAND"], "run", scene, "--steps", "6", "--no-page", "--out", out]
    subprocess.run(command, check=True, capture_output=True)
    return scene, out


def test_the_states_are_those_of_the_simulation(folder):
    scene, out = folder
    run = bipot.Run(out)
    assert run.steps == [0, 2, 4, 6] and len(run) == 4
    taken = {step.step: step for step in bipot.Simulation(scene, num_steps=6)}
    arrays = ["positions", "velocities", "spins", "radii", "masses"]
    arrays.append("angles" if run[0].positions.shape[1] == 2 else "orientations")
    for state in run[1:]:
        step = taken[state.step]
        assert isinstance(step, type(state)) and state.time == step.time
        for name in arrays:
            assert np.array_equal(getattr(state, name), getattr(step, name)), name
            assert not getattr(state, name).flags.writeable, name
        assert np.array_equal(state.contacts, step.contacts)
        assert state.walls == step.walls
    assert run[-1].step == 6 and run.at(2).step == 2
    assert [state.step for state in run] == run.steps
    assert bipot.Run(out / "run.h5").steps == run.steps


def test_a_simulation_goes_on_from_a_run(folder):
    scene, out = folder
    whole = list(bipot.Simulation(scene, num_steps=9))
    for run in [out, out / "run.h5", bipot.Run(out)]:
        sim = bipot.Simulation(scene, num_steps=9, restart=run)
        assert sim.steps_done == 6
        copied = copy.deepcopy(sim)
        for going_on in [sim, copied]:
            steps = list(going_on)
            assert [step.step for step in steps] == [7, 8, 9]
            assert np.array_equal(steps[-1].positions, whole[-1].positions)
            assert np.array_equal(steps[-1].contacts, whole[-1].contacts)


def test_a_restart_with_another_step_ends_at_the_same_time(folder):
    scene, out = folder
    plain = bipot.Simulation(scene, restart=out)
    finer = bipot.Simulation(scene, restart=out, step=plain.step_size / 2)
    by_duration = "duration" in scene.read_text()
    left = plain.num_steps - plain.steps_done
    assert finer.num_steps - finer.steps_done == (2 * left if by_duration else left)
    assert copy.deepcopy(finer).num_steps == finer.num_steps


def test_a_run_of_another_scene_is_refused(folder, tmp_path):
    told = "does not fit the scene: it has 1 disks|a run in 3 dimensions"
    refused((ValueError, OSError), told, bipot.Simulation, "drum", restart=folder[1])
    refused(OSError, "a run is named by its folder", bipot.Simulation, "drum", restart=folder[0])
    with pytest.raises(OSError, match="none: no such folder or file"):
        bipot.Simulation("drum", restart=tmp_path / "none")
    refused(TypeError, "restart", bipot.Simulation, "drum", restart=3)


def test_an_array_outlives_its_run(folder):
    positions = bipot.Run(folder[1])[0].positions
    assert np.isfinite(positions).all() and not positions.flags.writeable


def test_tables_and_summary(folder):
    run = bipot.Run(folder[1])
    assert run.summary["status"] == "completed" and run.summary["steps"] == 6
    ledger = run.table("ledger")
    assert list(ledger["step"]) == [1, 2, 3, 4, 5, 6]
    assert ledger["time"][-1] == pytest.approx(run[-1].time, rel=1e-8)
    state = run[-1]
    kinetic = 0.5 * (state.masses[:, None] * state.velocities**2).sum()
    assert ledger["kinetic"][-1] >= 0.999 * kinetic > 0  # spins add to it
    units = run.table("units")
    assert {"ledger", "units"} <= set(run.tables)
    row = list(zip(units["file"], units["column"])).index(("ledger.csv", "kinetic"))
    assert units["unit"][row] == "J"


def test_a_row_that_is_being_written_does_not_count(folder):
    run = bipot.Run(folder[1])
    ledger = folder[1] / "ledger.csv"
    ledger.write_text(ledger.read_text()[:-3])
    assert list(run.table("ledger")["step"]) == [1, 2, 3, 4, 5]
    ledger.write_text(ledger.read_text().splitlines(keepends=True)[0])
    assert list(run.table("ledger")["step"]) == []


def test_what_is_refused(folder, tmp_path):
    out = folder[1]
    run = bipot.Run(out)
    refused(FileNotFoundError, "not the folder of a run", bipot.Run, tmp_path)
    refused(ValueError, "unknown table 'leger'.*ledger", run.table, "leger")
    refused(OSError, "no frame of step 3", run.at, 3)
    refused(ValueError, "negative", run.at, -1)
    with pytest.raises(IndexError):
        run[4]
    (out / "summary.json").unlink()
    with pytest.raises(FileNotFoundError):
        run.summary


def test_a_run_says_what_it_is(folder):
    run = bipot.Run(folder[1])
    assert repr(run) == f"<bipot.Run {folder[1]}: 4 frames>"
    assert "ledger" in run._repr_html_()


def test_bodies_keep_their_numbers_through_gates(tmp_path):
    out = tmp_path / "out"
    command = [os.environ["BIPOT_COMMAND"], "run", "hopper", "--steps", "400", "--no-page", "--out"]
    subprocess.run([*command, out], check=True, capture_output=True)
    first, last = bipot.Run(out)[0], bipot.Run(out)[-1]
    count = len(first.positions)
    assert np.array_equal(first.numbers, np.arange(count))
    stayed = last.numbers < count
    assert stayed.sum() < count and not stayed.all()
    assert np.array_equal(last.radii[stayed], first.radii[last.numbers[stayed]])
    assert not last.numbers.flags.writeable
