"""The stubs name what the module has, and everything public is documented."""

import ast
import inspect
import pathlib
import subprocess
import sys

import bipot
from bipot import _bipot

STUB = pathlib.Path(bipot.__file__).parent / "_bipot.pyi"


def members(cls):
    return {name for name in vars(cls) if not name.startswith("_")}


def test_the_stub_names_what_there_is():
    tree = ast.parse(STUB.read_text())
    classes = {n.name: n for n in tree.body if isinstance(n, ast.ClassDef)}
    functions = {n.name for n in tree.body if isinstance(n, ast.FunctionDef)}
    there = {n for n in vars(_bipot) if not n.startswith("_")}
    assert classes.keys() | functions == there
    for name, node in classes.items():
        named = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} - {"__init__"}
        for base in node.bases:
            if base.id in classes:  # Step has all that State has
                named |= {n.name for n in classes[base.id].body if isinstance(n, ast.FunctionDef)}
        if name != "StepError":
            assert named == members(getattr(_bipot, name)), name


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
        assert inspect.getdoc(thing), name
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


def test_the_module_loads_without_numpy():
    """Another python3 of the same version may lack it; what needs arrays says so."""
    code = """
import sys
sys.modules["numpy"] = sys.modules["scipy"] = None
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
