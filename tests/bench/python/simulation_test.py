"""Scenes step by step, and advice."""

import numpy as np
import pytest

import bipot
from conftest import DATA, gauss_seidel, refused


def test_a_scene_is_taken_step_by_step():
    sim = bipot.Simulation("square_lattice")
    assert sim.num_steps == 10 and sim.steps_done == 0 and sim.time == 0
    steps = list(sim)
    assert [s.step for s in steps] == list(range(1, 11))
    assert sim.steps_done == 10 and sim.time == steps[-1].time == pytest.approx(10 * sim.step_size)
    last = steps[-1]
    assert last.converged and last.guarded <= 1e-8 and "converged" in repr(last)
    n = len(last.radii)
    assert last.positions.shape == last.velocities.shape == (n, 2)
    assert last.angles.shape == last.spins.shape == last.masses.shape == (n,)
    assert len(last.contacts) == last.problem.num_contacts
    assert list(sim) == []
    assert sim.advance().step == 11  # further than the scene plans


def test_a_simulation_is_its_iterator():
    sim = bipot.Simulation("square_lattice", num_steps=3)
    assert iter(sim) is sim
    assert [next(sim).step, next(sim).step] == [1, 2]
    assert [s.step for s in sim] == [3]
    with pytest.raises(StopIteration):
        next(sim)


def test_a_start_that_overlaps_is_refused(tmp_path):
    scene = tmp_path / "two.toml"
    disk = "[[disks]]\nposition = [{}, 0]\nradius = 1\nmass = 1\n"
    text = "time = {{ step = 1e-3, steps = 1 }}\nstart = {{ overlaps = '{}' }}\n" + disk.format(0) + disk.format(1.5)
    scene.write_text(text.format("refuse"))
    with pytest.raises(ValueError, match="2 disks overlap at the start, worst disk 0 and disk 1: 500 mm, 0.5 radii"):
        bipot.Simulation(scene)
    scene.write_text(text.format("push apart"))
    positions = bipot.Simulation(scene).advance().positions
    assert positions[1, 0] - positions[0, 0] == pytest.approx(2, abs=1e-5)


SLIDE = """
title = "a slide"
contact = {mu = 0.2}
disks = [{position = [0, 0.5], radius = 0.5, mass = 2, velocity = [3, 0]}]
walls = [{name = "floor \\"1\\"", point = [0, 0], normal = [0, 1]}]
time = {step = 0.01, steps = 5}
"""


def test_a_scene_may_be_a_text_or_a_dictionary(tmp_path):
    """After 0.05 s of sliding the disk is slower by mu g t."""
    (tmp_path / "slide.toml").write_text(SLIDE)
    as_dict = {
        "title": "a slide",
        "contact": {"mu": 0.2},
        "disks": [dict(position=np.array([0, 0.5]), radius=0.5, mass=2, velocity=(3, 0))],
        "walls": [dict(name='floor "1"', point=[0, 0], normal=[np.int64(0), 1])],
        "time": {"step": 0.01, "steps": 5},
    }
    sims = [
        bipot.Simulation(tmp_path / "slide.toml", tol=1e-10),
        bipot.Simulation.from_text(SLIDE, tol=1e-10),
        bipot.Simulation(as_dict, tol=1e-10),
    ]
    speeds = [[step.velocities[0, 0] for step in sim][-1] for sim in sims]
    assert speeds[0] == speeds[1] == speeds[2] == pytest.approx(3 - 0.2 * 9.81 * 0.05)
    assert [sim.walls[0]["name"] for sim in sims] == ['floor "1"'] * 3
    assert [sim.title for sim in sims] == ["a slide"] * 3
    with pytest.raises(ValueError, match="scene.*frictoin"):
        bipot.Simulation({**as_dict, "contact": {"frictoin": 1}})
    with pytest.raises(ValueError, match="scene:2: .*frictoin"):
        bipot.Simulation.from_text("[contact]\nfrictoin = 1")
    refused(ValueError, "give it to Simulation.from_text", bipot.Simulation, SLIDE)
    with pytest.raises(TypeError, match="contact.mu: expected a number, .*got object"):
        bipot.Simulation({**as_dict, "contact": {"mu": object()}})
    refused(TypeError, "did you mean 'step'", bipot.Simulation.from_text, SLIDE, dt=0.1)


