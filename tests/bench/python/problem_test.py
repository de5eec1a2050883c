"""Problems: what is taken, what is refused, what comes back."""

import pickle
import re

import numpy as np
import pytest
import scipy.sparse as sparse

import bipot
from conftest import DATA, chain, one_contact, refused


def refusal(error=ValueError, **arguments):
    with pytest.raises(error) as caught:
        bipot.Problem(**arguments)
    return str(caught.value)


def same(a, b):
    assert a.shape == b.shape
    assert abs(a - b).max() == 0 if a.nnz else b.nnz == 0


def rebuilt(p, convert=lambda m: m, **changes):
    """The problem once more from what Python sees of it."""
    arguments = dict(
        A=convert(p.A), H=convert(p.H), v_free=p.v_free, u_free=p.u_free, mu=p.mu,
        row_scale=p.row_scale,
    )
    arguments.update(changes)
    return bipot.Problem(**arguments)


def shuffled(m):
    """COO with its entries in another order, each split into two that add up to it."""
    m = m.tocoo()
    order = np.random.default_rng(1).permutation(m.nnz)
    row, col, data = m.row[order], m.col[order], m.data[order]
    return sparse.coo_matrix(
        (np.concatenate([0.25 * data, 0.75 * data]), (np.tile(row, 2), np.tile(col, 2))), m.shape
    )


def unsorted(m):
    """CSR whose rows have their columns backwards."""
    m = m.tocsr().copy()
    for begin, end in zip(m.indptr, m.indptr[1:]):
        m.indices[begin:end] = m.indices[begin:end][::-1].copy()
        m.data[begin:end] = m.data[begin:end][::-1].copy()
    m.has_sorted_indices = False
    return m


def with_zeros(m):
    m = m.tocoo()
    return sparse.coo_matrix(
        (np.append(m.data, 0.0), (np.append(m.row, 0), np.append(m.col, m.shape[1] - 1))), m.shape
    )


def wide_indices(m):
    m = m.tocsc().copy()
    m.indices, m.indptr = m.indices.astype(np.int64), m.indptr.astype(np.int64)
    return m


@pytest.mark.parametrize(
    "convert",
    [
        lambda m: m.tocsr(),
        lambda m: m.tocsc(),
        lambda m: m.tocoo(),
        lambda m: m.tolil(),
        lambda m: m.todok(),
        lambda m: m.tobsr(),
        lambda m: sparse.csr_array(m),
        lambda m: m.toarray(),
        unsorted,
        with_zeros,
        wide_indices,
    ],
)
def test_every_form_of_a_matrix_gives_the_same_problem(lattice, convert):
    q = rebuilt(lattice, convert)
    same(q.A, lattice.A)
    same(q.H, lattice.H)
    assert q.H.nnz == lattice.H.nnz
    assert np.array_equal(bipot.solve(q, tol=1e-6).s, bipot.solve(lattice, tol=1e-6).s)


def test_duplicates_are_summed(lattice):
    q = rebuilt(lattice, shuffled)
    assert abs(q.H - lattice.H).max() <= 1e-15
    assert q.H.nnz == lattice.H.nnz


def test_dense_arrays_of_any_layout_are_taken(lattice):
    p = bipot.Problem(W=[[2.0, 0.5], [0.5, 3.0]], u_free=[-1, 2], mu=[0.5])
    dense = p.W.toarray()
    packed = np.zeros(2, dtype=[("flag", "i1"), ("row", "f8", 2)])  # not aligned
    packed["row"] = dense
    wide = np.zeros((4, 6))
    wide[::2, ::3] = dense
    for W in (
        dense.tolist(), np.asfortranarray(dense), dense[::-1, ::-1][::-1, ::-1], wide[::2, ::3],
        dense.astype(">f8"), dense.astype(np.float32), dense.astype(np.longdouble),
        packed["row"], [np.array([2.0, 0.5]), [0.5, 3.0]],
    ):
        same(bipot.Problem(W=W, u_free=[-1, 2], mu=[0.5]).W, p.W)


