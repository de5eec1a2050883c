"""A cannon-ball pyramid on a floor: the load under its base against friction.

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/friction_sweep.py [--quick] [--out DIR]
"""

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bipot


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)

    rows = 8 if flags.quick else 12
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for mu in [0.1, 0.3, 0.8] if flags.quick else [0.05, 0.1, 0.2, 0.3, 0.5, 0.8]:
        problem = bipot.problems(f"pyramid:{rows}:mu={mu}")[0]
        result = bipot.solve(problem, tol=1e-8)
        # Contacts are sorted by their first disk: of the lowest row, each has one with the floor. H
        # says which: a column of one body, pointing up.
        H = problem.H[:, :: problem.dim].tocsc()
        bodies = np.diff(H.indptr)
        up = np.asarray(H.sum(axis=0)).ravel()
        floor = (bodies <= bodies.min()) & (up > 0.99)
        load = result.s[:: problem.dim][floor]
        print(
            f"mu = {mu:4}: {result.status}, error {result.guarded:.1e}, {result.slip} of "
            f"{problem.num_contacts} contacts slip, base load from {load.min():.3f} to "
            f"{load.max():.3f} N s, {load.sum():.3f} in all"
        )
        if not result.converged:
            continue
        axes.plot(np.linspace(-1, 1, len(load)), load / load.mean(), ".-", label=f"μ = {mu}")
    axes.set(xlabel="place along the base", ylabel="load / mean load",
             title=f"Pyramid of {rows} rows, first step from rest")
    axes.legend()
    figure.savefig(flags.out / "base_load.svg")
    print("picture in", flags.out / "base_load.svg")


if __name__ == "__main__":
    main()
