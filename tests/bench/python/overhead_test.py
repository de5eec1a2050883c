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