def test_arrays_of_a_step_are_views_of_a_snapshot():
    sim = bipot.Simulation("bouncing_ball")
    first = sim.advance()
    positions, kept = first.positions, first.positions.copy()
    assert positions.base is first and not positions.flags.writeable
    for _ in range(5):
        sim.advance()
    assert np.array_equal(positions, kept)
    assert not np.array_equal(sim.state.positions, kept)
    del first
    assert np.array_equal(positions, kept)


def test_contacts_and_problem_tell_the_same_story():
    """Without restitution the impulses of the step are those of its problem, and they hold it."""
    sim = bipot.Simulation("triangular_lattice", tol=1e-10)
    step = sim.advance()
    c = step.contacts
    r = bipot.solve(step.problem, tol=1e-10)
    assert bipot.judge(step.problem, np.column_stack([c["s_n"], c["s_t"]]).ravel()).within(1e-9)
    n = len(step.radii)
    floor = c[c["j"] >= n]
    up = (floor["s_n"] * floor["n_y"] + floor["s_t"] * floor["n_x"]).sum()
    momentum = (step.masses * step.velocities[:, 1]).sum()
    weight = -step.energy["imbalance"]  # round-off
    assert abs(weight) < 1e-9
    assert r.converged and up > 0 and np.isfinite(momentum)
    assert set(np.unique(c["status"])) <= {0, 1, 2}


def test_choices_replace_the_scenes():
    base = bipot.Simulation("triangular_lattice").advance()
    other = bipot.Simulation("triangular_lattice", solver="pgs", tol=1e-3, omega=1.2).advance()
    assert other.guarded <= 1e-3 and other.iterations != base.iterations
    assert bipot.Simulation("triangular_lattice", num_steps=3).num_steps == 3
    assert bipot.Simulation("triangular_lattice", step=1e-5).advance().time == 1e-5
    slippery = bipot.Simulation("triangular_lattice", friction=0)
    assert slippery.advance().problem.dim == 1
    short = bipot.Simulation("triangular_lattice", solver="pgs", max_iterations=2).advance()
    assert not short.converged and "iteration limit" in short.message


def test_a_python_solver_drives_a_scene():
    ours = bipot.Simulation("sliding_cylinder", solver=gauss_seidel, tol=1e-10, num_steps=20)
    theirs = bipot.Simulation("sliding_cylinder", solver="ipm", tol=1e-10, num_steps=20)
    for a, b in zip(ours, theirs):
        assert a.converged, a.message
        assert np.allclose(a.velocities, b.velocities, atol=1e-7)

    def fails(problem, tol, callback):
        raise RuntimeError("out of ideas")

    sim = bipot.Simulation("sliding_cylinder", solver=fails)
    refused(bipot.StepError, "step 1 at t = 0 s.*out of ideas", sim.advance)
    assert sim.steps_done == 0
    with pytest.raises(RuntimeError):  # StepError is one
        sim.advance()


def test_a_travel_that_is_too_short_later_is_no_bad_value():
    # At most 4096 parts of 1e-4 of 0.1 m in 0.01 s: to 4.096 m/s, the speed of step 41.75.
    sim = bipot.Simulation.from_text("""
disks = [{position = [0, 0], radius = 0.1, mass = 1}]
time = {step = 1e-2, steps = 100, travel = 1e-4}""")
    for _ in range(41):
        sim.advance()
    refused(bipot.StepError, "give a smaller step", sim.advance)


def test_a_step_is_not_begun_within_a_step():
    def again(problem, tol, callback):
        return sim.advance()

    sim = bipot.Simulation("sliding_cylinder", solver=again)
    refused(bipot.StepError, "in the middle of a step", sim.advance)
    assert sim.steps_done == 0


