"""Problems that the tests share."""

import pathlib

import numpy as np
import pytest
import scipy.sparse as sparse

import bipot

DATA = pathlib.Path(__file__).parents[3] / "data"


@pytest.fixture
def lattice():
    """A packing at rest, d = 2, bodies known."""
    return bipot.read(DATA / "problems" / "2d_triangular_lattice.hdf5")


@pytest.fixture
def spheres():
    return bipot.read(DATA / "problems" / "3d_sphere_pyramid_2.hdf5")


def refused(error, words, call, *arguments, **options):
    """The call raises this error, with words that match."""
    with pytest.raises(error, match=words):
        call(*arguments, **options)


def one_contact(b_n, b_t, mu=0.5, dim=2):
    """W = 1: s_n = -b_n where it closes; |s_t| <= mu s_n."""
    u_free = [b_n, b_t, 0][:dim]
    return bipot.Problem(W=sparse.eye(dim), u_free=u_free, mu=[mu], name="one contact")


def foreign_scene(folder):
    """A scene of one disk, whose import leaves out another body."""
    bodies = "$bdyty\n RBDY2  1\n$nodty\n NO3xx  1  coo1= 0.1  coo2= 0.2  coo3= 0\n$tacty\n"
    (folder / "BODIES.DAT").write_text(
        f"{bodies} DISKx  1  color  BLEUx  byrd= 0.05\n$$$$$$\n"
        f"{bodies} JONCx  1  color  DOWNx  axe1= 4  axe2= 0.1\n$$$$$$\n"
    )
    scene = folder / "scene.toml"
    scene.write_text(
        '[[disks]]\narrangement = "file"\nfile = "BODIES.DAT"\ndensity = 100\n'
        "[time]\nstep = 1e-3\nsteps = 2\n"
    )
    return scene


def chain(contacts):
    """`contacts` disks of 1 kg side by side on a floor, each pushed down and aside: W is diagonal,
    W_nn = 1 and W_tt = 3; with mu = 0.5 every one of them slides with s = (1, -0.5)."""
    W = sparse.diags(np.tile([1.0, 3.0], contacts))
    return bipot.Problem(W=W, u_free=np.tile([-1.0, 2.0], contacts), mu=np.full(contacts, 0.5))


def gauss_seidel(problem, tol, callback):
    """Projected Gauss-Seidel in d = 2, a few lines of numpy: the solver that somebody brings."""
    W = problem.delassus().toarray()
    b, mu = problem.u_free, problem.mu
    s = np.zeros(len(b))
    while not callback(s):
        for c in range(len(mu)):
            n, t = 2 * c, 2 * c + 1
            s[n] = max(0, s[n] - (W[n] @ s + b[n]) / W[n, n])
            s[t] = np.clip(s[t] - (W[t] @ s + b[t]) / W[t, t], -mu[c] * s[n], mu[c] * s[n])
    return s
