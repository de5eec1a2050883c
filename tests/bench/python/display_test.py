"""What objects show of themselves, and the words for wrong arguments."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest

import bipot
from conftest import chain, one_contact, refused

matplotlib.use("svg")


def test_a_result_is_true_if_it_converged(lattice):
    assert bipot.solve(lattice, tol=1e-3)
    failed = bipot.solve(lattice, solver="pgs", tol=1e-12, max_iterations=1)
    assert not failed and failed.status == "iteration limit" and failed.tol == 1e-12
    assert bipot.solve(one_contact(1, 0))  # nothing to do


def test_objects_say_what_they_are(lattice):
    sim = bipot.Simulation("bouncing_ball")
    step = next(sim)
    assert repr(sim).startswith("<bipot.Simulation ") and "step 1 of" in repr(sim)
    assert "1 bodies" in repr(sim.state) and "t = " in repr(step)
    advice = bipot.Advice(status="met", message="take it", advice=dict(solver="pgs", tol=1e-3,
                          warm_start=True, step=1e-4))
    for thing, word in [
        (lattice, "267"),
        (bipot.solve(lattice, tol=1e-3), "converged"),
        (step, "converged"),
        (sim.state, "bodies"),
        (sim, "step"),
        (advice, "take it"),
        (next(bipot.Simulation("four_spheres")), "SphereStep"),
    ]:
        html = thing._repr_html_()
        assert html.startswith("<table>") and html.endswith("</table>") and word in html
    named = bipot.Problem(W=np.eye(2), u_free=[0, 0], mu=[0], name="<b>")
    assert "&lt;b&gt;" in named._repr_html_() and "<b>" not in named._repr_html_()


def test_a_step_is_drawn():
    """Triangular packing: as many circles as disks, as many lines as contacts that push."""
    step = bipot.Simulation("triangular_lattice").advance()
    axes = step.plot()
    circles, *forces = axes.collections
    assert len(circles.get_paths()) == len(step.radii)
    assert sum(len(f.get_segments()) for f in forces) == (step.contacts["s_n"] > 0).sum() > 0
    # A line between two disks has the length of their distance.
    c = step.contacts[0]
    begin, end = step.positions[c["i"]], step.positions[c["j"]] if c["j"] < len(step.radii) else None
    segments = np.concatenate([f.get_segments() for f in forces])
    if end is not None and c["s_n"] > 0:
        assert np.abs(segments - [begin, end]).sum(axis=(1, 2)).min() < 1e-6
    assert step.plot(axes) is axes
    assert axes.get_xlabel() == "x [m]" and "t = " in axes.get_title()
    for scene in ("drum", "four_spheres", "pipe", "sliding_cylinder"):
        axes = bipot.Simulation(scene).advance().plot()
        axes.figure.canvas.draw()
        assert axes.get_ylabel() == ("y [m]" if scene in ("drum", "sliding_cylinder") else "z [m]")
        matplotlib.pyplot.close(axes.figure)
    assert bipot.Simulation("bouncing_ball").state.plot().collections


def test_polygons_are_left_out_and_a_cylinder_is_seen_from_the_side():
    state = bipot.Simulation.from_text("""
time = { step = 1e-3, steps = 1 }
spheres = [{ position = [0, 0, 0.5], radius = 0.1, mass = 1 }]
walls = [{ corners = [[-1, -1, 0], [1, -1, 0], [0, 1, 0]] },
         { center = [0, 0, -7], axis = [0, 0, 1], radius = 0.5, hollow = true }]
""").state
    axes = state.plot()
    assert len(axes.lines) == 2
    low, high = axes.get_xlim()
    assert low < -0.5 and high > 0.5
    assert axes.get_ylim()[0] > 0.3
    axes.figure.canvas.draw()


def test_a_history_is_drawn(lattice):
    r = bipot.solve(lattice, solver="apgd", tol=1e-6)
    axes = r.plot()
    guarded, *_, tolerance = axes.lines
    assert np.array_equal(guarded.get_ydata(), r.history["guarded"])
    assert set(tolerance.get_ydata()) == {1e-6} and axes.get_yscale() == "log"
    axes.figure.canvas.draw()


def test_without_matplotlib_plot_says_so():
    code = """
import sys
sys.modules["matplotlib"] = None
import bipot
try:
    bipot.Simulation("bouncing_ball").advance().plot()
except ImportError as error:
    print(error)
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "plot() needs matplotlib (python3-matplotlib)"


@pytest.mark.parametrize(
    "name, meant",
    [("tolerance", "tol"), ("max_iter", "max_iterations"), ("maxiter", "max_iterations"),
     ("x0", "s0"), ("timeout", "time_limit"), ("method", "solver"), ("n_jobs", "threads"),
     ("eps", "tol"), ("omgea", "omega")],
)
def test_other_names_lead_to_the_right_one(name, meant):
    with pytest.raises(TypeError, match=f"unknown option '{name}'; did you mean '{meant}'"):
        bipot.solve(chain(1), **{"solver": "pgs", name: 1} if name != "method" else {name: 1})


def test_more_names_lead_to_the_right_one():
    refused(TypeError, "did you mean 'step'", bipot.Simulation, "bouncing_ball", dt=1e-3)
    refused(TypeError, "did you mean 'friction'", bipot.Simulation, "bouncing_ball", mu=0.1)
    refused(TypeError, "did you mean 'tols'", bipot.compare, "pile:4", tol=1e-3)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: bipot.solve(chain(1), tol="a"), "tol: expected a number, got str 'a'"),
        (lambda: bipot.solve(chain(1), tol=None), "tol: expected a number, got NoneType None"),
        (lambda: bipot.solve(chain(1), tol=True), "tol: expected a number, got bool True"),
        (lambda: bipot.solve(chain(1), max_iterations=1.5), "max_iterations: expected an integer"),
        (lambda: bipot.solve(chain(1), stop=1), "stop: expected a text, got int 1"),
        (lambda: bipot.solve(chain(1), solver=1), "solver: expected a name or a callable"),
        (lambda: bipot.judge([1], [1]), "problem: expected a bipot.Problem, got list"),
        (lambda: bipot.judge(chain(1), [1, 0]).within("a"), "tol: expected a number, got str 'a'"),
        (lambda: bipot.write(1, "p.hdf5"), "problem: expected a bipot.Problem, got int 1"),
        (lambda: bipot.Simulation("bouncing_ball", step="a"), "step: expected a number"),
        (lambda: bipot.Simulation("bouncing_ball", warm_start=2), "warm_start: expected True or"),
        (lambda: bipot.Simulation("bouncing_ball").set_wall(0.5, force=1), "wall: expected an integer"),
        (lambda: bipot.advise("bouncing_ball", energy="a"), "energy: expected a number"),
        (lambda: bipot.compare("pile:4", tols=["a"]), "tols: expected a number"),
        (lambda: bipot.problems(4), "target: expected a text, got int 4"),
        (lambda: bipot.Problem(W=np.eye(1), u_free=[1], mu="a", dim=1), "mu has dtype"),
    ],
)
def test_types_are_told_in_words(call, words):
    with pytest.raises(TypeError) as caught:
        call()
    assert words in str(caught.value) and "incompatible" not in str(caught.value)


def test_whole_numbers_may_be_floats():
    assert bipot.solve(chain(1), max_iterations=1e6)
    with pytest.raises(ValueError, match="max_iterations = .* is beyond 2147483647"):
        bipot.solve(chain(1), max_iterations=2**40)
