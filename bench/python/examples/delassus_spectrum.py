"""The Delassus operator W = H^T A^-1 H in scipy: how singular is it, and how does that grow?

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/delassus_spectrum.py [--quick] [--out DIR]
"""

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import scipy.sparse.linalg

import bipot


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)

    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for side in [4, 8] if flags.quick else [4, 8, 16]:
        problem = bipot.problems(f"triangular:{side}")[0]
        W = problem.delassus()  # scipy.sparse.csr_matrix
        largest = scipy.sparse.linalg.eigsh(W, k=1, return_eigenvectors=False)[0]
        spectrum = np.linalg.eigvalsh(W.toarray())[::-1]
        rank = (spectrum > 1e-12 * spectrum[0]).sum()
        m, n = problem.num_rows, problem.num_dofs
        print(
            f"{side:3} rows of disks: {m} rows of W, {n} degrees of freedom, rank {rank}; "
            f"largest eigenvalue {largest:.4g} = {spectrum[0]:.4g} 1/kg, "
            f"smallest positive one {spectrum[rank - 1]:.3g} 1/kg"
        )
        relative = np.maximum(spectrum / spectrum[0], 1e-17)  # round-off may be negative
        axes.semilogy(np.arange(m) / m, relative, label=f"{m} rows")
    axes.set(xlabel="share of the eigenvalues", ylabel="eigenvalue / largest",
             title="Triangular lattices: half of W is singular")
    axes.legend()
    figure.savefig(flags.out / "spectrum.svg")
    print("picture in", flags.out / "spectrum.svg")


if __name__ == "__main__":
    main()
