#!/usr/bin/env python3
"""Makes data/collection: problems, best known impulses, proofs, index, checksums. Takes ten minutes of CPU.

    PYTHONPATH=build/release/python python3 data/make_collection.py [--only TEXT] [--out DIR]

Needs a release build, numpy and h5repack. A problem that is there is kept; --only takes those whose
name contains the text. Every scene, command and seed stands here and in index.csv.
"""

import argparse
import csv
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

import numpy as np

import bipot

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROGRAM = pathlib.Path(os.environ.get("BIPOT_COMMAND", ROOT / "build/release/bipot"))
SOLVERS = {1: ["auto", "ipm", "newton"], 2: ["auto", "ipm", "homotopy"], 3: ["auto", "ipm", "newton"]}
TARGET, TRUSTED = 1e-11, 1e-9  # asked of the best impulse; below it an impulse counts as a solution
MOST_ROWS_OF_RANK, MOST_CONTACTS_OF_SEVERAL, MOST_CONTACTS_OF_ALL = 1000, 300, 2500


def box(width, tilt_wall=True, e=0.0, mu=0.3):
    text = f"[contact]\nmu = {mu}\ne_n = {e}\n"
    for point, normal in (([0, 0], [0, 1]), ([0, 0], [1, 0]), ([width, 0], [-1, 0])):
        if normal == [0, 1] or tilt_wall:
            text += f"[[walls]]\npoint = {point}\nnormal = {normal}\n"
    return text


def filling(count, width, seed, radii="[0.4, 0.5, 0.6]", more=""):
    return (f'[[disks]]\narrangement = "random"\ncount = {count}\nradii = {radii}\nwidth = {width}\n'
            f"spacing = 0.05\ndensity = 1000\nseed = {seed}\n{more}")


def end(step, steps):
    return f'[time]\nstep = {step}\nsteps = {steps}\n[solver]\ntol = 1e-3\n[output]\nevery = 0\n'


