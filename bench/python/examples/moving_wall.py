"""A box of disks whose side wall moves as Python decides: it presses until the force on it is what
was asked for, then holds it.

    export PYTHONPATH=build/release/python
    python3 bench/python/examples/moving_wall.py [--quick] [--out DIR]
"""

import argparse
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import bipot

SCENE = """
title = "Disks beside a wall that moves"
gravity = [0.0, -9.81]

[contact]
mu = 0.3

[[disks]]
arrangement = "triangular"
columns = 8
rows = 6
radius = 0.01
density = 2000.0

[[walls]]
name = "floor"
point = [0.0, 0.0]
normal = [0.0, 1.0]

[[walls]]
name = "left"
point = [0.0, 0.0]
normal = [1.0, 0.0]

[[walls]]
name = "right"
point = [0.162, 0.0]
normal = [-1.0, 0.0]
velocity = [0.0, 0.0]

[time]
step = 5e-4
steps = 600

[solver]
tol = 1e-6
"""

WANTED = 40.0  # force on the wall [N]


def force_on(step, wall):
    """Normal force of the disks on a wall, averaged over the step [N]."""
    contacts = step.contacts
    against = contacts["j"] == len(step.radii) + wall
    return contacts["s_n"][against].sum()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/python"))
    flags = parser.parse_args()
    flags.out.mkdir(parents=True, exist_ok=True)
    scene = flags.out / "moving_wall.toml"
    scene.write_text(SCENE)

    sim = bipot.Simulation(scene, num_steps=150 if flags.quick else 600)
    right = next(k for k, wall in enumerate(sim.walls) if wall["name"] == "right")
    times, forces, places = [], [], []
    smooth = 0.0
    for step in sim:
        smooth += 0.1 * (force_on(step, right) / sim.step_size - smooth)  # shocks are short
        times.append(step.time)
        forces.append(smooth)
        places.append(step.walls[right]["a"][0])
        # Inwards as long as the force is too small, slower the nearer it is.
        speed = 0.05 * max(-1.0, min(1.0, 1 - smooth / WANTED))
        sim.set_wall("right", velocity=(-speed, 0))
    print(f"{sim.steps_done} steps, wall at {places[-1]:.4f} m, force {forces[-1]:.1f} N")
    print(f"work of the wall {step.energy['wall_work']:.3e} J, "
          f"energy unaccounted for in the last step {step.energy['imbalance']:.1e} J")

    figure, (above, below) = plt.subplots(2, sharex=True, figsize=(6, 5), layout="constrained")
    above.plot(times, forces)
    above.axhline(WANTED, color="grey", linestyle="--")
    above.set(ylabel="force on the wall (N)")
    below.plot(times, places)
    below.set(xlabel="time (s)", ylabel="place of the wall (m)")
    figure.savefig(flags.out / "moving_wall.svg")
    print("picture in", flags.out / "moving_wall.svg")


if __name__ == "__main__":
    main()
