"""data/collection as it is: checksums, the index against the files, errors of a sample once more.

collection.py SOURCE PROGRAM
"""

import csv
import hashlib
import pathlib
import subprocess
import sys
import tempfile

folder, program = pathlib.Path(sys.argv[1]) / "data/collection", sys.argv[2]
files = {path.stem: path for path in folder.glob("*.hdf5")}
faults = []
sums = dict(reversed(line.split("  ")) for line in (folder / "SHA256SUMS").read_text().splitlines())
answers = sorted(folder.glob("answers/*.npy"))
for path in [*files.values(), folder / "index.csv", *answers]:
    if sums.get(str(path.relative_to(folder))) != hashlib.sha256(path.read_bytes()).hexdigest():
        faults.append(f"{path.name}: another checksum")
with open(folder / "index.csv") as text:
    index = {row["problem"]: row for row in csv.DictReader(text)}
faults += [f"{name}: only in the index or only a file" for name in index.keys() ^ files.keys()]
for name, row in index.items():
    if not row["command"] or row["status"] not in ("solved", "unsolvable", "unsolved"):
        faults.append(f"{name}: no command or no status")
    if (row["status"] == "unsolvable") != row["certificate"].startswith("no solution"):
        faults.append(f"{name}: its status is not that of the certificate")
    several = int(row["answers"] or 0)
    if len(list(folder.glob(f"answers/{name}_[0-9].npy"))) != (several if several > 1 else 0):
        faults.append(f"{name}: {several} answers, but not as many files")
size = sum(path.stat().st_size for path in folder.rglob("*"))
if size > 40e6:
    faults.append(f"{size / 1e6:.1f} MB, more than 40")

sample = sorted(index, key=lambda name: hashlib.sha256(name.encode()).hexdigest())[:30]
with tempfile.TemporaryDirectory() as out:
    problems = ",".join(str(files[name]) for name in sample)
    subprocess.run([program, "leaderboard", folder, "--problems", problems, "--no-solvers", "--out", out, "-q"],
                   check=True)
    with open(pathlib.Path(out) / "leaderboard.csv") as text:
        for row in csv.DictReader(text):
            stored, now = float(index[row["problem"]]["guarded_quadruple"]), float(row["quadruple"])
            if not abs(stored - now) <= 1e-9 * now:
                faults.append(f"{row['problem']}: error {stored} in the index, {now} now")
            if int(row["contacts"]) != int(index[row["problem"]]["contacts"]):
                faults.append(f"{row['problem']}: another number of contacts")
for path in answers[::5]:  # solutions, and not the one before
    judged = subprocess.run([program, "judge", files[path.stem[:-2]], "--impulses", path, "--tol", "1e-9", "-q"])
    if judged.returncode != 0:
        faults.append(f"{path.name} is no solution to 1e-9")
    if path.read_bytes() == answers[answers.index(path) - 1].read_bytes():
        faults.append(f"{path.name} is stored twice")
print("\n".join(faults))
print(f"{len(files)} problems, {len(answers)} answers of those that have several, {size / 1e6:.1f} MB, {len(sample)} judged, {len(faults)} faults")
sys.exit(bool(faults))
