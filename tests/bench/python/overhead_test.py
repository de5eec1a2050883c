"""What Python costs beside the command."""

import json
import os
import subprocess
import time

import numpy as np
import pytest
import scipy.sparse as sparse

import bipot
from conftest import DATA, chain

COMMAND = os.environ["BIPOT_COMMAND"]
FILES = ["2d_triangular_lattice.hdf5", "2d_pile_300_mu03.hdf5", "2d_triangular_20_tilt10.hdf5"]


@pytest.mark.parametrize("name", FILES)
def test_solve_takes_what_the_command_takes(name):
    """At most 5 ms around set-up and iteration; these are the command's own, bit for bit."""
    path = DATA / "problems" / name
    command = [COMMAND, "solve", str(path), "--solver", "apgd", "--tol", "1e-4", "--json", "-"]
    said = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
    p = bipot.read(path)
    around = []
    for _ in range(5):
        begin = time.perf_counter()
        r = bipot.solve(p, solver="apgd", tol=1e-4)
        around.append(time.perf_counter() - begin - r.setup_seconds - r.solve_seconds)
    assert r.iterations == said["iterations"]
    assert (r.epsilon, r.eta) == (said["epsilon"], said["eta"])
    print(f"{name}: {1e3 * min(around):.2f} ms around {1e3 * r.solve_seconds:.2f} ms")
    assert min(around) <= 5e-3


def test_large_problems_go_over_in_little_time():
    W = sparse.diags(np.tile([1.0, 3.0], 100_000)).tocsr()
    arguments = dict(W=W, u_free=np.tile([-1.0, 2.0], 100_000), mu=np.full(100_000, 0.5))
    begin = time.perf_counter()
    p = bipot.Problem(**arguments)
    made = time.perf_counter() - begin
    begin = time.perf_counter()
    total = sum(x.nbytes for x in (p.W.data, p.u_free, p.mu))
    viewed = time.perf_counter() - begin
    assert total == 4e6
    print(f"Problem of 1e5 contacts: {1e3 * made:.1f} ms, views {1e3 * viewed:.2f} ms")
    assert made < 1 and viewed < 0.05
    assert chain(2).num_contacts == 2


def best(call, times=300):
    seconds = []
    for _ in range(times):
        begin = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begin)
    return 1e6 * min(seconds)


def small_problems():
    """One contact, and eight in space with coordinates that are not coupled, and coupled."""
    rng = np.random.default_rng(0)
    A, H, v = np.diag(rng.uniform(1, 2, 24)), rng.normal(size=(24, 24)), rng.normal(size=24)
    yield "one", dict(W=np.diag([1.0, 3.0]), u_free=[-1, 0.75], mu=[0.5])
    yield "eight", dict(A=A, H=H, v_free=v, mu=[0.5] * 8)
    yield "eight, sparse", dict(A=sparse.csc_matrix(A), H=sparse.csc_matrix(H), v_free=v, mu=[0.5] * 8)
    yield "eight, coupled", dict(A=A + 0.1, H=H, v_free=v, mu=[0.5] * 8)


@pytest.mark.parametrize("name, data", small_problems())
def test_a_problem_costs_no_more_than_its_solve(name, data):
    p = bipot.Problem(**data)
    made, solved = best(lambda: bipot.Problem(**data)), best(lambda: bipot.solve(p, tol=1e-6))
    changed = best(lambda: p.update(u_free=p.u_free))
    print(f"{name}: Problem {made:.1f} us, update {changed:.1f} us, solve {solved:.1f} us")
    assert made <= solved and changed <= 0.5 * solved