def test_what_looks_like_a_sparse_matrix_is_checked():
    class Lies:
        format, nnz = "csr", 1
        indptr, indices, data = np.array([0, 1, 1]), np.array([0]), np.array([1.0])

        def __init__(self, **parts):
            self.shape = (2, 2)
            vars(self).update(parts)

        def tocoo(self):
            raise RuntimeError("not this way")

    for parts, words in [
        (dict(shape=(-1, 2)), "-1 x 2"),
        (dict(shape=(2, 2**40)), "at most 2147483647"),
        (dict(shape=(2,)), "expected a matrix"),
        (dict(indptr=np.array([0, 1])), "indptr has size 2, expected 3"),
        (dict(indptr=np.array([0, 5, 5])), r"indptr[1] = 5 after 0, with 1 entries"),
        (dict(indptr=np.array([0, 1, 0])), "indptr[2] = 0 after 1"),
        (dict(indices=np.array([-3])), "indices[0] = -3"),
        (dict(indices=np.array([0.5])), "indices is no list of integers"),
        (dict(data=np.ones((1, 1))), "data has not one dimension"),
    ]:
        assert words in refusal(W=Lies(**parts), u_free=[0, 0], mu=[0])
    with pytest.raises(RuntimeError, match="not this way"):
        bipot.Problem(W=Lies(format="dia"), u_free=[0, 0], mu=[0])


def test_arguments_are_copied_and_left_alone():
    W = unsorted(sparse.csr_matrix([[2.0, 1.0], [1.0, 3.0]]))
    indices, b = W.indices.copy(), np.array([-1.0, 0.5])
    p = bipot.Problem(W=W, u_free=b, mu=[0.5])
    assert np.array_equal(W.indices, indices)
    W.data[:] = 7
    b[:] = 7
    assert np.array_equal(p.W.toarray(), [[2, 1], [1, 3]])
    assert np.array_equal(p.u_free, [-1, 0.5])


def test_integers_and_single_precision_become_double():
    W = sparse.csr_matrix(np.array([[2, 0], [0, 6]], dtype=np.int8))
    p = bipot.Problem(W=W, u_free=np.array([-1, 2], dtype=np.float32), mu=[1])
    assert p.W.dtype == p.u_free.dtype == p.mu.dtype == np.float64
    assert np.array_equal(p.u_free, [-1, 2])
    # 100 + 100 does not fit into eight bits.
    twice = sparse.coo_matrix((np.array([100, 100, 1], np.int8), ([0, 0, 1], [0, 0, 1])), (2, 2))
    assert bipot.Problem(W=twice, u_free=[0, 0], mu=[0]).W[0, 0] == 200
    assert np.array_equal(bipot.Problem(W=W, u_free=np.arange(4.0)[::2], mu=[1]).u_free, [0, 2])


def test_views_are_read_only_without_copies_and_outlive_the_problem(lattice):
    assert lattice.u_free.base is lattice
    assert not lattice.u_free.flags.writeable
    assert not lattice.H.data.flags.writeable
    with pytest.raises(ValueError, match="read-only"):
        lattice.mu[0] = 1
    assert lattice.mu.ctypes.data == lattice.mu.ctypes.data
    mu, H = lattice.mu, lattice.H
    kept, product = mu.copy(), H @ np.ones(H.shape[1])
    del lattice
    bipot.solve(chain(100))
    assert np.array_equal(mu, kept)
    assert np.array_equal(H @ np.ones(H.shape[1]), product)


def test_delassus_and_velocities_are_those_of_scipy(lattice, spheres):
    for p in (lattice, spheres):
        W = p.delassus()
        expected = p.H.T @ sparse.diags(1 / p.A.diagonal()) @ p.H
        assert abs(W - expected).max() <= 1e-14 * abs(W).max()
        s = np.random.default_rng(2).normal(size=p.num_rows)
        assert np.allclose(p.velocity(s), W @ s + p.u_free, atol=1e-12 * abs(W @ s).max())
        v = p.v_free + (p.H @ s) / p.A.diagonal()
        assert np.allclose(p.body_velocity(s), v, atol=1e-12 * abs(v).max())
        assert not W.data.flags.writeable
    refused(ValueError, "given by W alone", chain(2).body_velocity, [0, 0, 0, 0])
    refused(ValueError, "s has size 3, expected 4", chain(2).velocity, [1, 2, 3])


