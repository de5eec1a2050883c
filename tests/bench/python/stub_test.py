"""The stubs name what the module has, and everything public is documented."""

import ast
import inspect
import os
import pathlib
import subprocess
import sys

import bipot
from bipot import _bipot

STUB = pathlib.Path(bipot.__file__).parent / "_bipot.pyi"


def members(cls):
    return {name for base in cls.__mro__ for name in vars(base) if not name.startswith("_")}


def test_the_stub_names_what_there_is():
    tree = ast.parse(STUB.read_text())
    nodes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}

    def named(node):  # methods and attributes, its bases' too
        own = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
        own |= {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
        return own.union(*(named(nodes[base.id]) for base in node.bases if base.id in nodes))

    classes = {name for name in nodes if not name.startswith("_")}
    functions = {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
    there = {n for n in vars(_bipot) if not n.startswith("_")}
    assert classes | functions == there
    for name in classes - {"StepError"}:
        public = {member for member in named(nodes[name]) if not member.startswith("_")}
        assert public == members(getattr(_bipot, name)), name


def test_the_arguments_are_those_of_the_stub():
    tree = ast.parse(STUB.read_text())
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef):
            continue
        text = getattr(_bipot, node.name).__doc__.split("\n")[0]
        for argument in node.args.args:
            assert f"{argument.arg}: " in text, (node.name, argument.arg, text)


def test_everything_public_is_documented():
    for name in bipot.__all__:
        thing = getattr(bipot, name)
        assert thing.__doc__, name  # its own, none of a base
        if inspect.isclass(thing):
            for member, value in vars(thing).items():
                if member.startswith("_") or name in ("StepError", "Advice"):
                    continue
                assert inspect.getdoc(value), f"{name}.{member}"


def test_the_package_says_that_it_is_typed():
    assert (STUB.parent / "py.typed").exists()
    assert bipot.__version__.count(".") == 2


def test_options_are_keywords():
    for function in (bipot.solve, bipot.judge, bipot.compare, bipot.advise, bipot.write):
        kinds = [p.kind for p in inspect.signature(function).parameters.values()]
        positional = [k for k in kinds if k == inspect.Parameter.POSITIONAL_OR_KEYWORD]
        assert len(positional) <= 2 and inspect.Parameter.KEYWORD_ONLY in kinds


def test_a_dense_problem_needs_no_scipy():
    code = """
import sys
sys.modules["scipy"] = None
import bipot
import numpy as np
p = bipot.Problem(A=np.eye(2), H=np.eye(2), v_free=[-1, 0.75], mu=[0.5])
assert np.allclose(bipot.solve(p, tol=1e-10).s, [1, -0.5])
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_module_that_is_not_built_says_what_to_build(tmp_path):
    """bench/run.sh builds the command alone; another Python finds a module that is not its own."""
    package = tmp_path / "bipot"
    package.mkdir()
    for source in pathlib.Path(bipot.__file__).parent.glob("*.py"):
        (package / source.name).write_text(source.read_text())

    def refusal():
        run = subprocess.run(
            [sys.executable, "-c", "import bipot"], capture_output=True, text=True, cwd=tmp_path,
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
        )
        assert run.returncode == 1
        return run.stderr.strip().splitlines()[-1]

    assert "is not built" in refusal() and "--target bipot_python" in refusal()
    (package / "_bipot.cpython-27-linux-gnu.so").touch()
    assert "built for cpython-27-linux-gnu, this is Python 3" in refusal()


def test_the_module_loads_without_numpy():
    """Another python3 of the same version may lack it; what needs arrays says so."""
    code = """
import sys
sys.modules["numpy"] = sys.modules["scipy"] = sys.modules["matplotlib"] = None
import bipot
assert any(row["name"] == "auto" for row in bipot.solvers())
try:
    bipot.judge(bipot.problems("square:3")[0], [0])
except ImportError as error:
    print(error)
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert "numpy" in run.stdout
