"""The blocks of the tutorial, the robotics page and the README, and what they say that they print."""

import contextlib
import io
import re

from conftest import DATA

TEXT = (DATA / "manual" / "tutorial" / "python.md").read_text()


def output_of_blocks(text):
    names, printed = {}, []
    for block in re.findall(r"```python\n(.*?)```", text, re.S):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(block, names)
        printed.append(out.getvalue())
    return printed


def test_the_tutorial_runs_and_prints_what_it_says():
    printed = output_of_blocks(TEXT)
    assert len(printed) >= 6
    first = printed[0].split()
    assert "".join(first).startswith("[1.-0.5]") and first[-1] == "converged"
    assert printed[1].strip() == re.search(r"# (u_free has size 3.*)", TEXT).group(1)
    assert printed[2].split("\n")[0] == re.search(r"It says `(.*?)`", TEXT).group(1)
    assert "apgd: converged" in printed[3]
    assert "projected_gradient" in printed[5]


def test_the_robotics_page_prints_what_it_says():
    text = (DATA / "manual" / "how_to" / "robotics_matrices.md").read_text()
    said = re.findall(r"^print\(.*\) +# (.*)$", text, re.M)
    numbers = [[float(x) for x in re.findall(r"-?[\d.]+", line)] for line in said]
    printed = [[float(x) for x in re.findall(r"-?[\d.]+", line)] for line in output_of_blocks(text)]
    assert len(said) == 6
    assert printed == numbers


def test_the_lines_of_the_readme_run():
    printed = output_of_blocks((DATA.parent / "README.md").read_text())
    assert len(printed) == 1
    assert printed[0].startswith("not within the tolerance") and "pile:8" in printed[0]