def test_dim_is_inferred_given_or_refused():
    eye = sparse.eye(6)
    assert bipot.Problem(W=eye, u_free=np.zeros(6), mu=[1] * 6).dim == 1
    assert bipot.Problem(W=eye, u_free=np.zeros(6), mu=[1] * 3).dim == 2
    assert bipot.Problem(W=eye, u_free=np.zeros(6), mu=[1] * 2).dim == 3
    one_mu = bipot.Problem(W=eye, u_free=np.zeros(6), mu=0.3, dim=3)
    assert one_mu.num_contacts == 2 and np.array_equal(one_mu.mu, [0.3, 0.3])
    assert bipot.Problem(W=eye, u_free=np.zeros(6), mu=0.3, dim=np.int64(2)).num_contacts == 3
    assert "cannot be inferred from a single mu" in refusal(W=eye, u_free=np.zeros(6), mu=0.3)
    assert "cannot be inferred without contacts" in refusal(
        W=sparse.csr_matrix((0, 0)), u_free=[], mu=[]
    )
    assert "u_free has size 6, expected 4, 8 or 12" in refusal(W=eye, u_free=np.zeros(6), mu=[1] * 4)
    assert "dim = 4, expected 1, 2 or 3" in refusal(W=eye, u_free=np.zeros(6), mu=[1], dim=4)
    assert "multiple of dim = 3" in refusal(W=sparse.eye(4), u_free=np.zeros(4), mu=1, dim=3)
    assert "dim: expected" in refusal(TypeError, W=eye, u_free=np.zeros(6), mu=[1] * 3, dim=2.5)


def test_wrong_shapes_are_refused_with_field_and_both_sizes(lattice):
    p = lattice
    m, n = p.num_rows, p.num_dofs
    for change, words in [
        (dict(u_free=p.u_free[:-1], dim=2), f"u_free has size {m - 1}, expected {m}"),
        (dict(mu=p.mu[:-1], dim=2), f"u_free has size {m}, expected {m - 2}"),
        (dict(v_free=p.v_free[1:]), f"v_free has size {n - 1}, expected {n}"),
        (dict(A=sparse.eye(n - 3)), f"A (rows) has size {n - 3}, expected {n}"),
        (dict(H=p.H[:, 2:]), f"H (columns) has size {m - 2}, expected {m}"),
        (dict(W=sparse.eye(m + 1)), f"W (rows) has size {m + 1}, expected {m}"),
        (dict(row_scale=[1.0]), f"row_scale has size 1, expected {m}"),
        (dict(mu=p.mu.reshape(-1, 1)), f"mu has shape ({m // 2}, 1), expected one dimension"),
        (dict(H=np.zeros(3)), "H has shape (3,), expected a matrix"),
        (dict(v_free=None), "v_free is missing beside A and H"),
        (dict(H=None), "A is given without H"),
        (dict(mu=None), "mu is missing"),
    ]:
        refused(ValueError, re.escape(words), rebuilt, p, **change)
    assert "neither W nor (A, H) is given" in refusal(u_free=[0, 0], mu=[1])
    assert "u_free is missing" in refusal(W=sparse.eye(2), mu=[1])


def test_unsound_values_are_refused_with_their_place():
    W, b = sparse.eye(2).tocsr(), [-1.0, 0]
    assert refusal(W=W, u_free=[np.nan, 0], mu=[1]) == "u_free[0] = nan is not finite"
    assert refusal(W=W, u_free=b, mu=[-0.1]) == "mu[0] = -0.1 is negative"
    assert "W_nn of contact 0 = 0 is not positive" in refusal(W=0 * W, u_free=b, mu=[1])
    assert "is not finite" in refusal(W=W * np.inf, u_free=b, mu=[1])
    H = sparse.eye(2)
    assert "A(1, 1) = -1 is not positive" in refusal(
        A=sparse.diags([1.0, -1.0]), H=H, v_free=[0, 0], mu=[1]
    )
    assert "A is not symmetric" in refusal(
        A=np.array([[2.0, 1.0], [0.0, 2.0]]), H=H, v_free=[0, 0], mu=[1]
    )
    assert "A is not positive definite" in refusal(
        A=np.array([[1.0, 2.0], [2.0, 1.0]]), H=H, v_free=[0, 0], mu=[1]
    )
    broken = W.copy()
    broken.indices[0] = 17
    assert "W is not a sound sparse matrix" in refusal(W=broken, u_free=b, mu=[1])


