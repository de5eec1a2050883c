"""solve, judge, solvers."""

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import scipy.sparse as sparse

import bipot
from conftest import DATA, chain, gauss_seidel, one_contact, refused


def test_a_result_has_what_the_command_says(lattice):
    r = bipot.solve(lattice, solver="ipm", tol=1e-9)
    assert r.status == "converged" and r.converged and r.solver == "ipm"
    assert r.guarded == max(r.epsilon, r.eta) <= 1e-9
    assert r.iterations > 0 and r.solve_seconds > 0 and r.setup_seconds >= 0
    assert r.take_off + r.stick + r.slip == lattice.num_contacts
    assert np.allclose(r.u, lattice.velocity(r.s), atol=1e-14)
    assert np.allclose(r.v, lattice.body_velocity(r.s), atol=0)
    assert r.worst_contact in range(lattice.num_contacts)
    assert "converged" in repr(r)
    e = bipot.judge(lattice, r.s)
    assert (e.epsilon, e.eta, e.natural_map) == (r.epsilon, r.eta, r.natural_map)


def test_history_is_a_structured_array(lattice):
    seen = []
    r = bipot.solve(lattice, solver="apgd", tol=1e-6, callback=lambda i: seen.append(i.guarded))
    h = r.history
    assert h.dtype.names == (
        "iteration", "seconds", "epsilon", "eta", "guarded", "raw42", "natural_map", "step",
        "take_off", "stick", "slip",
    )
    assert np.array_equal(h["guarded"], seen)
    assert np.array_equal(h["guarded"], np.maximum(h["epsilon"], h["eta"]))
    assert (np.diff(h["iteration"]) > 0).all() and (np.diff(h["seconds"]) >= 0).all()
    assert h["guarded"][-1] <= 1e-6 < h["guarded"][0]
    assert not h.flags.writeable
    kept = h.copy()
    del r
    assert h.tobytes() == kept.tobytes()


def test_views_of_a_result_need_no_copies(lattice):
    r = bipot.solve(lattice, tol=1e-3)
    assert r.s.base is r and r.s.ctypes.data == r.s.ctypes.data
    with pytest.raises(ValueError):
        r.s[0] = 1
    s = r.s
    kept = s.copy()
    del r
    assert np.array_equal(s, kept)


def test_the_three_states_by_hand():
    assert np.array_equal(bipot.solve(one_contact(1, 2)).s, [0, 0])
    assert bipot.solve(one_contact(1, 2)).status == "nothing to do"
    assert np.allclose(bipot.solve(one_contact(-1, 0.25)).s, [1, -0.25], atol=1e-8)
    assert np.allclose(bipot.solve(one_contact(-1, 0.75)).s, [1, -0.5], atol=1e-8)


@pytest.mark.parametrize("solver", [row["name"] for row in bipot.solvers()])
def test_every_solver_of_the_table_solves(solver):
    if solver.startswith("siconos:"):
        p = one_contact(-1, 0.75)  # their own limits of sizes and dimensions
    else:
        p = chain(5)
    r = bipot.solve(p, solver=solver, tol=1e-8)
    assert r.converged, r.message
    assert np.allclose(r.s, np.tile([1, -0.5], p.num_contacts), atol=1e-6)


def test_parameters_are_those_of_the_table(lattice):
    rows = {row["name"]: row for row in bipot.solvers()}
    omega = next(p for p in rows["pgs"]["parameters"] if p["name"] == "omega")
    assert omega["kind"] == "number"
    assert omega["minimum"] < float(omega["default"]) < omega["maximum"]
    slow = bipot.solve(lattice, solver="pgs", tol=1e-3, omega=0.5)
    fast = bipot.solve(lattice, solver="pgs", tol=1e-3, omega=np.float64(1.3))
    assert slow.converged and fast.converged and fast.iterations < slow.iterations
    refused(ValueError, "parameter omega = '7'", bipot.solve, lattice, solver="pgs", omega=7)
    with pytest.raises(TypeError, match="unknown option 'omgea'; did you mean 'omega'"):
        bipot.solve(lattice, solver="pgs", omgea=1)
    with pytest.raises(TypeError, match="option 'max_iteration'; did you mean 'max_iterations'"):
        bipot.solve(lattice, max_iteration=3)
    with pytest.raises(TypeError, match="parameter omega = None: expected a number"):
        bipot.solve(lattice, solver="pgs", omega=None)


