"""What a time step costs and buys: small scenes with equal steps, and with steps that an accuracy
cuts, against a run with accuracy 1e-5 or an exact answer.

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/error_against_steps.py [--quick] [--out DIR]
"""

import argparse
import math
import pathlib
import random

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import bipot

RADIUS = 0.01
FLOOR = {"point": [0, 0], "normal": [0, 1]}
LEFT = {"point": [0, 0], "normal": [1, 0]}
DOWN = [0, -9.81]


def disk(x, y, vx=0.0, vy=0.0, mass=1.0, radius=RADIUS):
    return {"position": [x, y], "velocity": [vx, vy], "radius": radius, "mass": mass}


def right(x):
    return {"point": [x, 0], "normal": [-1, 0]}


def ball(e):
    return {"gravity": DOWN, "contact": {"mu": 0, "e_n": e}, "walls": [FLOOR],
            "disks": [disk(0, 0.11)]}


def ball_height(time, e):
    fall, speed = math.sqrt(0.2 / 9.81), math.sqrt(0.2 * 9.81)
    left = time - fall
    while speed > 1e-12:
        speed *= e
        flight = 2 * speed / 9.81
        if left <= flight:
            return RADIUS + speed * left - 9.81 * left * left / 2
        left -= flight
    return RADIUS


def bowl(mu):
    angle = math.pi / 3
    return {"gravity": DOWN, "contact": {"mu": mu},
            "walls": [{"center": [0, 0], "radius": 0.1, "hollow": True}],
            "disks": [disk(0.09 * math.sin(angle), -0.09 * math.cos(angle))]}


def chain(draw):
    """Disks on a line between two walls."""
    x, disks = 0.0, []
    for k in range(6):
        x += 0.004 + 0.02 * draw.random() + 2 * RADIUS
        disks.append(disk(x - RADIUS, 0, 2 if k == 0 else draw.uniform(-1, 1), 0,
                          draw.uniform(0.5, 2)))
    return {"contact": {"mu": 0, "e_n": 0.8}, "disks": disks,
            "walls": [LEFT, right(x + 0.004 + 0.02 * draw.random())]}


def gas(draw):
    """Disks that fly in a box and lose nothing."""
    disks = [disk(0.03 + 0.05 * (k % 6), 0.03 + 0.05 * (k // 6), draw.uniform(-1, 1),
                  draw.uniform(-1, 1)) for k in range(30)]
    return {"contact": {"mu": 0, "e_n": 1}, "disks": disks,
            "walls": [FLOOR, LEFT, right(0.31), {"point": [0, 0.26], "normal": [0, -1]}]}


def row():
    """A disk hits a row of five that touch each other on a table."""
    return {"gravity": DOWN, "contact": {"mu": 0.3}, "walls": [FLOOR],
            "disks": [disk(0.03 + 2 * RADIUS * k, RADIUS) for k in range(5)] +
                     [disk(-0.02, RADIUS, 0.5)]}


def pour(draw):
    """Twenty disks fall into a box."""
    cell = 2.6 * RADIUS
    disks = []
    for k in range(20):
        radius = RADIUS * draw.uniform(0.8, 1.2)
        x = (k % 3 + 0.5) * cell + draw.uniform(-5e-4, 5e-4)
        disks.append(disk(x, (k // 3 + 0.6) * cell, mass=1000 * math.pi * radius**2,
                          radius=radius))
    return {"gravity": DOWN, "contact": {"mu": 0.3}, "disks": disks,
            "walls": [FLOOR, LEFT, right(3 * cell)]}


def plate():
    """A driven wall closes on three disks that stand apart from each other."""
    return {"gravity": [0, 0], "contact": {"mu": 0, "e_n": 0.5},
            "disks": [disk(0.03 + 0.03 * k, 0) for k in range(3)],
            "walls": [{"point": [0, 0], "normal": [1, 0], "force": 4.0, "mass": 2.0}]}


# Name, scene, time [s], exact place of the first disk or None.
SCENES = [("ball, e = 0.9", ball(0.9), 0.65, (0, ball_height(0.65, 0.9))),
          ("ball, e = 0.5: comes to rest", ball(0.5), 0.65, (0, ball_height(0.65, 0.5))),
          ("chain of 6", chain(random.Random(3)), 0.15, None),
          ("gas of 30", gas(random.Random(1)), 0.15, None),
          ("disk hits a row of 5", row(), 0.35, None),
          ("20 disks poured", pour(random.Random(1)), 0.12, None),
          ("disk slides in a bowl", bowl(0.0), 1.0, None),
          ("disk rolls in a bowl", bowl(5.0), 1.0, None),
          ("driven wall hits 3 disks", plate(), 0.3, None)]
FRAMES = 4  # steps of a run that are cut


def run(scene, time, steps, accuracy=0.0):
    """Places at the end [m], steps or parts that were taken, largest overlap [radii]."""
    scene = dict(scene, time={"step": time / steps, "steps": steps, "accuracy": accuracy},
                 solver={"tol": 1e-12})
    sim = bipot.Simulation(scene)
    parts, overlap = 0, 0.0
    for step in sim:
        parts += step.parts or 1
        overlap = max(overlap, step.penetration / RADIUS)
    return np.array(sim.state.positions), parts, overlap


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)
    settings = [(400, 0), (1600, 0)] + [(FRAMES, x) for x in (1e-1, 1e-2, 1e-3)]
    if flags.quick:
        settings = [(400, 0), (FRAMES, 1e-2)]
    print("|scene|setting|steps or parts|error [radii]|overlap [radii]|\n|---|---|---|---|---|")
    figure, charts = plt.subplots(3, 3, figsize=(11, 9), layout="constrained")
    for chart, (name, scene, time, exact) in zip(charts.flat, SCENES):
        points = {}
        if exact is None:
            reference = run(scene, time, 16 * FRAMES, 1e-4 if flags.quick else 1e-5)[0]
        else:
            reference = np.array([exact])
        for steps, accuracy in settings:
            places, parts, overlap = run(scene, time, steps, accuracy)
            error = np.linalg.norm(places - reference, axis=1).max() / RADIUS
            setting = f"accuracy {accuracy:g}" if accuracy else "equal steps"
            print(f"|{name}|{setting}|{parts}|{error:.1e}|{overlap:.1e}|")
            points.setdefault(setting.split()[0], []).append((parts, max(error, 1e-16)))
        for kind, marker in (("equal", "s-"), ("accuracy", "o-")):
            chart.loglog(*zip(*points[kind]), marker, label=kind)
        chart.set(title=name, xlabel="steps or parts", ylabel="error (radii)")
    charts[0, 0].legend()
    figure.savefig(flags.out / "error_against_steps.svg")
    print("picture in", flags.out / "error_against_steps.svg")


if __name__ == "__main__":
    main()