def moving_wall_scene(tmp_path):
    """The sliding cylinder on a belt instead of a floor."""
    text = (DATA / "scenes" / "sliding_cylinder.toml").read_text()
    assert text.count('name = "floor"') == 1
    path = tmp_path / "belt.toml"
    path.write_text(text.replace('name = "floor"', 'name = "belt"\nvelocity = [0, 0]'))
    return path


def test_python_moves_a_wall(tmp_path):
    """A belt under a cylinder: friction drags it along, as far as the belt goes."""
    path = moving_wall_scene(tmp_path)
    still = bipot.Simulation(path, num_steps=50)
    moved = bipot.Simulation(path, num_steps=50)
    assert moved.walls[0]["motion"] == "moving" and moved.walls[0]["velocity"] == (0, 0)
    for k in range(50):
        still.advance()
        moved.set_wall("belt", velocity=(0.5 * k, 0))
        step = moved.advance()
        assert step.walls[0]["velocity"] == (0.5 * k, 0)
    a, b = still.state, moved.state
    assert b.velocities[0, 0] > a.velocities[0, 0] + 1e-3
    # The wall went the way that its velocities add up to.
    h = moved.step_size
    gone = moved.walls[0]["a"][0] - still.walls[0]["a"][0]
    assert gone == pytest.approx(h * 0.5 * sum(range(50)), rel=1e-9)
    assert step.energy["wall_work"] != 0
    assert abs(step.energy["imbalance"]) < 1e-9


def test_walls_that_python_may_not_move_are_refused(tmp_path):
    sim = bipot.Simulation("square_lattice")
    name = sim.walls[0]["name"]
    with pytest.raises(ValueError, match="is fixed: a wall with a velocity needs 'velocity'"):
        sim.set_wall(0, velocity=(1, 0))
    refused(ValueError, "is fixed: a wall with a force", sim.set_wall, name or 0, force=1)
    scene = dict(time=dict(step=1e-3, steps=1), disks=[dict(position=[0, 2], radius=0.5, mass=1)],
                 walls=[dict(point=[0, 0], normal=[0, 1], force=1, mass=1, velocity=[1, 0])])
    refused(ValueError, "'velocity' without 'force'", bipot.Simulation(scene).set_wall, 0, velocity=(1, 0))
    refused(ValueError, "wall 99: the scene has walls 0 to", sim.set_wall, 99, velocity=(1, 0))
    refused(ValueError, "unknown wall 'lid'", sim.set_wall, "lid", velocity=(1, 0))
    belt = bipot.Simulation(moving_wall_scene(tmp_path))
    refused(ValueError, "velocity has size 3", belt.set_wall, "belt", velocity=(1, 0, 0))
    refused(ValueError, "expected 2 finite", belt.set_wall, "belt", velocity=(np.nan, 0))
    refused(ValueError, "is moving: a wall with a force", belt.set_wall, "belt", velocity=(1, 0), force=3)
    assert belt.walls[0]["velocity"] == (0, 0)


def test_a_step_of_another_size_keeps_the_duration():
    """Or the number of steps, where the scene has that."""
    scene = dict(disks=[dict(position=[0, 2], radius=0.5, mass=1)], time=dict(step=1e-3, duration=0.02))
    fine = [step.time for step in bipot.Simulation(scene, step=5e-4)]
    assert len(fine) == 40 and fine[-1] == pytest.approx(0.02)
    assert len(list(bipot.Simulation(scene, step=5e-4, num_steps=3))) == 3
    assert len(list(bipot.Simulation(scene | dict(time=dict(step=1e-3, steps=4)), step=5e-4))) == 4
    refused(ValueError, "is shorter than a step of 0.5 s", bipot.Simulation, scene, step=0.5)


def test_springs_take_no_options_of_solvers():
    scene = dict(disks=[dict(position=[0, 2], radius=0.5, mass=1)], time=dict(step=1e-3, steps=4),
                 model="dem")
    assert len(list(bipot.Simulation(scene))) == 4
    for option in (dict(tol=1e-3), dict(max_iterations=5), dict(warm_start=False), dict(omega=1.2)):
        refused(ValueError, "have no meaning for springs", bipot.Simulation, scene, **option)


