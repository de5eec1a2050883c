"""Many problems: update, lists with threads, pickle, processes."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
import scipy.sparse as sparse

import bipot
from conftest import DATA, chain, foreign_scene, gauss_seidel, one_contact, refused


def family(count=20):
    """Eight contacts in space on dense random bodies; the problems differ in v_free."""
    rng = np.random.default_rng(7)
    A, H = np.diag(rng.uniform(1, 2, 24)), rng.normal(size=(24, 24))
    first = bipot.Problem(A=A, H=H, v_free=rng.normal(size=24), mu=[0.5] * 8)
    return [first, *(first.update(v_free=rng.normal(size=24)) for _ in range(count - 1))]


def same_result(a, b):
    """But for times."""
    for name in ("s", "u", "v"):
        assert np.array_equal(getattr(a, name), getattr(b, name)), name
    for name in ("solver", "tol", "status", "message", "iterations", "guarded", "slip", "stick"):
        assert getattr(a, name) == getattr(b, name), name


# update


def test_an_update_is_the_problem_made_anew(lattice):
    v, mu = 2 * lattice.v_free, lattice.mu + 0.1
    new = lattice.update(v_free=v, mu=mu)
    made = bipot.Problem(A=lattice.A, H=lattice.H, v_free=v, mu=mu)
    for name in ("v_free", "u_free", "mu"):
        assert np.array_equal(getattr(new, name), getattr(made, name)), name
    same_result(bipot.solve(new, tol=1e-6), bipot.solve(made, tol=1e-6))
    assert np.array_equal(lattice.update(mu=0.25).mu, np.full(lattice.num_contacts, 0.25))
    assert not np.array_equal(lattice.mu, mu) and lattice.name == new.name  # the old one stands
    by_w = one_contact(-1, 0.25).update(u_free=[-2, 0.25])
    assert np.allclose(bipot.solve(by_w).s, [2, -0.25])


def test_an_update_that_does_not_fit_is_refused(lattice):
    m, n = lattice.num_rows, lattice.num_dofs
    for change, words in [
        (dict(u_free=[0.0]), f"u_free has size 1, expected {m}"),
        (dict(v_free=np.zeros(n + 1)), f"v_free has size {n + 1}, expected {n}"),
        (dict(mu=[0.1, 0.2, 0.3]), f"mu has size 3, expected {m // 2}"),
        (dict(mu=-0.5), r"mu\[0\] = -0.5 is negative"),
        (dict(v_free=np.full(n, np.nan)), r"v_free\[0\] = nan is not finite"),
        (dict(v_before=np.zeros(n)), "give v_free or u_free with the velocities before"),
    ]:
        refused(ValueError, words, lattice.update, **change)
    refused(TypeError, "did you mean 'mu'", lattice.update, friction=0.5)
    refused(TypeError, "expected keywords", lattice.update, [0.0])
    refused(ValueError, "v_free is given without A and H", chain(2).update, v_free=[0, 0])


# Lists


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_a_list_gives_what_single_solves_give(threads):
    problems = family()
    alone = [bipot.solve(p, tol=1e-6) for p in problems]
    results = bipot.solve(problems, tol=1e-6, threads=threads)
    assert len(results) == len(problems) and all(results)
    for a, b in zip(alone, results):
        same_result(a, b)
    warm = bipot.solve(problems, tol=1e-6, s0=[r.s for r in alone], threads=threads)
    assert all(r.iterations == 0 for r in warm)
    assert bipot.solve([], threads=threads) == []


@pytest.mark.parametrize("solver", [row["name"] for row in bipot.solvers()])
def test_every_solver_takes_lists(solver):
    """As alone, whether it converges or not; some libraries serve one thread at a time."""
    problems = [chain(k) for k in (1, 2, 3, 4)]
    for a, b in zip(problems, bipot.solve(problems, solver=solver, tol=1e-6, threads=3)):
        same_result(bipot.solve(a, solver=solver, tol=1e-6), b)


def test_factors_in_several_threads_are_those_of_one():
    problems = [bipot.read(path) for path in sorted((DATA / "problems").glob("2d_*.hdf5"))[:8]]
    alone = bipot.solve(problems, solver="ipm", tol=1e-6)
    for _ in range(2):
        for a, b in zip(alone, bipot.solve(problems, solver="ipm", tol=1e-6, threads=3)):
            same_result(a, b)


def test_python_solvers_take_lists():
    problems = [chain(3), one_contact(-1, 0.25)] * 3
    for r in bipot.solve(problems, solver=gauss_seidel, tol=1e-9, threads=2):
        assert r and r.solver == "gauss_seidel"


def test_what_goes_wrong_in_a_list_is_raised():
    problems = [chain(2)] * 5

    def leaves(problem, tol, callback):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bipot.solve(problems, solver=leaves, threads=2)
    with pytest.raises(ValueError, match="problem 1: .*s0.*2"):
        bipot.solve([chain(1), chain(2)], s0=[None, [0.0, 0.0]])
    refused(ValueError, "s0 has 1 starts for 5 problems", bipot.solve, problems, s0=[[0.0] * 4])
    with pytest.raises(TypeError, match="problem 1: expected a bipot.Problem, got str 'pile'"):
        bipot.solve([chain(2), "pile"])
    with pytest.raises(TypeError, match="expected a bipot.Problem or a list of them, got ndarray"):
        bipot.solve(np.eye(2))
    refused(ValueError, "threads = 0", bipot.solve, problems, threads=0)
    refused(ValueError, "callback is for a single problem", bipot.solve, problems, callback=print)


# Copies


def test_problems_come_back_from_pickle_bit_for_bit(lattice, spheres):
    full = bipot.Problem(A=[[2, 1], [1, 2]], H=np.eye(2), v_free=[-1, 0.5], mu=[0.5], name="full")
    shock = bipot.Problem(
        A=np.eye(2), H=np.eye(2), v_free=[-1, 0.5], v_before=[-1, 0.5], mu=[0.1], restitution=0.8
    )
    bar = """