def test_wrong_types_are_refused_by_name():
    W, b = sparse.eye(2), [-1.0, 0]
    assert "u_free has dtype complex128" in refusal(TypeError, W=W, u_free=[1j, 0], mu=[1])
    assert "W has dtype complex128" in refusal(TypeError, W=W * 1j, u_free=b, mu=[1])
    assert "mu has dtype <U3" in refusal(TypeError, W=W, u_free=b, mu=["big"])
    assert "W has dtype object" in refusal(
        TypeError, W=np.array([[None, 1], [1, 1]]), u_free=b, mu=[1]
    )
    message = refusal(TypeError, W=W, ufree=b, mu=[1])
    assert "unknown option 'ufree'; did you mean 'u_free'?" in message
    for name, meant in (("friction", "mu"), ("jacobian", "J"), ("mass_matrix", "A")):
        message = refusal(TypeError, **{"W": W, "u_free": b, "mu": [1], name: 1})
        assert message.startswith(f"unknown option '{name}'; did you mean '{meant}'?")
    refused(TypeError, "expected keywords: Problem", bipot.Problem, W, b, [1])
    assert "u_free: setting an array element" in refusal(W=W, u_free=[[1, 2], [3]], mu=[1])


def test_masked_entries_are_refused():
    W, b = np.eye(2), np.array([-1.0, 0])
    hidden = np.ma.array(b, mask=[True, False])
    assert refusal(W=W, u_free=hidden, mu=[1]) == "u_free has masked entries: give a number for each"
    assert "W has masked" in refusal(W=np.ma.masked_equal(W, 0), u_free=b, mu=[1])
    rows = [np.ma.array([1.0, 0.0], mask=[0, 1]), [0.0, 1.0]]
    assert "W has masked" in refusal(W=rows, u_free=b, mu=[1])
    with pytest.raises(ValueError, match="s has masked"):
        bipot.judge(one_contact(-1, 0), np.ma.array([1.0, 0.0], mask=True))
    whole = bipot.Problem(W=W, u_free=np.ma.array(b, mask=False), mu=[1])
    assert np.array_equal(whole.u_free, b)


def test_no_object_exists_without_its_data():
    p = one_contact(-1, 0)
    refused(ValueError, "neither W nor", bipot.Problem.__new__, bipot.Problem)
    r, v = bipot.solve(p), bipot.judge(p, [1, 0])
    sim = bipot.Simulation("sliding_cylinder")
    for thing in (r, v, sim.advance(), sim.state, sim._native):
        refused(TypeError, "is made by the functions of bipot", type(thing).__new__, type(thing))
        with pytest.raises(TypeError):
            type(thing)()
    p.__init__(W=np.eye(4), u_free=[0, 0, 0, 0], mu=[1, 1])  # a second one changes nothing
    assert p.num_contacts == 1
    refused(TypeError, "not an acceptable base type", type, "Mine", (bipot.Problem,), {})


def test_a_pickled_array_file_is_refused(tmp_path):
    np.save(tmp_path / "p.npy", np.array([{}], dtype=object), allow_pickle=True)
    refused(ValueError, "p.npy", bipot.read, tmp_path / "p.npy")


def test_a_jacobian_is_the_transpose(lattice):
    """J = H^T with M = A, as robots have them: J is m x n."""
    p = lattice
    for J in (p.H.T, p.H.T.toarray(), p.H.T.tocoo()):
        q = bipot.Problem(M=p.A, J=J, v_free=p.v_free, u_free=p.u_free, mu=p.mu)
        same(q.H, p.H)
        same(q.A, p.A)
    H, v = np.arange(12.0).reshape(6, 2) + 1, np.zeros(6)
    assert refusal(A=np.eye(6), H=H.T, v_free=v, mu=[0.5]) == (
        "H is 2 x 6, expected 6 x m; did you pass J = H^T? Give it as J="
    )
    assert refusal(M=np.eye(6), J=H, v_free=v, mu=[0.5]) == (
        "J is 6 x 2, expected m x 6; did you pass H = J^T? Give it as H="
    )
    assert bipot.Problem(M=np.eye(6), J=H.T, v_free=v, mu=[0.5]).num_rows == 2
    assert "give H or J, not both" in refusal(A=np.eye(6), H=H, J=H.T, v_free=v, mu=[0.5])
    assert "give A or M, not both" in refusal(A=np.eye(6), M=np.eye(6), H=H, v_free=v, mu=[0.5])


