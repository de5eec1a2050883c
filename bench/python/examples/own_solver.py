"""A solver in ten lines of numpy: how good is its answer, and how does it stand beside the others?

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/own_solver.py [--quick] [--out DIR]
"""

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bipot


def gauss_seidel(problem, tol, callback):
    """Projected Gauss-Seidel for contacts of two rows, normal and tangent."""
    W, b, mu = problem.delassus(), problem.u_free, problem.mu
    rows = [W[k].toarray().ravel() for k in range(W.shape[0])]
    s = np.zeros(len(b))
    while not callback(s):  # judges s; True once the tolerance is met or the time is over
        for n, m in zip(range(0, len(b), 2), mu):
            t = n + 1
            s[n] = max(0, s[n] - (rows[n] @ s + b[n]) / rows[n][n])
            s[t] = np.clip(s[t] - (rows[t] @ s + b[t]) / rows[t][t], -m * s[n], m * s[n])
    return s


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)

    problem = bipot.problems("square:6:tilt=10" if flags.quick else "pile:6")[0]
    print(problem)

    # An answer of one's own, made in any way at all, and what is wrong with it.
    sweeps = iter(range(1_000_000))
    s = gauss_seidel(problem, 0, lambda s: next(sweeps) == 20)
    verdict = bipot.judge(problem, s)
    print("after 20 sweeps:", verdict.sentence(1e-3))
    for contact in verdict.worst:
        print(f"  {contact.share:6.1%}  {contact}")

    # Beside the built-in ones, judged alike.
    table = bipot.compare(
        problem,
        solvers=[gauss_seidel, "auto", "pgs", "apgd", "ipm"],
        tols=[1e-1, 1e-2, 1e-3] if flags.quick else [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6],
        time_limit=2 if flags.quick else 10,
    )
    print(table)
    figure, axes = plt.subplots(figsize=(6, 4), layout="constrained")
    for solver in dict.fromkeys(table["solver"]):
        mine = [k for k, name in enumerate(table["solver"]) if name == solver]
        met = [k for k in mine if table["guarded"][k] <= table["tol"][k]]
        axes.loglog(table["cpu_min"][met], table["velocity_error"][met], "o-", label=solver)
    axes.set(xlabel="CPU time (s)", ylabel="true error of the velocities", title=problem.name)
    axes.legend()
    figure.savefig(flags.out / "work_precision.svg")
    print("picture in", flags.out / "work_precision.svg")


if __name__ == "__main__":
    main()
