#!/usr/bin/env python3
"""Whole simulations with this tree beside those of another commit: disks of three radii poured into a box.

    bench/beside.py [--commit bf3d26a] [--disks 10000] [--steps 1000] [--limit 300] [--goal 1e-1]
                    [--step-size H] [--other BINARY] [--this BINARY] [--out out/beside]

Builds the other commit's `bipot` in OUT/COMMIT at low priority (once; or takes --other). The time step is what `bipot
advise --penetration GOAL` answers for the same pour of 300 disks, unless --step-size says it. One thread, tolerance
1e-3, `auto`. The other commit runs first, for LIMIT wall seconds at most; this tree then does as many steps (the rows
to compare), and at last all of them, within the same limit. Seconds are user CPU of the process; phases are wall
seconds as the program reports them, which other work on the machine stretches. Memory is the largest in use above
that of the same program on one disk. Markdown on standard output, rows.csv and the runs in OUT. Exits with 0, with 2
for what it was given, with 1 where a program failed.
"""

import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
PHASES = ("detection", "assembly", "solve", "output", "total")


def scene(disks, step, steps):
    """A box as wide as 100 disks for 10^4 of them, with the shape kept for other numbers."""
    width = max(2.0, disks**0.5)
    return f"""title = "Pour of {disks} disks"
gravity = [0.0, -9.81]

[contact]
mu = 0.3
e_n = 0.0
e_t = 0.0

[[disks]]
arrangement = "random"
count = {disks}
radii = [0.4, 0.5, 0.6]
width = {width:.6g}
spacing = 0.05
seed = 13
density = 1000.0

[[walls]]
point = [0.0, 0.0]
normal = [0.0, 1.0]

[[walls]]
point = [0.0, 0.0]
normal = [1.0, 0.0]

[[walls]]
point = [{width:.6g}, 0.0]
normal = [-1.0, 0.0]

[time]
step = {step}
steps = {steps}

[solver]
name = "auto"
tol = 1e-3

[output]
every = {steps}
picture = false
"""


def build(commit, folder):
    """The other commit's `bipot`, from a clone of this repository."""
    program = folder / "build/release/bipot"
    if not program.exists():
        subprocess.run(["git", "clone", "-q", ROOT, folder], check=True)
        subprocess.run(["git", "-C", folder, "checkout", "-q", commit], check=True)
        subprocess.run(["cmake", "--preset", "release"], cwd=folder, check=True, stdout=sys.stderr)
        subprocess.run(["nice", "-n", "10", "cmake", "--build", "build/release", "--target", "bipot"], cwd=folder,
                       check=True, stdout=sys.stderr)
    return program


def run(program, disks, step, steps, limit, out):
    """One run: its summary, user CPU seconds and largest memory [kB]."""
    out.mkdir(parents=True, exist_ok=True)
    toml = out / "scene.toml"
    toml.write_text(scene(disks, step, steps))
    process = subprocess.Popen(
        [program, "run", toml, "--time-limit", str(limit), "-q", "--out", out / "run", "--json", out / "summary.json"],
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    if code not in (0, 1, 5) or not (out / "summary.json").exists():
        sys.exit(f"{program} ended with {code}: {said.strip()}")
    return json.loads((out / "summary.json").read_text()), usage.ru_utime, usage.ru_maxrss


def advised_step(program, goal, out):
    """What advise answers for the pour of 300 disks, planned for 600 steps of 5 ms."""
    out.mkdir(parents=True, exist_ok=True)
    toml = out / "advise.toml"
    toml.write_text(scene(300, 0.005, 600))
    answer = subprocess.run([program, "advise", toml, "--penetration", str(goal), "--time-limit", "60", "-q", "--json",
                             "-"], capture_output=True, text=True)
    if answer.returncode not in (0, 1):
        sys.exit(f"advise ended with {answer.returncode}: {answer.stderr.strip()}")
    return json.loads(answer.stdout)["advice"]["step"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--commit", default="bf3d26a")
    parser.add_argument("--disks", type=int, default=10000)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--limit", type=float, default=300, help="wall seconds of one run")
    parser.add_argument("--goal", type=float, default=1e-1, help="overlap a step may add, for advise")
    parser.add_argument("--step-size", type=float, help="time step [s], not asked of advise")
    parser.add_argument("--other", type=pathlib.Path, help="the other commit's bipot, built already")
    parser.add_argument("--this", type=pathlib.Path, default=ROOT / "build/release/bipot")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/beside")
    flags = parser.parse_args()
    if flags.disks < 1 or flags.steps < 1 or not flags.limit > 0:
        parser.error("--disks, --steps and --limit must be positive")
    for program in (flags.this, flags.other):
        if program is not None and not program.exists():
            parser.error(f"{program} is not there: build it first")
    try:
        other = flags.other or build(flags.commit, flags.out / flags.commit)
    except subprocess.CalledProcessError as error:
        sys.exit(f"building {flags.commit}: {error}")
    step = flags.step_size or advised_step(flags.this, flags.goal, flags.out)

    rows = []

    def measure(name, program, steps):
        _, _, alone = run(program, 1, step, 1, flags.limit, flags.out / "one")
        summary, cpu, most = run(program, flags.disks, step, steps, flags.limit,
                                 flags.out / f"{name}_{flags.disks}_{steps}")
        done = summary["steps"]
        row = {"program": name, "disks": flags.disks, "step_s": step, "steps": done, "wanted": steps,
               "converged": summary["steps_converged"], "contacts_mean": summary["contacts_mean"],
               "contacts_max": summary["contacts_max"], "iterations_mean": summary["iterations_mean"], "cpu_s": cpu,
               **{phase: summary["seconds"][phase] for phase in PHASES},
               "bytes_a_disk": 1024 * (most - alone) / flags.disks}
        rows.append(row)
        if len(rows) == 1:
            print("| program | disks | h [s] | steps | converged | contacts, mean and most | iterations a step | CPU s |"
                  " wall s: " + ", ".join(PHASES) + " | bytes a disk |")
            print("|" + " --- |" * 10)
        print(f"| {name} | {flags.disks} | {step:g} | {done} of {steps} | {row['converged']} | "
              f"{row['contacts_mean']:.0f}, {row['contacts_max']} | {row['iterations_mean']:.0f} | {cpu:.1f} | "
              + ", ".join(f"{row[phase]:.2f}" for phase in PHASES) + f" | {row['bytes_a_disk']:.0f} |", flush=True)
        return done

    done = measure(flags.commit, other, flags.steps)
    measure("this tree", flags.this, done)
    print(f"\nequal steps: {rows[0]['cpu_s'] / rows[1]['cpu_s']:.2f} times less CPU, "
          f"{rows[0]['bytes_a_disk'] / rows[1]['bytes_a_disk']:.2f} times less memory\n", flush=True)
    if done < flags.steps:
        measure("this tree", flags.this, flags.steps)
    with open(flags.out / "rows.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