def test_a_ball_bounces_with_friction():
    """1 kg meets the ground with (-1, 0.5) m/s, e_n = 0.8, mu = 0.1, not turning. u_n after is
    0.8, so s_n = 1.8; friction slips with s_t = -0.18, and u_t after is 0.5 - 0.18 = 0.32."""
    u = np.array([-1, 0.5])
    by_bodies = dict(A=np.eye(2), H=np.eye(2), v_free=u, v_before=u)
    by_contacts = dict(W=np.eye(2), u_free=u, u_before=u)
    for given in (by_bodies, by_contacts):
        for e in (0.8, [0.8], [0.8, 0.0]):
            p = bipot.Problem(**given, mu=[0.1], restitution=e)
            r = bipot.solve(p, tol=1e-12)
            assert np.allclose(r.impulse, [1.8, -0.18], atol=1e-9)
            assert np.allclose(p.row_scale, [1.8**0.5, 1])
            after = p.row_scale * r.u - np.array([0.8, 0]) * u  # r' u' is (1 + e) times the mean
            assert np.allclose(after, [0.8, 0.32], atol=1e-9)
            if r.v is not None:
                assert np.allclose(r.v, [0.8, 0.32], atol=1e-9)
    # Twice as fast: all is twice as much. With e = 0 the ball stays.
    fast = p.update(u_free=2 * u, u_before=2 * u)
    assert np.allclose(bipot.solve(fast, tol=1e-12).impulse, [3.6, -0.36], atol=1e-9)
    dead = bipot.Problem(**by_bodies, mu=[0.1], restitution=0)
    assert np.allclose(bipot.solve(dead, tol=1e-12).v, [0, 0.4], atol=1e-9)
    # A bouncing sphere of d = 3 and friction that is scaled back: mu 0.3 after an update.
    rough = bipot.Problem(W=np.eye(3), u_free=[-1, 0.3, 0.4], u_before=[-1, 0.3, 0.4], mu=[0.1],
                          restitution=0.8).update(mu=0.2)
    assert np.allclose(bipot.solve(rough, tol=1e-12).impulse, [1.8, -0.216, -0.288], atol=1e-9)


def test_problems_of_files_and_steps_have_their_restitution(tmp_path):
    """A ball hits the floor at 1 m/s, then at 2 m/s: it leaves with half of that."""
    v = np.array([-1.0, 0.2])
    given = dict(A=np.eye(2), H=np.eye(2), v_free=v, mu=[0.5], v_before=v, e=0.5)
    bipot.write(bipot.Problem(**given), tmp_path / "ball.hdf5")
    read = bipot.read(tmp_path / "ball.hdf5")
    for p in (bipot.Problem(**given), read):
        assert bipot.solve(p.update(v_free=2 * v, v_before=2 * v), tol=1e-12).v[0] == pytest.approx(1)
        refused(ValueError, "needs the velocities before", p.update, v_free=2 * v)
    rigid = bipot.Problem(A=np.eye(2), H=np.eye(2), v_free=v, mu=[0.5], v_before=None)
    refused(ValueError, "without restitution", rigid.update, v_free=v, v_before=v)
    assert rigid.update(v_free=v, v_before=None).u_free[0] == -1


def test_bodies_that_touch_nothing_keep_their_velocities():
    p = bipot.Problem(A=np.eye(3), J=np.zeros((0, 3)), v_free=[1, 2, 3], mu=[], dim=3)
    assert p.A.shape == (3, 3) and p.H.shape == (3, 0)
    assert np.array_equal(bipot.solve(p).v, [1, 2, 3])
    assert np.array_equal(p.body_velocity([]), [1, 2, 3])
    assert np.array_equal(bipot.solve(p.update(v_free=[4, 5, 6])).v, [4, 5, 6])
    held = bipot.Problem(A=np.eye(3), J=np.zeros((0, 3)), v_free=[1, 2, 3], mu=[], dim=3,
                         G=[[1, 0, 0]], b=[0])
    assert bipot.solve(held).v == pytest.approx([0, 2, 3])


def test_a_file_stays_where_writing_is_refused(tmp_path):
    path = tmp_path / "kept.hdf5"
    bipot.write(one_contact(-1, 0), path, s=[1, 0], guesses=[[1, 0]])
    before = path.read_bytes()
    other = one_contact(-2, 0)
    refused(ValueError, "s is not finite", bipot.write, other, path, s=[np.nan, 0])
    refused(ValueError, "guesses is not finite", bipot.write, other, path, guesses=[[np.inf, 0]])
    refused(ValueError, "guesses has size 3", bipot.write, other, path, guesses=[[1, 0, 0]])
    huge = bipot.Problem(W=1e200 * np.eye(2), u_free=[-1, 0], mu=[0.5])
    refused(OSError, "not finite", bipot.write, huge, path, s=[1e200, 0])
    assert path.read_bytes() == before
    refused(ValueError, "s is not finite", other.velocity, [np.nan, 0])


