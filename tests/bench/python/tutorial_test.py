"""The tutorial's blocks, one after the other, and what it says that they print."""

import contextlib
import io
import re

from conftest import DATA

TEXT = (DATA / "python.md").read_text()


def test_the_tutorial_runs_and_prints_what_it_says():
    blocks = re.findall(r"```python\n(.*?)```", TEXT, re.S)
    assert len(blocks) >= 6
    names, printed = {}, []
    for block in blocks:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(block, names)
        printed.append(out.getvalue())
    first = printed[0].split()
    assert "".join(first).startswith("[1.-0.5]") and first[-1] == "converged"
    assert printed[1].strip() == re.search(r"# (u_free has size 3.*)", TEXT).group(1)
    assert printed[2].split("\n")[0] == re.search(r"It says `(.*?)`", TEXT).group(1)
    assert "apgd: converged" in printed[3]
    assert "projected_gradient" in printed[4]
