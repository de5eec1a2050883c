"""A solver on everybody's leaderboard: scipy's L-BFGS-B on disks, with the bounds of friction held.

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/submit_solver.py [--quick] [--problems DIR] [--out DIR]

Writes one impulse for each problem, and times.csv, into a folder of its own: that is a submission.
`bipot leaderboard` judges it beside the best impulses that are known.
"""

import argparse
import os
import pathlib
import subprocess
import time

import numpy as np
from scipy.optimize import minimize

import bipot

ROOT = pathlib.Path(__file__).resolve().parents[3]
PROGRAM = os.environ.get("BIPOT_COMMAND", ROOT / "build/release/bipot")


def solve(problem, rounds):
    """min ½ s·W s + s·u_free with s_n >= 0 and |s_t| <= mu s_n of the round before (d <= 2)."""
    W, b, mu, d = problem.delassus(), problem.u_free, problem.mu, problem.dim
    scale = 1 / np.sqrt(W.diagonal())  # of the variables: their diagonal is 1
    s = np.zeros(len(b))
    for _ in range(rounds):
        bound = np.full(len(b), np.inf)
        if d == 2:
            bound[1::2] = mu * s[::2] / scale[1::2]
        lower = np.where(np.arange(len(b)) % d == 0, 0, -bound)
        s = scale * minimize(
            lambda x: (0.5 * x @ (scale * (W @ (scale * x))) + x @ (scale * b), scale * (W @ (scale * x) + b)),
            np.clip(s / scale, lower, bound), jac=True, method="L-BFGS-B",
            bounds=np.column_stack([lower, bound]), options={"maxiter": 2000, "maxfun": 4000, "ftol": 0, "gtol": 1e-12},
        ).x
        if d == 1 or bipot.judge(problem, s).within(1e-9):
            break
    return s


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--problems", type=pathlib.Path, default=ROOT / "data/collection")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    files = sorted(flags.problems.glob("*.hdf5"))
    files = [f for f in files if "pyramid_3" in f.name or "1d_square_4" in f.name] if flags.quick else files
    mine = flags.out / "scipy"
    mine.mkdir(parents=True, exist_ok=True)
    with open(mine / "times.csv", "w") as times:
        times.write("problem,seconds\n")
        for file in files:
            problem = bipot.read(file)
            if problem.dim > 2 or problem.num_contacts > 500 or problem.mu_r is not None:
                continue  # "no impulse" on the page
            begin = time.process_time()
            s = solve(problem, 10 if flags.quick else 40)
            times.write(f"{file.stem},{time.process_time() - begin:.4g}\n")
            np.save(mine / f"{file.stem}.npy", s)
    known = [] if flags.quick else [flags.problems]
    subprocess.run([PROGRAM, "leaderboard", mine, *known, "--problems", ",".join(map(str, files)),
                    "--solvers", "auto", "--time-limit", "2", "--out", flags.out], check=True)


if __name__ == "__main__":
    main()