def test_restitution_that_is_not_whole_is_refused():
    W, u = np.eye(2), [-1.0, 0.5]
    given = dict(W=W, u_free=u, mu=[0.1])
    assert "needs the velocities before the impact" in refusal(**given, restitution=0.8)
    assert "expected numbers from 0 to 1" in refusal(**given, restitution=1.5, u_before=u)
    assert "restitution has size 3, expected 1, 1 or 2" in refusal(
        **given, restitution=[0, 0, 0], u_before=u
    )
    assert "u_before has size 1, expected 2" in refusal(**given, restitution=0.8, u_before=[1])
    assert "without restitution" in refusal(**given, u_before=u)
    assert "row_scale is given with restitution" in refusal(
        **given, restitution=0.8, u_before=u, row_scale=[1, 1]
    )
    assert "give v_before or u_before, not both" in refusal(
        **given, restitution=0.8, u_before=u, v_before=u
    )
    p = bipot.Problem(**given, restitution=0.8, u_before=u)
    refused(ValueError, "needs the velocities before", p.update, u_free=u)


def test_indices_beyond_32_bits_are_refused():
    W = sparse.csr_matrix((2**31, 2))
    assert "at most 2147483647 of each can be stored" in refusal(W=W, u_free=[0, 0], mu=[1])


def test_a_general_mass_matrix_is_taken():
    """Velocities v = T w of other coordinates w: the masses T^T A T are coupled, W is the same."""
    p = bipot.read(DATA / "problems" / "2d_sliding_cylinder.hdf5")
    T = sparse.eye(p.num_dofs).tolil()
    T[:2, :2] = [[1, 0.3], [-0.2, 2]]
    T = T.tocsc()
    q = rebuilt(p, A=T.T @ p.A @ T, H=T.T @ p.H, v_free=np.linalg.solve(T.toarray(), p.v_free))
    assert q.W is not None
    assert np.allclose(q.W.toarray(), p.delassus().toarray(), rtol=1e-12)
    a, b = bipot.solve(p, tol=1e-10), bipot.solve(q, tol=1e-10)
    assert np.allclose(T @ b.v, a.v, atol=1e-10)


def test_files_come_back_bit_for_bit(tmp_path, lattice, spheres):
    for p in (lattice, spheres, chain(3), one_contact(-1, 0.8, dim=3)):
        path = tmp_path / "problem.hdf5"
        r = bipot.solve(p, tol=1e-9)
        bipot.write(p, path, s=r.s, title="a title", guesses=[0.5 * r.s])
        q = bipot.read(path)
        assert q.name == "problem" and q.dim == p.dim
        assert np.array_equal(q.mu, p.mu)
        if p.A is None:
            same(q.W, p.W)
            assert np.array_equal(q.u_free, p.u_free)
        else:
            same(q.A, p.A)
            same(q.H, p.H)
            assert np.allclose(q.u_free, p.u_free, atol=1e-14)  # the file has f = A v
        assert np.array_equal(q.solution, r.s)
        assert len(q.guesses) == 1 and np.array_equal(q.guesses[0], 0.5 * r.s)
        assert bipot.judge(q, q.solution).within(1e-8)


def test_frictionless_problems_come_back(tmp_path):
    p = bipot.Problem(W=sparse.eye(3), u_free=[-1, 2, -3], mu=[0, 0, 0])
    bipot.write(p, tmp_path / "p.hdf5")
    q = bipot.read(tmp_path / "p.hdf5")
    assert q.dim == 1
    assert np.array_equal(bipot.solve(q).s, [1, 0, 3])


def test_siconos_text_is_read(tmp_path):
    path = tmp_path / "problem.dat"
    path.write_text("2\n1\n0\n2\n2\n2 2\n5 0\n0 6\n-1 0.5\n0.3\n")
    p = bipot.read(path)
    assert np.array_equal(p.W.toarray(), [[5, 0], [0, 6]])
    assert np.array_equal(p.mu, [0.3])


