"""Lines that the tests reach: coverage.py [--missed] (after ctest --preset coverage).

A line counts once, however many objects hold it: it is reached if one of them reaches it.
"""

import collections
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
FOLDERS = ("core/", "solvers/")


def main():
    reached = collections.defaultdict(dict)  # file -> line -> whether it is reached
    for counts in sorted((ROOT / "build/coverage").rglob("*.gcda")):
        text = subprocess.run(["gcov", "--json-format", "--stdout", counts], cwd=ROOT,
                              check=True, capture_output=True).stdout
        for file in json.loads(text)["files"]:
            name = file["file"].removeprefix(f"{ROOT}/")
            if not name.startswith(FOLDERS):
                continue
            for line in file["lines"]:
                number = line["line_number"]
                reached[name][number] = reached[name].get(number, False) or line["count"] > 0
    if not reached:
        sys.exit("coverage.py: build/coverage holds no counts: run ctest --preset coverage")
    rooms = collections.defaultdict(lambda: [0, 0])
    for name, lines in sorted(reached.items()):
        missed = sorted(number for number, hit in lines.items() if not hit)
        if "--missed" in sys.argv and missed:
            print(f"{name}:", *missed)
        for room in ("/".join(name.split("/")[:2]) if name.count("/") > 1 else name.split("/")[0],
                     "all"):
            rooms[room][0] += len(lines) - len(missed)
            rooms[room][1] += len(lines)
    for room, (hit, lines) in sorted(rooms.items()):
        print(f"{room:24}{hit:8} of {lines:6} lines  {100 * hit / lines:5.1f} %")


main()