time = {step = 1e-3, steps = 1}
walls = [{point = [0, 0], normal = [0, 1]}]
clusters = [{parts = [[0, 0, 0.1], [0.5, 0, 0.1]], position = [0, 0.1], mass = 3}]
pins = [{bodies = [0], point = [0, 0.1]}]"""  # contact 0 is blocked by the pin
    pinned = next(bipot.Simulation.from_text(bar)).problem
    assert pinned.update(mu=[0, 0]).u_free[0] == 0
    for p in (lattice, spheres, chain(3), full, shock, pinned):
        q = pickle.loads(pickle.dumps(p))
        assert repr(q) == repr(p) and q.dim == p.dim
        for name in ("v_free", "u_free", "mu", "row_scale", "solution"):
            a, b = getattr(p, name), getattr(q, name)
            assert np.array_equal(a, b) if a is not None else b is None, name
        for name in ("A", "H", "W"):
            a, b = getattr(p, name), getattr(q, name)
            assert (a is None) == (b is None)
            if a is not None:
                assert np.array_equal(a.indices, b.indices) and np.array_equal(a.data, b.data)
        assert len(q.guesses) == len(p.guesses)
        same_result(bipot.solve(p, tol=1e-6), bipot.solve(q, tol=1e-6))
    again = pickle.loads(pickle.dumps(shock)).update(v_free=[-2, 1], v_before=[-2, 1])
    assert np.allclose(bipot.solve(again, tol=1e-12).impulse, [3.6, -0.36])


def test_results_come_back_from_pickle(lattice):
    r = bipot.solve(lattice, solver="apgd", tol=1e-6)
    q = pickle.loads(pickle.dumps(r))
    same_result(r, q)
    assert repr(q) == repr(r) and q.solve_seconds == r.solve_seconds
    assert q.history.tobytes() == r.history.tobytes() and len(q.history) > 1
    assert np.isnan(q.raw42) == np.isnan(r.raw42)


def test_what_never_changes_is_its_own_copy(lattice):
    r = bipot.solve(lattice, tol=1e-3)
    assert copy.deepcopy(lattice) is lattice and copy.copy(lattice) is lattice
    assert copy.deepcopy({"r": r})["r"] is r and copy.copy(r) is r


def test_a_pickle_that_was_changed_is_refused():
    function, (parts,) = chain(2).__reduce__()
    W = list(parts[3])
    W[3] = W[3].copy()
    W[3][0] = 99
    with pytest.raises(ValueError, match=r"W is not a sound sparse matrix: indices\[0\] = 99"):
        function((*parts[:3], tuple(W), *parts[4:]))
    function, (parts,) = bipot.solve(chain(2)).__reduce__()
    refused(ValueError, "another version", function, ("0.0.1", *parts[1:]))


def test_a_w_that_is_none_of_a_and_h_is_told_after_pickle_too():
    p = bipot.Problem(A=np.eye(2), H=np.eye(2), W=2 * np.eye(2), v_free=[-1, 0], mu=[0.5],
                      accept_indefinite=True)
    said = bipot.judge(pickle.loads(pickle.dumps(p)), [1, 0]).sentence(1e-6)
    assert "W is not that of A and H" in said and said == bipot.judge(p, [1, 0]).sentence(1e-6)


def test_what_cannot_be_pickled_says_so():
    step = bipot.Simulation("bouncing_ball").advance()
    for thing in (step, bipot.judge(chain(1), [1, 0])):
        refused(TypeError, "cannot pickle 'bipot._bipot", pickle.dumps, thing)


def solved(p):
    return bipot.solve(p, tol=1e-6)


def test_other_processes_take_problems_and_give_results():
    problems = family(6)
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        for p, r in zip(problems, pool.map(solved, problems)):
            same_result(r, solved(p))


def test_copies_of_a_simulation_do_not_warn_again(tmp_path, recwarn):
    sim = bipot.Simulation(foreign_scene(tmp_path))
    pickle.loads(pickle.dumps(copy.deepcopy(sim)))
    assert [str(w.message) for w in recwarn] == ["BODIES.DAT: 1 read, left out: 1 JONCx"]
    assert recwarn[0].filename == __file__


def test_a_simulation_goes_on_in_its_copy():
    """Bit for bit, with a wall that Python has set and its warm starts."""
    for scene, wall in (("hopper", None), ("four_spheres", None), ("isotropic_compression", "force")):
        sim = bipot.Simulation(scene, tol=1e-4)
        if wall:
            k = next(k for k, w in enumerate(sim.walls) if w["motion"] == "driven")
            sim.set_wall(k, force=1.5 * sim.walls[k]["force"])
        for _ in range(3):
            next(sim)
        for other in (copy.deepcopy(sim), pickle.loads(pickle.dumps(sim))):
            assert other.steps_done == 3 and other.walls == sim.walls and repr(other) == repr(sim)
            twin = copy.deepcopy(sim)
            for _ in range(2):
                a, b = next(twin), next(other)
                assert np.array_equal(a.positions, b.positions)
                assert np.array_equal(a.velocities, b.velocities)
                assert np.array_equal(a.contacts["s_n"], b.contacts["s_n"])
            assert sim.steps_done == 3
    ahead = [next(sim).positions for _ in range(2)][1]
    assert np.array_equal(ahead, a.positions)  # the original goes the way of its copies