def test_files_that_are_no_problems_are_refused(tmp_path):
    refused(FileNotFoundError, "no such file", bipot.read, tmp_path / "nothing.hdf5")
    (tmp_path / "text.dat").write_text("not a problem")
    refused(ValueError, "line 1", bipot.read, tmp_path / "text.dat")
    with pytest.raises(OSError):
        bipot.write(chain(2), "/proc/nowhere/p.hdf5")
    with pytest.raises(ValueError, match="s has size 1, expected 4"):
        bipot.write(chain(2), tmp_path / "p.hdf5", s=[1])
    with pytest.raises(TypeError, match="did you mean 'title'"):
        bipot.write(chain(2), tmp_path / "p.hdf5", tittle="x")


# Eigenvalues 3 and -1: with it a false impulse of 2.4e8 N s was "converged".
def test_an_indefinite_w_is_refused_or_flagged():
    data = dict(W=[[1, 2], [2, 1]], u_free=[-1, 0.75], mu=[0.5])
    refused(ValueError, "not positive semidefinite.*accept_indefinite", bipot.Problem, **data)
    problem = bipot.Problem(**data, accept_indefinite=True)
    result = bipot.solve(problem)
    assert "not positive semidefinite" in result.message
    verdict = bipot.judge(problem, [1, 0])
    assert verdict.sentence(1e-8).startswith("W is not positive semidefinite")
    assert "not positive semidefinite" in repr(verdict)


def test_w_is_compared_with_a_and_h():
    with pytest.raises(ValueError, match="W is not that of A and H"):
        bipot.Problem(
            A=[[2.0, 0], [0, 2.0]], H=[[1.0, 0], [0, 1.0]], W=[[0.7, 0], [0, 0.5]],
            v_free=[-1.0, 0], mu=[0.5])


def pendulum(**changes):
    """A rod of 2 kg and 3 m at a pin leans on a plane at rest, for a step of 1 ms: s_n = m g h / 2,
    and the pin carries as much (as Rod.* in tests/solvers/analytic_test.cc)."""
    x, y = 1.5 * np.cos(0.7), -1.5 * np.sin(0.7)
    arguments = dict(
        A=np.diag([2, 2, 1.5]), H=[[0, -1], [1, 0], [x, y]], v_free=[0, -9.81e-3, 0], mu=[0],
        G=[[1, 0, y], [0, 1, -x]],
    )
    return bipot.Problem(**{**arguments, **changes})


def test_equality_rows_are_obeyed_and_their_impulses_given():
    p = pendulum()
    r = bipot.solve(p, tol=1e-12)
    assert r and r.s == pytest.approx([9.81e-3, 0], abs=1e-12)
    assert r.v == pytest.approx(np.zeros(3), abs=1e-14)
    assert r.multipliers == pytest.approx([0, 9.81e-3], abs=1e-12)
    assert r.equality_residual < 1e-15
    assert p.num_dofs == 3 and p.A.shape == (3, 3) and (p.b == 0).all() and p.G.shape == (2, 3)
    assert p.u_free == pytest.approx(p.velocity([0, 0]))
    assert bipot.judge(p, r.s).within(1e-10)
    assert bipot.compare(p, solvers=["pgs", "ipm"], tols=[1e-8])["status"] == ["converged"] * 2


def test_equality_rows_stay_with_the_problem(tmp_path):
    p = pendulum(b=[0.1, 0.2])
    moving = bipot.solve(p, tol=1e-12)
    assert p.G @ moving.v == pytest.approx([0.1, 0.2])
    bipot.write(p, tmp_path / "p.hdf5", s=moving.s)
    for same_one in [bipot.read(tmp_path / "p.hdf5"), pickle.loads(pickle.dumps(p)), pendulum().update(b=[0.1, 0.2])]:
        again = bipot.solve(same_one, tol=1e-12)
        assert again.v == pytest.approx(moving.v, abs=1e-12)
        assert again.multipliers == pytest.approx(moving.multipliers, abs=1e-12)
    heavier = bipot.solve(p.update(v_free=[0, -2 * 9.81e-3, 0], b=[0, 0]), tol=1e-12)
    assert heavier.s[0] == pytest.approx(2 * 9.81e-3)


def test_equality_rows_with_restitution_leave_the_plane_as_newton_says():
    # It turns down at 0.4 rad/s and comes back with half of that: (1 + e) times the stopping blow.
    x, y = 1.5 * np.cos(0.7), -1.5 * np.sin(0.7)
    before = -0.4 * np.array([-y, x, 1])
    r = bipot.solve(pendulum(v_free=before, v_before=before, restitution=0.5), tol=1e-12)
    assert r.v == pytest.approx(-0.5 * before)
    assert r.impulse[0] == pytest.approx(1.5 * 2 * 3 * 0.4 / (3 * np.cos(0.7)))