@pytest.mark.parametrize(
    "options, words",
    [
        (dict(solver="pgz"), "unknown solver 'pgz'; did you mean 'pgs'"),
        (dict(tol=0), "tol = 0, expected a positive"),
        (dict(tol=float("nan")), "tol = nan"),
        (dict(time_limit=-1), "time_limit = -1"),
        (dict(stop="gaurded"), "did you mean 'guarded'"),
        (dict(max_iterations=-1), "max_iterations = -1"),
        (dict(s0=[1, 2]), "start s0 has size 2"),
        (dict(s0=[]), "start s0 has size 0"),
        (dict(solver="lemke"), "at most 300 contacts"),
    ],
)
def test_bad_options_are_refused_with_the_commands_sentence(options, words):
    refused(ValueError, words, bipot.solve, chain(400), **options)


def test_the_plan_is_read_before_the_clock_starts(lattice, tmp_path):
    shipped = (DATA.parent / "solvers" / "auto" / "plan.toml").read_text()
    plan = tmp_path / "long.toml"
    plan.write_text(shipped + "# more\n" * 1_000_000)
    begin = time.perf_counter()
    r = bipot.solve(lattice, plan=plan)
    assert r.setup_seconds + r.solve_seconds < 0.5 * (time.perf_counter() - begin)
    plan.unlink()
    refused(ValueError, "long.toml: cannot be read", bipot.solve, lattice, plan=plan)


def test_starts_are_used(lattice):
    r = bipot.solve(lattice, tol=1e-8)
    again = bipot.solve(lattice, tol=1e-8, s0=r.s)
    assert again.iterations == 0 and again.message == "the start meets the stop test"


def test_limits_are_statuses(lattice):
    r = bipot.solve(lattice, solver="pgs", tol=1e-14, max_iterations=3)
    assert r.status == "iteration limit" and not r.converged
    r = bipot.solve(lattice, solver="uzawa", tol=1e-14, time_limit=1e-9)
    assert r.status == "time limit"
    r = bipot.solve(lattice, solver="pgs", tol=1e-14, callback=lambda i: i.iteration >= 7)
    assert r.status == "interrupted" and r.history["iteration"][-1] <= 8


def test_what_a_callback_raises_is_raised(lattice):
    def fail(i):
        raise RuntimeError(f"no more after {i.iteration}")

    refused(RuntimeError, "no more after 0", bipot.solve, lattice, solver="pgs", callback=fail)
    assert bipot.solve(lattice, tol=1e-3).converged  # and nothing is left of it


@pytest.mark.parametrize("contacts", [0, 1, 100_000])
def test_every_size(contacts):
    W = sparse.diags(np.tile([1.0, 3.0], contacts)) if contacts else sparse.csr_matrix((0, 0))
    p = bipot.Problem(
        W=W, u_free=np.tile([-1.0, 2.0], contacts), mu=np.full(contacts, 0.5), dim=2
    )
    r = bipot.solve(p, tol=1e-8)
    assert r.converged
    assert r.s.shape == (2 * contacts,)
    assert np.allclose(r.s, np.tile([1, -0.5], contacts), atol=1e-6)
    e = bipot.judge(p, r.s)
    assert e.within(1e-8) and e.slip == contacts
    assert len(r.history) == 0 or r.history["guarded"][-1] <= 1e-8
    assert bool(repr(p)) and p.u_free.shape == (2 * contacts,)


def test_other_threads_run_on_during_a_solve():
    p = bipot.problems("square:40:tilt=10")[0]
    ticks, over = [], threading.Event()

    def tick():
        while not over.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    bipot.solve(p, solver="pgs", tol=1e-14, time_limit=0.5)
    end = time.perf_counter()
    over.set()
    thread.join()
    inside = [t for t in ticks if begin < t < end]
    # One that held the lock would let none through. (Busy machines do not tick each millisecond.)
    assert len(inside) > 20


