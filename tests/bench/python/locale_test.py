"""Numbers in a process whose locale has decimal commas."""

import locale

import pytest

import bipot

SCENE = """
disks = [{position = [0, 0.25], radius = 0.25, density = 1000.5}]
walls = [{point = [0, 0], normal = [0, 1]}]
time = {step = 1.5e-3, steps = 3}
"""


def outcome(lattice):
    result = bipot.solve(lattice, solver="pgs", tol=1.5e-6, omega=1.5)
    scene = bipot.Simulation.from_text(SCENE)
    list(scene)
    return result.iterations, list(result.s), scene.time, scene.state.positions.tolist()


@pytest.fixture
def decimal_comma():
    before = locale.setlocale(locale.LC_ALL)
    try:
        locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
    except locale.Error:
        pytest.skip("this machine has no locale de_DE.UTF-8")
    assert locale.localeconv()["decimal_point"] == ","
    yield
    locale.setlocale(locale.LC_ALL, before)


def test_decimal_commas_change_nothing(lattice, request):
    plain = outcome(lattice)
    request.getfixturevalue("decimal_comma")
    assert outcome(lattice) == plain