def test_equality_rows_that_do_not_fit_are_refused():
    for changes, words in [
        ({"G": [[1, 0]]}, "G is 1 x 2 and b has size 1, expected p x 3 and p"),
        ({"b": [1]}, "G is 2 x 3 and b has size 1"),
        ({"G": None, "b": [1]}, "b is given without G; u at s = 0 is u_free"),
        ({"W": np.eye(2)}, "W is given with G"),
        ({"G": [[0, 1, 0], [0, 2, 0]], "b": [0, 1]}, "of G contradicts other rows"),
        ({"G": np.eye(3)}, "contact 0: the equality rows leave no motion along its normal"),
    ]:
        refused(ValueError, re.escape(words), pendulum, **changes)
    refused(ValueError, "b is given without G", one_contact(-1, 0).update, b=[1])


def test_compliance_is_taken_kept_and_refused():
    # A block of mass 2 falls with 1 m/s and slides with 0.4: W = 1/2, R = (1/2, 3/2) give s_n = 1,
    # s_t = -0.2, and the block itself moves with -R s.
    data = dict(v_free=[-1, 0.4], mu=[0.5])
    p = bipot.Problem(A=2 * np.eye(2), H=np.eye(2), R=[0.5, 1.5], **data)
    r = bipot.solve(p, tol=1e-11)
    np.testing.assert_allclose(r.s, [1, -0.2], atol=1e-9)
    np.testing.assert_allclose(r.v[:2], [-0.5, 0.3], atol=1e-9)
    np.testing.assert_allclose(p.delassus().toarray(), np.diag([1, 2]), atol=1e-14)
    for same in (
        bipot.Problem(W=np.eye(2) / 2, R=np.diag([0.5, 1.5]), u_free=[-1, 0.4], mu=[0.5]),
        bipot.Problem(W=np.eye(2) / 2, R=sparse.diags([0.5, 1.5]), u_free=[-1, 0.4], mu=[0.5]),
        pickle.loads(pickle.dumps(p)),
    ):
        np.testing.assert_allclose(bipot.solve(same, tol=1e-11).s, r.s, atol=1e-9)
    slower = p.update(v_free=[-0.5, 0.2, 0, 0])
    np.testing.assert_allclose(bipot.solve(slower, tol=1e-11).s, r.s / 2, atol=1e-9)
    both = dict(A=2 * np.eye(2), H=np.eye(2), **data)
    shock = [bipot.Problem(R=[0.5, 1.5], e=0.5, **{name: [-1, 0.4]}, **both) for name in ("v_before", "u_before")]
    np.testing.assert_array_equal(shock[0].u_free, shock[1].u_free)
    assert "R of contact 0 is not symmetric and positive" in refusal(R=[-1, 0], **both)
    assert "R is 3 x 3, expected 2 x 2" in refusal(R=[1, 1, 1], **both)
    assert "R is given with G" in refusal(R=[1, 1], G=[[1, 0]], **both)


def test_rolling_friction_is_taken_kept_and_refused():
    # One body of mass 2 and inertia 0.5 on a fixed partner below, arm 0.5: s_n = 2 stops it,
    # m = -mu_r s_n, and s_t = m keeps it from sliding (tests/solvers/rolling_test.cc).
    H = np.array([[0, -1, 0], [1, 0, 0], [0, -0.5, 1.0]])
    data = dict(A=np.diag([2, 2, 0.5]), H=H, v_free=[-0.5, -1, 1], mu=[0.5])
    p = bipot.Problem(mu_r=0.1, **data)
    r = bipot.solve(p, tol=1e-9)
    np.testing.assert_allclose(r.s, [2, -0.2, -0.2], atol=1e-7)
    np.testing.assert_allclose(r.u, [0, 0, 0.8], atol=1e-7)
    assert p.mu_r.tolist() == [0.1] and p.mu_spin is None and p.dim == 3
    q = pickle.loads(pickle.dumps(p))
    assert q.mu_r.tolist() == [0.1]
    assert bipot.Problem(**data).mu_r is None
    np.testing.assert_allclose(bipot.solve(p, solver="ipm", tol=1e-9).s, r.s, atol=1e-7)
    assert "mu_r" in refusal(mu_r=-1, **data)
    assert "mu_spin" in refusal(mu_r=1, mu_spin=1, **data)