def test_two_solves_at_once_agree_with_one(lattice):
    alone = bipot.solve(lattice, solver="apgd", tol=1e-6).s
    results = [None] * 4

    def run(k):
        results[k] = bipot.solve(lattice, solver="apgd", tol=1e-6).s

    threads = [threading.Thread(target=run, args=(k,)) for k in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for s in results:
        assert np.array_equal(s, alone)


INTERRUPTED = """
import bipot
p = bipot.problems("square:40:tilt=10")[0]
sim = bipot.Simulation("collapse_1000", solver="pgs", tol=1e-15, max_iterations=10**9)
print("ready", flush=True)
try:
    {}
except KeyboardInterrupt:
    print("interrupted", bipot.solve(p, tol=1e-2).converged)
"""


@pytest.mark.parametrize(
    "call",
    [
        'bipot.solve(p, solver="pgs", tol=1e-15, time_limit=60)',
        'bipot.solve([p] * 4, solver="pgs", tol=1e-15, time_limit=60, threads=2)',
        "list(sim)",
        'bipot.compare(p, solvers=["pgs"], tols=[1e-15], time_limit=60)',
        'bipot.advise("collapse_1000", force_error=1e-3)',
        'bipot.problems("tilt_1000")',
        'bipot.compare("tilt_1000", solvers=["pgs"], tols=[1e-2])',
    ],
)
def test_ctrl_c_is_a_keyboard_interrupt(call):
    code = INTERRUPTED.format(call)
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.5)
    sent = time.perf_counter()
    child.send_signal(signal.SIGINT)
    out, _ = child.communicate(timeout=60)
    assert out == "interrupted True\n"
    assert time.perf_counter() - sent < 30


def test_nothing_is_printed(capfd, lattice):
    bipot.solve(lattice, solver="newton" if has("newton") else "ipm", tol=1e-6)
    with pytest.raises(ValueError):
        bipot.solve(lattice, solver="nonsense")
    bipot.judge(lattice, np.zeros(lattice.num_rows))
    out = capfd.readouterr()
    assert out.out == "" and out.err == ""


def has(solver):
    return solver in [row["name"] for row in bipot.solvers()]


# Judge


def test_a_verdict_says_what_is_wrong_and_where():
    p = chain(4)
    s = np.tile([1.0, -0.5], 4)
    assert bipot.judge(p, s).guarded == 0 and bipot.judge(p, s).worst == []
    s[2:4] = [-0.25, 0]
    e = bipot.judge(p, s)
    assert not e.within(1e-8)
    assert e.worst_contact == 1 and e.cone_contact == 1 and e.cone_violation == 0.25
    worst = e.worst[0]
    # W_nn s_n² / 2 off the cone; P(s) = 0 there, so that b_n = -1 stays: u_n² / 2 W_nn.
    assert {f["kind"]: f["energy"] for f in worst.faults} == {"pulls": 1 / 32, "penetrates": 0.5}
    assert np.array_equal(worst.s, [-0.25, 0]) and np.array_equal(worst.u, [-1, 2])
    assert worst.share == 1
    assert "contact 1: penetrates at 1.0e+00 m/s; pulls with" in str(worst)
    assert e.penetration_velocity == 1 and e.penetration_contact == 1
    assert e.sentence(1e-8).startswith("not within the tolerance 1e-8")
    assert np.array_equal(e.s[2:4], [0, 0])
    assert (e.take_off, e.slip) == (1, 3)


def test_a_verdict_is_projected_but_says_how_far():
    p = one_contact(-1, 0.75)
    e = bipot.judge(p, [1, -0.8])
    assert e.cone > 0 and e.guarded >= e.cone
    assert e.worst[0].faults[0]["kind"] in ("outside the cone", "acts across a gap")
    assert len(bipot.judge(chain(9), np.zeros(18), worst=3).worst) == 3