def test_driven_walls_take_forces():
    def squeezed(factor):
        sim = bipot.Simulation("isotropic_compression", num_steps=1, tol=1e-1)
        wall = next(k for k, w in enumerate(sim.walls) if w["motion"] == "driven")
        sim.set_wall(wall, force=factor * sim.walls[wall]["force"])
        sim.advance()
        return np.array(sim.walls[wall]["velocity"])

    once, twice = squeezed(1), squeezed(2)
    assert np.linalg.norm(twice) > 1.5 * np.linalg.norm(once) > 0


def test_springs_are_a_model_too(tmp_path):
    text = (DATA / "scenes" / "sliding_cylinder.toml").read_text()
    (tmp_path / "dem.toml").write_text('model = "dem"\n' + text)
    for step in bipot.Simulation(tmp_path / "dem.toml", num_steps=20):
        pass
    assert step.energy["elastic"] > 0 and len(step.contacts) == 1
    assert step.problem.num_contacts == 0  # nothing is solved
    rigid = bipot.Simulation(tmp_path / "dem.toml", solver="pgs").advance()
    assert rigid.problem.num_contacts == 1


def test_bad_scenes_and_options_are_refused(tmp_path):
    for function in (bipot.Simulation, bipot.advise):
        refused(FileNotFoundError, "missing.toml: no such file", function, "missing.toml")
    refused(ValueError, "did you mean 'bouncing_ball'", bipot.Simulation, "bouncing_bal")
    (tmp_path / "bad.toml").write_text("[nonsense]\n")
    refused(ValueError, "bad.toml", bipot.Simulation, tmp_path / "bad.toml")
    refused(ValueError, "did you mean 'pgs'", bipot.Simulation, "square_lattice", solver="pgz")
    refused(TypeError, "did you mean 'friction'", bipot.Simulation, "square_lattice", frictoin=0.3)
    with pytest.raises(ValueError, match="unknown parameter"):
        bipot.Simulation("square_lattice", solver="ipm", omega=1.2)
    refused(ValueError, "tol = 0, expected a positive", bipot.Simulation, "square_lattice", tol=0)
    with pytest.raises(ValueError, match="max_iterations = -1"):
        bipot.Simulation("square_lattice", max_iterations=-1)
    with pytest.raises(ValueError):
        bipot.Simulation("square_lattice", step=-1.0)
    with pytest.raises(ValueError):
        bipot.Simulation("square_lattice", friction=-1.0)


# Advice


def test_advice_is_that_of_the_command():
    a = bipot.advise("bouncing_ball", energy=1e-2, time_limit=20)
    assert a.status in ("met", "not met", "undecided") and a.message
    assert a["goal"]["energy"] == 1e-2 and a["goal"]["force"] is None
    if a["advice"]:
        assert a.solver in [row["name"] for row in bipot.solvers()]
        assert a.tol > 0 and a.step > 0 and a.warm_start in (True, False)
    assert a.status in repr(a)


def test_advice_takes_a_goal_of_its_own_and_refuses_a_wrong_one():
    assert bipot.advise("bouncing_ball", solvers=["pgs"], time_limit=20)["default_goal"]
    for option in ("force_error", "energy", "time_limit", "window"):
        for value in (-1, float("nan")):
            refused(ValueError, f"{option} = .* expected a positive number",
                    bipot.advise, "bouncing_ball", **{option: value})
    refused(ValueError, "samples = 65", bipot.advise, "bouncing_ball", samples=65)
    refused(TypeError, "did you mean 'force_error'", bipot.advise, "bouncing_ball", force_eror=1e-2)