def scenes():
    """(kind, name, text of a scene file, steps whose problems are kept)."""
    seed = 0
    for side in (5, 8, 12, 17):
        for mu, e in ((0.2, 0.0), (0.5, 0.3), (0.8, 0.0)):
            seed += 1
            steps = int(600 * (side / 32) ** 0.5)
            parts = [int(steps * x) for x in (0.5, 0.75, 1)]
            yield "moving", f"2d_pour_{side}_{seed}", (
                box(side, mu=mu, e=e) + filling(side * side, side, seed) + end(0.005, steps)), parts
            yield "moving", f"2d_collapse_{side}_{seed}", (
                box(side, False, mu=mu, e=e) + filling(side * side, max(0.63 * side, 2.6), seed)
                + end(0.005, int(1.5 * steps))), [int(1.5 * k) for k in parts]
            yield "moving", f"2d_tilt_{side}_{seed}", (
                "gravity = [4.9, -8.5]\n" + box(side, mu=mu, e=e) + filling(side * side, side, seed)
                + end(0.005, steps)), parts
    for side, seed in ((8, 41), (12, 42), (16, 43)):
        strike = (f"[[disks]]\nposition = [{side / 2}, {2.2 * side}]\nradius = {side / 12}\n"
                  f"density = 5000\nvelocity = [0, -40]\n")
        steps = 90 + 8 * side
        yield "moving", f"2d_strike_{side}_{seed}", (
            box(side, mu=0.3, e=0.1) + filling(side * side, side, seed) + strike
            + end(0.005, steps)), [steps // 3, steps // 2, steps]
    for mu in (0.3, 0.5, 0.8):
        for rows in (3, 6, 10, 16):
            yield "pyramid", f"2d_pyramid_{rows}_mu{mu}", (
                box(1, False, mu=mu) + f'[[disks]]\narrangement = "pyramid"\nrows = {rows}\n'
                "radius = 0.5\nmass = 1\n" + end(0.01, 1)), [1]
    for mu in (0.4, 0.8):
        for columns, rows in ((6, 3), (12, 4), (20, 6)):
            disks = "".join(
                f'[[disks]]\narrangement = "rectangular"\ncolumns = {columns - k}\nrows = 1\n'
                f"radius = 0.5\nmass = 1\ncorner = [{0.5 * k}, {k * 3 ** 0.5 / 2}]\n"
                for k in range(rows))
            yield "trapezoid", f"2d_trapezoid_{columns}x{rows}_mu{mu}", (
                box(1, False, mu=mu) + disks + end(0.01, 1)), [1]
    for tilt in (0, 10):
        gravity = f"gravity = [{9.81 * np.sin(np.pi * tilt / 180)}, {-9.81 * np.cos(np.pi * tilt / 180)}]\n"
        for kind in ("rectangular", "triangular"):
            for side in (2, 4, 8, 16, 30):
                yield "lattice", f"2d_{kind}_{side}_tilt{tilt}", (
                    gravity + box(side, mu=0.3)
                    + f'[[disks]]\narrangement = "{kind}"\ncolumns = {side}\nrows = {side}\n'
                    "radius = 0.5\nmass = 1\n" + end(0.01, 1)), [1]
    for count, seed, mu, height in ((60, 51, 0.1, 1.6), (150, 52, 0.3, 2), (300, 53, 0.5, 2)):
        width = round(count ** 0.5)
        lid = (f"[[walls]]\nname = \"lid\"\npoint = [0, {height * width}]\nnormal = [0, -1]\nforce = 2e6\n"
               f"mass = {2000 * width}\nstarts = 0.5\n")
        yield "driven", f"2d_lid_{count}_{seed}", (
            box(width, mu=mu) + lid + filling(count, width, seed) + end(0.004, 260)), [150, 190, 260]
    for count, seed in ((80, 61), (200, 62), (400, 63)):
        side = 2.1 * count ** 0.5
        walls = "".join(
            f"[[walls]]\npoint = {point}\nnormal = {normal}\nforce = {4e4 * side}\nmass = {600 * count / 20}\n"
            for point, normal in (([0, 0], [1, 0]), ([side / 1.8, 0], [-1, 0]), ([0, 0], [0, 1]),
                                  ([0, side / 1.3], [0, -1])))
        yield "driven", f"2d_compression_{count}_{seed}", (
            "gravity = [0, 0]\n[contact]\nmu = 0.2\n" + walls
            + filling(count, side / 1.8, seed) + end(0.005, 160)), [60, 110, 160]
    for side, seed in ((6, 71), (12, 72), (18, 73)):
        yield "rest", f"2d_rest_{side}_{seed}", (
            box(side, mu=0.3) + filling(side * side, side, seed)
            + end(0.01, int(200 * side ** 0.5))), [int(200 * side ** 0.5)]
    for side in (4, 9, 14, 20):
        yield "frictionless", f"1d_square_{side}", (
            box(side, mu=0) + f'[[disks]]\narrangement = "rectangular"\ncolumns = {side}\nrows = {side}\n'
            "radius = 0.5\nmass = 1\n" + end(0.01, 1)), [1]
        yield "frictionless", f"1d_pour_{side}", (
            box(side, mu=0, e=0.2) + filling(side * side, side, 80 + side)
            + end(0.005, int(100 * side ** 0.5))), [int(60 * side ** 0.5), int(100 * side ** 0.5)]
    for count, seed in ((20, 91), (60, 92), (150, 93)):
        width = round(count ** (1 / 3)) + 0.6
        walls = "".join(f"[[walls]]\npoint = {point}\nnormal = {normal}\n" for point, normal in (
            ([0, 0, 0], [0, 0, 1]), ([0, 0, 0], [1, 0, 0]), ([0, 0, 0], [0, 1, 0]),
            ([width, 0, 0], [-1, 0, 0]), ([0, width, 0], [0, -1, 0])))
        yield "spheres", f"3d_pour_{count}_{seed}", (
            f"dim = 3\n[contact]\nmu = 0.4\n{walls}[[spheres]]\narrangement = \"random\"\ncount = {count}\n"
            f"radii = [0.4, 0.5]\nwidth = {width}\nspacing = 0.05\ndensity = 1000\nseed = {seed}\n"
            + end(0.005, 240)), [100, 160, 240]
    for n in (2, 5, 9):  # provably without solution: walls that move into what cannot give way
        yield "unsolvable", f"2d_wall_into_row_{n}", (
            "gravity = [0, 0]\n[contact]\nmu = 0.3\n"
            + f'[[disks]]\narrangement = "rectangular"\ncolumns = {n}\nrows = 1\nradius = 0.5\nmass = 1\n'
            + f"[[walls]]\npoint = [0, 0]\nnormal = [1, 0]\n[[walls]]\npoint = [{n}, 0]\n"
            "normal = [-1, 0]\nvelocity = [-0.1, 0]\n" + end(0.01, 1)), [1]
    for side in (3, 6, 10, 15):
        yield "unsolvable", f"2d_wall_into_lattice_{side}", (
            box(side - 1e-9, False, mu=0.3)
            + f'[[disks]]\narrangement = "rectangular"\ncolumns = {side}\nrows = {side}\nradius = 0.5\nmass = 1\n'
            + f"[[walls]]\npoint = [0, 0]\nnormal = [1, 0]\n[[walls]]\npoint = [{side}, 0]\n"
            "normal = [-1, 0]\nvelocity = [-1e-6, 0]\n" + end(0.01, 1)), [1]
    for name, keep in (("compaction_100", [150, 400, 750]), ("drum", [250, 700]), ("hopper", [300, 500]),
                       ("trefoils", [400, 900]), ("dam_break", [240, 330]), ("four_spheres", [100]),
                       ("plane_shear", [500, 1000]), ("rough_shear", [500, 1000])):
        yield "shipped scene", f"{'3d' if name == 'four_spheres' else '2d'}_{name}", name, keep
    side = 45  # the large ones
    yield "large", "2d_large_pour_2025", (
        box(side, mu=0.4) + filling(side * side, side, 101) + end(0.005, 620)), [400, 620]
    yield "large", "2d_large_rectangular_64", (
        "gravity = [1.7, -9.66]\n" + box(64, mu=0.3) + '[[disks]]\narrangement = "rectangular"\ncolumns = 64\n'
        "rows = 64\nradius = 0.5\nmass = 1\n" + end(0.01, 1)), [1]
    yield "large", "2d_large_triangular_82", (
        "gravity = [1.7, -9.66]\n" + box(82, mu=0.3) + '[[disks]]\narrangement = "triangular"\ncolumns = 82\n'
        "rows = 82\nradius = 0.5\nmass = 1\n" + end(0.01, 1)), [1]


def families():
    """(kind, name, target of bipot.problems)."""
    for ratio in ("1e2", "1e4", "1e6", "1e8"):
        for family in ("triangular:6", "triangular:14", "square:10"):
            yield "unequal masses", f"2d_{family.replace(':', '_')}_ratio{ratio}", f"{family}:ratio={ratio}"
    for side in (2, 3, 4, 6, 8):
        yield "spheres", f"3d_cannonballs_{side}", f"cannonballs:{side}:mu=0.5:tilt=5"
        yield "spheres", f"3d_cubic_{side}", f"cubic:{side}:mu=0.3:tilt=10"
    for side in (6, 10, 16):
        for mu in (0.2, 0.5):
            yield "rest", f"2d_pile_{side}_mu{mu}", f"pile:{side}:mu={mu}"
            yield "moving", f"2d_flowing_pile_{side}_mu{mu}", f"pile:{side}:mu={mu}:tilt=25"
        yield "moving", f"2d_impact_{side}", f"impact:{side}"


def run(*words):
    return subprocess.run([str(w) for w in words], capture_output=True, text=True)


def repack(path):
    """The same file, its arrays compressed, without free space and without the times of h5repack."""
    draft = path.with_suffix(".packed")
    subprocess.run(["h5repack", "-f", "SHUF", "-f", "GZIP=9", "-m", "4096", path, draft], check=True)
    # Modification times: type 18, 8 bytes, flags; version 1, seconds.
    stamped = rb"(\x12\0\x08\0.\0{3}\x01\0{3}).{4}"
    path.write_bytes(re.sub(stamped, rb"\1\0\0\0\0", draft.read_bytes(), flags=re.DOTALL))
    draft.unlink()


def six_digits(path, made_of):
    """W, u_free and mu of a problem, each to six significant digits, as a table in a paper has them."""
    p = bipot.read(made_of)

    def rounded(x):
        return np.array([float(f"{v:.6g}") for v in np.ravel(x)])

    W = p.delassus().tocsr().copy()
    W = (W + W.T).tocsr() / 2
    W.data = rounded(W.data)
    q = bipot.Problem(W=W, u_free=rounded(p.u_free), mu=rounded(p.mu), dim=p.dim)
    bipot.write(q, path, title=path.stem, description=f"{made_of.stem}: W, q and mu to six digits")


def make(folder, only):
    """Writes the problems; yields (name, kind, command)."""
    wanted = lambda name: only in name
    for kind, name, text, steps in scenes():
        names = [f"{name}_s{k}" for k in steps]
        files = [folder / f"{n}.hdf5" for n in names]
        if any(wanted(n) for n in names) and not all(f.exists() for f in files):
            with tempfile.TemporaryDirectory() as work:
                scene = text
                if "\n" in text:
                    scene = pathlib.Path(work) / f"{name}.toml"
                    scene.write_text(f'title = "{name}"\n' + text if not text.startswith("title") else text)
                out = pathlib.Path(work) / "out"
                # Not auto: runs would follow its plan.
                how = ["--solver", "apgd", "--max-iterations", 3000] if max(steps) > 1 else [
                    "--solver", "pgs", "--max-iterations", 10]
                done = run(PROGRAM, "run", scene, "--steps", max(steps), *how, "--tol", "1e-3",
                           "--on-failure", "continue", "--on-tunnel", "warn", "--dump-problems", "all",
                           "--no-page", "--quiet", "--out", out)
                dumped = {int(p.stem.split("_")[-1]): p for p in (out / "problems").glob("*.hdf5")}
                for step, file in zip(steps, files):
                    if step not in dumped:
                        print(f"{file.stem}: no problem: {done.stderr.strip()[:200]}")
                        continue
                    repack(dumped[step])
                    shutil.copy(dumped[step], file)
        command = f"bipot run {name.split('_', 1)[1] if chr(10) not in text else name + '.toml'} --dump-problems all"
        for n, step in zip(names, steps):
            yield n, kind, f"{command} (step {step})"
    for kind, name, target in families():
        file = folder / f"{name}.hdf5"
        if wanted(name) and not file.exists():
            p = bipot.problems(target)[0]
            bipot.write(p, file, title=name, description=f"bipot compare target {target}: {p.name}")
            repack(file)
        yield name, kind, f"bipot.problems('{target}')"
    for index in range(24):
        name = f"random_{index:02}"
        found = list(folder.glob(f"?d_{name}.hdf5"))
        if wanted(name) and not found:
            file = folder / f"{name}.hdf5"
            run(PROGRAM, "extremes", "--random-problems", 1, "--first", index, "--dump-problem", file)
            found = [folder / f"{bipot.read(file).dim}d_{name}.hdf5"]
            repack(file)
            file.rename(found[0])
        if found:
            yield (found[0].stem, "random",
                   f"bipot extremes --random-problems 1 --first {index} --dump-problem FILE")
    base = sorted(p.stem for p in folder.glob("2d_pour_*.hdf5") if "digits" not in p.stem)
    for stem in base[:4] + base[-4:]:
        name = f"{stem}_6digits"
        if wanted(name) and not (folder / f"{name}.hdf5").exists():
            six_digits(folder / f"{name}.hdf5", folder / f"{stem}.hdf5")
            repack(folder / f"{name}.hdf5")
        yield name, "six digits", f"six_digits() of {stem}"


def solve(file):
    """The best impulse of several solvers, written into the file; what is known of its problem."""
    p = bipot.read(file)
    told = json.loads(run(PROGRAM, "solve", file, "--certify", "--time-limit", 3, "--tol", 1, "--json", "-").stdout
                      or "{}")
    known = {"certificate": told.get("existence", {}).get("statement", "")}
    limit = 30 if p.num_contacts > MOST_CONTACTS_OF_ALL else 0.3 if known["certificate"].startswith("no ") else 2
    best, by = None, ""
    for solver in SOLVERS[p.dim]:
        if p.num_contacts > MOST_CONTACTS_OF_ALL and solver != "auto":
            continue
        r = bipot.solve(p, solver=solver, tol=TARGET, time_limit=limit)
        if np.isfinite(r.guarded) and (best is None or r.guarded < best.guarded):
            best, by = r, solver
        if best is not None and best.guarded <= TARGET:
            break
    known["found_by"] = by
    work = file.with_suffix(".work.hdf5")
    if by:
        shutil.copy(file, work)
        run(PROGRAM, "solve", work, "--solver", by, "--tol", TARGET, "--time-limit", limit + 2,
            "--solution", work, "--quiet")
        repack(work)
        work.replace(file)
    known["answers"], known["spread"] = "", ""
    if by and best.guarded <= TRUSTED and p.num_contacts <= MOST_CONTACTS_OF_SEVERAL and p.num_contacts > 1:
        known["answers"], known["spread"] = several_answers(file)
    known["rank"] = ""
    if p.num_rows <= MOST_ROWS_OF_RANK and p.num_rows > 0:
        W = p.delassus().toarray()
        scale = 1 / np.sqrt(np.maximum(W.diagonal(), 1e-300))
        known["rank"] = int(np.linalg.matrix_rank(scale[:, None] * W * scale, tol=1e-10))
    return known


def several_answers(file):
    """Number of exact answers found, and their spread; where there are several, each is stored."""
    with tempfile.TemporaryDirectory() as work:
        told = json.loads(run(PROGRAM, "solve", file, "--several", 6, "--time-limit", 2, "--out", work,
                              "--json", "-").stdout or "{}")
        answers = told.get("answers", [])
        if len(answers) > 1:
            (file.parent / "answers").mkdir(exist_ok=True)
            for k, s in enumerate(bipot.read(pathlib.Path(work) / "answers.hdf5").guesses, 1):
                np.save(file.parent / "answers" / f"{file.stem}_{k}.npy", s)
    return len(answers), told.get("spread", {}).get("velocity", "")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "data/collection")
    flags = parser.parse_args()
    folder = flags.out
    folder.mkdir(parents=True, exist_ok=True)
    cache = ROOT / f"build/{folder.resolve().name}.json"  # a stopped run goes on from it
    known = json.loads(cache.read_text()) if cache.exists() else {}
    rows = []
    for name, kind, command in list(make(folder, flags.only)):
        file = folder / f"{name}.hdf5"
        if not file.exists():
            continue
        if name not in known:
            known[name] = solve(file)
            cache.write_text(json.dumps(known))
            print(name, known[name], flush=True)
        rows.append((name, kind, command))
    # Judged by the program, in quadruple precision too.
    with tempfile.TemporaryDirectory() as work:
        run(PROGRAM, "leaderboard", folder, "--problems", folder, "--no-solvers", "--out", work, "--quiet")
        with open(pathlib.Path(work) / "leaderboard.csv") as text:
            judged = {row["problem"]: row for row in csv.DictReader(text)}
    with open(folder / "index.csv", "w", newline="") as text:
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["problem", "kind", "dim", "contacts", "dofs", "form", "rank", "starts", "status",
                        "guarded", "guarded_quadruple", "found_by", "certificate", "answers", "spread", "command"])
        for name, kind, command in rows:
            p = bipot.read(folder / f"{name}.hdf5")
            k, j = known[name], judged.get(name, {})
            exact = float(j.get("quadruple") or "nan")
            status = ("unsolvable" if k["certificate"].startswith("no solution")
                      else "solved" if exact <= TRUSTED else "unsolved")
            table.writerow([name, kind, p.dim, p.num_contacts, p.num_dofs, "global" if p.num_dofs else "local",
                            k["rank"], len(p.guesses), status, j.get("error", ""), j.get("quadruple", ""),
                            k["found_by"], k["certificate"], k["answers"], k["spread"], command])
    with open(folder / "SHA256SUMS", "w") as sums:
        for file in sorted(folder.glob("*.hdf5")) + [folder / "index.csv"] + sorted(folder.glob("answers/*.npy")):
            sums.write(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.relative_to(folder)}\n")


if __name__ == "__main__":
    main()
