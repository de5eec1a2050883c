#!/usr/bin/env python3
"""Fills the tables of data/manual/results from folders of measurements:

    bench/programs/results_pages.py --compare DIR --extremes DIR --validate DIR

DIR: what --out of `bipot compare benchmark`, `bipot extremes` and `bipot validate` named. A page
marks each table by <!-- table NAME --> and <!-- end NAME -->; the text around them is kept.
"""

import argparse
import csv
import json
import pathlib
import re
import sys

SOLVERS = ("auto uzawa classical pgs apgd assor anderson admm ppa newton lemke multistart homotopy "
           "ipm pdas ptc tresca").split()
SIZES = {"to 100": range(1, 101), "to 1000": range(101, 1001), "above": range(1001, 10**9)}
SHORT = {"more forces than equations": "hyperstatic"}  # names of groups of extreme cases
FIGURES = {"measured": 4, "bar": 2, "error": 2, "loosest_tol": 2}  # of a validation row: digits
COUNTED_ENDS = ("solved", "not solved", "wrong")  # of an extreme case
NONE = "–"


def table(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"|{'|'.join(map(str, line))}|" for line in lines)


def made_by(report):
    """From the members that JSON reports begin with."""
    machine = f"{report['cpu']}, {report['cores']} cores, {report['threads']} used"
    return table(["command", "date", "commit", "machine"],
                 [[f"`{report['command_line']}`", report["date"].split()[0],
                   report["commit"][:7], machine]])


def number(x, digits=2):
    return NONE if x is None else f"{x:.{digits}g}".replace("e-0", "e-").replace("e+0", "e")


def milliseconds(x):
    return f"{float(f'{1e3 * x:.2g}'):g}"


def tolerance(x):
    return f"{x:.0e}".replace("e-0", "e-").replace("e+0", "e")


def share(rows, holds):
    return f"{sum(map(holds, rows))}/{len(rows)}" if rows else NONE


def below(row, error, bound):
    return row[error] is not None and row[error] <= bound


def met(row):
    return below(row, "guarded", row["tol"])


def cold_rows(comparison):
    """Rows from s = 0, without the problems that a solver does not take."""
    return [r for r in comparison["rows"] if not r["warm"] and r["status"] != "invalid input"]


def solver_table(comparison):
    rows = cold_rows(comparison)
    tols = sorted({r["tol"] for r in rows}, reverse=True)
    ratio = {s["solver"]: s["median_time_ratio"] for s in comparison["solved"]}
    lines = []
    for solver in SOLVERS:
        own = [r for r in rows if r["solver"] == solver]
        tight = [r for r in own if r["tol"] == tols[-1]]
        groups = [[r for r in own if r["tol"] == tol] for tol in tols]
        groups += [[r for r in tight if r["contacts"] in size] for size in SIZES.values()]
        lines.append([f"`{solver}`", *(share(group, met) for group in groups),
                      share(tight, lambda r: below(r, "natural_map", 1e-8)),
                      number(ratio.get(solver))])
    return table(["solver", *map(tolerance, tols), *SIZES, "natural map", "time"], lines)


def fastest(rows, error, accuracy):
    """The row of least time; of its solver's rows that take 5 % more at most, the loosest."""
    good = [r for r in rows if below(r, error, accuracy)]
    if not good:
        return [NONE] * 3
    best = min(good, key=lambda r: r["cpu_min"])
    best = max((r for r in good if r["solver"] == best["solver"]
                and below(r, "cpu_min", 1.05 * best["cpu_min"])), key=lambda r: r["tol"])
    return [f"`{best['solver']}`", tolerance(best["tol"]), milliseconds(best["cpu_min"])]