def test_spheres_are_taken_step_by_step():
    sim = bipot.Simulation("four_spheres", num_steps=20)
    steps = list(sim)
    last = steps[-1]
    n = len(last.radii)
    assert n == 4 and isinstance(last, bipot.SphereStep) and last.converged
    assert last.positions.shape == last.velocities.shape == last.spins.shape == (n, 3)
    assert not last.positions.flags.writeable and last.positions.base is last
    assert np.allclose(np.linalg.norm(last.orientations, axis=1), 1)
    c, p = last.contacts, last.problem
    assert p.dim == 3 and len(c) == p.num_contacts
    n_of = np.column_stack([c["n_x"], c["n_y"], c["n_z"]])
    s_t = np.column_stack([c["s_tx"], c["s_ty"], c["s_tz"]])
    assert np.allclose(np.linalg.norm(n_of, axis=1), 1)
    assert np.allclose((n_of * s_t).sum(axis=1), 0, atol=1e-12)
    # At rest the impulses of the floor carry the weight.
    floor = c["j"] >= n
    held = (c["s_n"][floor, None] * n_of[floor] + s_t[floor]).sum(axis=0)
    weight = last.masses.sum() * 9.81 * sim.step_size
    assert held[2] == pytest.approx(weight, rel=1e-3)
    assert [w["shape"] for w in last.walls] == ["half-space"]
    assert sim.state.positions.shape == (n, 3)


def sweeps_in_space(problem, tol, callback):
    """Projected Gauss-Seidel in d = 3: the tangential impulse goes back into its disk."""
    W = problem.delassus().toarray()
    b, mu = problem.u_free, problem.mu
    s = np.zeros(len(b))
    while not callback(s):
        for c in range(len(mu)):
            n, t = 3 * c, [3 * c + 1, 3 * c + 2]
            s[n] = max(0, s[n] - (W[n] @ s + b[n]) / W[n, n])
            s[t] -= (W[t] @ s + b[t]) / W[t, t].max()
            s[t] *= min(1, mu[c] * s[n] / max(np.linalg.norm(s[t]), 1e-300))
    return s


def test_a_python_solver_drives_spheres():
    """The same velocities as another solver's, of a sphere that slides on a floor: unique."""
    scene = """
dim = 3
contact = {mu = 0.2}
spheres = [{position = [0, 0, 0.5], radius = 0.5, mass = 2, velocity = [3, 1, 0]}]
walls = [{name = "plate", point = [0, 0, 0], normal = [0, 0, 1], velocity = [0, 1, 0]}]
time = {step = 0.01, steps = 20}
"""
    ours = bipot.Simulation.from_text(scene, solver=sweeps_in_space, tol=1e-10)
    theirs = bipot.Simulation.from_text(scene, solver="ipm", tol=1e-10)
    refused(ValueError, "expected 3 finite", ours.set_wall, "plate", velocity=(1, 2))
    for sim in (ours, theirs):
        sim.set_wall("plate", velocity=(0, -1, 0))
    for a, b in zip(ours, theirs):
        assert a.converged, a.message
        assert np.allclose(a.velocities, b.velocities, atol=1e-7)
    # Coulomb: slower by mu g t against the relative motion (3, 2)/sqrt(13).
    slowed = np.array([3, 1]) - 0.2 * 9.81 * 0.2 * np.array([3, 2]) / 13**0.5
    assert np.allclose(a.velocities[0, :2], slowed, atol=1e-2)
    assert abs(a.velocities[0, 2]) < 1e-9


def test_a_missing_plan_is_refused_before_the_first_step(tmp_path):
    with pytest.raises(OSError, match="missing.toml: cannot be read"):
        bipot.Simulation("drum", plan=tmp_path / "missing.toml")


def test_a_wall_with_a_schedule_keeps_it():
    wall = dict(name="lid", point=[0, 0], normal=[0, 1], velocity=[0, 1], times=[0, 1], factors=[1, 1])
    disk = dict(position=[0, 2], radius=0.5, mass=1)
    scene = dict(gravity=[0, 0], time=dict(step=1e-3, steps=5), disks=[disk], walls=[wall])
    sim = bipot.Simulation(scene)
    with pytest.raises(ValueError, match="wall 'lid' moves by the scene's schedule"):
        sim.set_wall("lid", velocity=(0, 7))
    with pytest.raises(ValueError, match="give a velocity or a force"):
        bipot.Simulation("square_lattice").set_wall(0)