def test_what_is_no_impulse_is_refused():
    p = chain(2)
    for s, error, words in [
        ([1, 2], ValueError, "s has size 2, expected 4 = 2 contacts x 2"),
        ([1, np.nan, 0, 0], ValueError, r"s\[1\] = nan is not finite"),
        (np.zeros((2, 2)), ValueError, r"s has shape \(2, 2\), expected one dimension"),
        (["a"] * 4, TypeError, "s has dtype"),
        (None, TypeError, "s has dtype object"),
    ]:
        refused(error, words, bipot.judge, p, s)
    refused(TypeError, "did you mean 'worst'", bipot.judge, p, [0, 0, 0, 0], wrost=1)


# Python solvers


def test_a_python_solver_is_a_solver():
    p = bipot.problems("square:6:tilt=10")[0]
    r = bipot.solve(p, solver=gauss_seidel, tol=1e-3, time_limit=60)
    assert r.status == "converged" and r.solver == "gauss_seidel"
    assert r.iterations > 10 and r.history["guarded"][-1] <= 1e-3
    assert bipot.judge(p, r.s).within(1e-3)


def test_python_solvers_that_fail_are_told_apart():
    p = chain(3)
    right = np.tile([1.0, -0.5], 3)

    def raises(problem, tol, callback):
        raise ArithmeticError("the pivot is 0")

    def run(f, **options):
        return bipot.solve(p, solver=f, tol=1e-6, **options)

    assert run(lambda problem, tol, callback: right).converged
    for solver, words in [
        (raises, "raises failed: ArithmeticError: the pivot is 0"),
        (lambda problem, tol, callback: 0.9 * right, "claim of convergence withdrawn"),
        (lambda problem, tol, callback: right * np.nan, "non-finite"),
        (lambda problem, tol, callback: right[:-1], "5 rows, expected 6"),
        (lambda problem, tol, callback: None, "returned None, expected an array of 6 numbers"),
        (lambda problem, tol, callback: "text", "s has dtype"),
        (lambda: None, "TypeError"),
        (lambda problem, tol, callback: callback([1.0, 2.0]), "s has size 2, expected 6"),
    ]:
        r = run(solver)
        assert r.status == "numerical failure" and words in r.message
    assert run(raises).message == "raises failed: ArithmeticError: the pivot is 0"
    assert 0 < run(lambda problem, tol, callback: 0.9 * right).guarded < 1  # the lie is measured
    not_finite = run(lambda problem, tol, callback: right * np.nan)
    assert np.array_equal(not_finite.s, np.zeros(6))
    refused(TypeError, "expected a name or a callable", bipot.solve, p, solver=3)
    refused(TypeError, "unknown option 'omega'", bipot.solve, p, solver=raises, omega=1)


def test_a_python_solver_is_told_when_to_stop():
    p = chain(3)

    def idle(problem, tol, callback):
        s = np.zeros(problem.num_rows)
        while not callback(s + 1e-3 * np.random.default_rng(0).random(len(s))):
            time.sleep(1e-3)
            s[0] += 1e-9
        return s

    r = bipot.solve(p, solver=idle, time_limit=0.1)
    assert r.status == "time limit", r.message
    r = bipot.solve(p, solver=idle, max_iterations=5)
    assert r.status == "iteration limit" and r.iterations == 5


def test_a_callback_that_is_kept_is_harmless():
    kept = []

    def leaks(problem, tol, callback):
        kept.append((callback, problem))
        return np.tile([1.0, -0.5], 3)

    assert bipot.solve(chain(3), solver=leaks).converged
    callback, problem = kept[0]
    refused(RuntimeError, "is over", callback, np.zeros(6))
    assert problem.num_contacts == 3 and problem.W.nnz == 6


def test_keyboard_interrupt_in_a_python_solver_ends_everything():
    def interrupted(problem, tol, callback):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bipot.solve(chain(2), solver=interrupted)
    with pytest.raises(KeyboardInterrupt):
        bipot.compare(chain(2), solvers=[interrupted, "pgs"], tols=[1e-2])
