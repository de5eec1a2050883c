"""Array-likes of Python as plain float64 and int32 arrays, checked.

numpy and scipy are imported where they are needed: `import bipot` works in an interpreter that
lacks them.
"""

_LARGEST = 2**31 - 1  # indices are 32-bit integers


def vector(given, name):
    """One dimension of float64, contiguous."""
    import numpy as np

    array = np.asarray(given)
    _require_real(array.dtype, name)
    if array.ndim != 1:
        raise ValueError(f"{name} has shape {array.shape}, expected one dimension")
    return np.ascontiguousarray(array, dtype=np.float64)


def matrix(given, name, form):
    """(rows, columns, indptr, indices, data) of compressed rows ("csr") or columns ("csc"),
    without duplicates or explicit zeros, indices sorted."""
    import numpy as np
    import scipy.sparse as sparse

    if not sparse.issparse(given):
        given = np.asarray(given)
        if given.ndim != 2:
            raise ValueError(f"{name} has shape {given.shape}, expected a matrix")
        _require_real(given.dtype, name)
        given = sparse.csr_matrix(given)
    _require_real(given.dtype, name)
    if max(*given.shape, given.nnz) > _LARGEST:
        raise ValueError(
            f"{name} is {given.shape[0]} x {given.shape[1]} with {given.nnz} entries, "
            f"at most {_LARGEST} of each can be stored"
        )
    if given.format in ("csr", "csc"):
        try:
            given.check_format(full_check=True)
        except ValueError as error:
            raise ValueError(f"{name} is not a sound sparse matrix: {error}") from None
    if given.format in ("lil", "dok"):
        given = given.tocoo()
    made = given.copy()
    made.data = made.data.astype(np.float64)  # astype() sums duplicates first, in eight bits
    made = made.asformat(form)
    if not made.has_canonical_format or (made.data == 0).any():
        made = made.copy()
        made.sum_duplicates()
        made.eliminate_zeros()
    return (
        *made.shape,
        made.indptr.astype(np.int32, copy=False),
        made.indices.astype(np.int32, copy=False),
        made.data,
    )


def _require_real(dtype, name):
    if dtype.kind not in "fiub":
        raise TypeError(f"{name} has dtype {dtype}, expected real numbers")