def fastest_table(comparison):
    """A row for the largest problem of each family: a target FAMILY:SIZE:OPTIONS."""
    largest = {}
    for problem in comparison["problems"]:
        family = re.fullmatch(r"(\w+):\d+(:.*)?", problem["target"])
        if family and not problem["defect"]:
            key = family.groups()
            largest[key] = max(largest.get(key, problem), problem, key=lambda p: p["contacts"])
    lines = []
    for problem in largest.values():
        error = problem["ranked_by"].replace(" ", "_")  # a column of the rows, if a true error
        rows = [r for r in cold_rows(comparison) if r["problem"] == problem["name"] and error in r]
        lines.append([f"`{problem['name']}`", problem["contacts"], *fastest(rows, error, 1e-2),
                      *fastest(rows, error, 1e-6)])
    return table(["problem", "contacts", *(f"{e}: {c}" for e in ("1 %", "1e-6")
                                           for c in ("solver", "tol", "ms"))], lines)


def auto_table(comparison):
    keys = ("cases", "failed", "median", "ninth_decile", "worst")
    lines = [[title, *(number(comparison[regret][key], 4) for key in keys)] for title, regret in
             (("all", "regret_of_auto"), ("1 ms and longer", "regret_of_auto_from_1_ms"))]
    return table(["cases", "number", "missed", "median", "90 % below", "worst"], lines)


def answers_table(comparison):
    return table(["problems", "number", "several answers", "velocity", "force"],
                 [[s["size"], s["problems"], s["several"], number(s["largest_velocity"]),
                   number(s["largest_force"])] for s in comparison["several"]])


def benchmark_tables(folder):
    c = json.loads((folder / "comparison.json").read_text())
    return {"made": made_by(c), "solvers": solver_table(c), "fastest": fastest_table(c),
            "auto": auto_table(c), "answers": answers_table(c)}


def extremes_tables(folder):
    m = json.loads((folder / "extremes.json").read_text())
    cells = m["cells"]
    groups = list(dict.fromkeys(c["group"] for c in cells))
    lines = []
    for solver in SOLVERS:
        own = [c for c in cells if c["solver"] == solver and c["end"] in COUNTED_ENDS]
        shares = [share([c for c in own if c["group"] == group], lambda c: c["end"] == "solved")
                  for group in groups]
        lines.append([f"`{solver}`", *shares, sum(c["end"] == "wrong" for c in own)])
    return {"made": made_by(m),
            "matrix": table(["solver", *(SHORT.get(g, g) for g in groups), "wrong"], lines)}


def validation_tables(folder):
    rows = list(csv.DictReader((folder / "verdicts.csv").open()))
    counts = [sum(r["holds"] == word for r in rows) for word in ("yes", "undecided", "no")]
    lines, group = [], None
    for r in rows:
        if r["group"] != group:
            group = r["group"]
            lines.append([f"**{group}**"] + [""] * 5)
        measured, bar, error, loosest = (number(float(r[key]) if r[key] not in ("", "nan") else None, digits) for
                                         key, digits in FIGURES.items())
        lines.append([f"`{r['row']}`", measured, bar, error, r["holds"], loosest])
    report = json.loads((folder / "validate.json").read_text())
    item = report["items"][0]
    made = {**item["program"], **item["machine"], "date": item["date"], "threads": 1,
            "command_line": report["command"]}
    return {"made": made_by(made),
            "count": table(["rows", "hold", "undecided", "do not hold"], [[len(rows), *counts]]),
            "rows": table(["row", "measured", "±", "error", "holds", "right from"], lines)}


def fill(page, tables):
    text = page.read_text()
    for name, content in tables.items():
        between = re.compile(f"(<!-- table {name} -->\n).*?(<!-- end {name} -->)", re.DOTALL)
        text, places = between.subn(lambda m: f"{m[1]}\n{content}\n\n{m[2]}", text)
        if places != 1:
            sys.exit(f"{page}: {places} places for the table '{name}', expected one")
    page.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split(":")[0])
    for command in ("compare", "extremes", "validate"):
        parser.add_argument(f"--{command}", type=pathlib.Path, metavar="DIR")
    parser.add_argument("--pages", type=pathlib.Path, default="data/manual/results", metavar="DIR")
    flags = parser.parse_args()
    for folder, page, tables in ((flags.compare, "benchmark.md", benchmark_tables),
                                 (flags.extremes, "extremes.md", extremes_tables),
                                 (flags.validate, "validation.md", validation_tables)):
        if folder:
            fill(flags.pages / page, tables(folder))


if __name__ == "__main__":
    main()
