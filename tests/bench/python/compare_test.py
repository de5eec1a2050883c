"""compare, problems, reports."""

import json

import numpy as np
import pytest

import bipot
from conftest import DATA, chain, foreign_scene, gauss_seidel, one_contact, refused

QUICK = dict(time_limit=2, reference_time_limit=2, min_time=0)


def row_of(table, solver, tol):
    return next(r for r in table.rows if r["solver"] == solver and r["tol"] == tol)


def test_a_table_has_a_row_for_each_problem_solver_and_tolerance():
    seen = []
    t = bipot.compare(
        [one_contact(-1, 0.75), "square:3", ("by hand", chain(4))],
        solvers=["apgd", "ipm", gauss_seidel],
        tols=[1e-2, 1e-6],
        on_row=lambda row, done, total: seen.append((row["solver"], done, total)),
        **QUICK,
    )
    assert t.complete and isinstance(t, dict)
    assert {len(column) for column in t.values()} == {18}
    assert list(dict.fromkeys(t["problem"])) == ["one contact", "square:3", "by hand"]
    assert list(dict.fromkeys(t["solver"])) == ["apgd", "ipm", "gauss_seidel"]
    assert t["guarded"].dtype == np.float64 and t["iterations"].dtype.kind == "i"
    assert len(seen) == 18 and seen[-1] == ("gauss_seidel", 18, 18)
    met = [s == "converged" or s == "nothing to do" for s in t["status"]]
    assert all(met), t["message"]
    assert (t["guarded"] <= t["tol"]).all()
    # On the chain everyone finds the one solution: errors against the reference are true.
    mine = row_of(t, "gauss_seidel", 1e-6)
    assert mine["velocity_error"] < 1e-2 and mine["cpu_min"] > 0
    assert "gauss_seidel" in str(t) and "18 rows" in repr(t)
    details = t.details
    assert [p["name"] for p in details["problems"]] == list(dict.fromkeys(t["problem"]))
    assert details["complete"] is True


def test_the_columns_are_those_of_the_command_and_go_into_a_table(lattice):
    t = bipot.compare(chain(2), solvers="pgs", tols=[1e-3], **QUICK)
    header = (
        "problem solver tol warm contacts dim status iterations repeats total_min setup_min "
        "setup_median solve_min solve_median cpu_min guarded epsilon eta raw42 natural_map take_off "
        "stick slip velocity_error force_error contact_force_error penetration_velocity penetration "
        "dissipated energy_error answer commit message"
    ).split()
    assert list(t) == header
    # What pandas asks of a dict of columns: one-dimensional, of one length, keyed by text.
    for name, column in t.items():
        assert isinstance(name, str) and len(column) == 1 and np.ndim(column) == 1


def test_python_solvers_that_fail_are_rows_that_failed():
    p = chain(3)
    right = np.tile([1.0, -0.5], 3)

    def raises(problem, tol, callback):
        raise ValueError("no")

    def lies(problem, tol, callback):
        return 0.5 * right

    def nan(problem, tol, callback):
        return right * np.nan

    def wrong_size(problem, tol, callback):
        return right[:2]

    def claims(problem, tol, callback):
        return right

    t = bipot.compare(
        [("p", p)], solvers=[raises, lies, nan, wrong_size, claims, "pgs"], tols=[1e-4], **QUICK
    )
    for solver, words in [
        ("raises", "raises failed: ValueError: no"),
        ("lies", "claim of convergence withdrawn"),
        ("nan", "non-finite impulse"),
        ("wrong_size", "2 rows, expected 6"),
    ]:
        row = row_of(t, solver, 1e-4)
        assert row["status"] == "numerical failure"
        assert words in row["message"]
        assert not row["guarded"] <= 1e-4
    assert row_of(t, "claims", 1e-4)["status"] == "converged"
    assert row_of(t, "pgs", 1e-4)["status"] == "converged"
    assert row_of(t, "claims", 1e-4)["iterations"] == 0


def test_python_solvers_have_the_time_that_the_others_have():
    def endless(problem, tol, callback):
        s = np.zeros(problem.num_rows)
        k = 0
        while not callback(s):
            k += 1
            s = s + 1e-6 / k  # moves, so that it does not count as stalled
        return s

    t = bipot.compare(chain(2), solvers=[endless], tols=[1e-4, 1e-6], time_limit=0.2,
                      reference_time_limit=1, min_time=0)
    assert row_of(t, "endless", 1e-4)["status"] == "time limit"
    assert row_of(t, "endless", 1e-6)["status"] == "not tried"


def test_names_must_differ():
    with pytest.raises(ValueError, match="solver 'pgs' is the name of one of this build"):
        bipot.compare(chain(2), solvers={"pgs": gauss_seidel}, tols=[1e-2])
    with pytest.raises(ValueError, match="'gauss_seidel' is named twice"):
        bipot.compare(chain(2), solvers=[gauss_seidel, gauss_seidel], tols=[1e-2])
    with pytest.raises(ValueError, match="two problems are called one contact"):
        bipot.compare([one_contact(-1, 0), one_contact(-1, 1)], solvers=["pgs"], tols=[1e-2])
    t = bipot.compare(
        {"a": one_contact(-1, 0), "b": one_contact(-1, 1)},
        solvers={"mine": gauss_seidel, "apgd": "apgd"}, tols=[1e-2], **QUICK,
    )
    assert t["problem"] == ["a", "a", "b", "b"] and set(t["solver"]) == {"mine", "apgd"}


def test_one_target_may_stand_alone(tmp_path):
    bipot.write(chain(2), tmp_path / "two.hdf5")
    for target, name in ((("pile:2", chain(2)), "pile:2"), (tmp_path / "two.hdf5", "two")):
        t = bipot.compare(target, solvers=["pgs"], tols=[1e-2], **QUICK)
        assert t["problem"] == [name]
    refused(ValueError, "'apgd' keeps its own name", bipot.compare, chain(2), solvers={"a": "apgd"})
    refused(TypeError, "expected a name or a callable", bipot.compare, chain(2), solvers=[None])
    refused(OSError, "null", t.report, "/dev/null/x")


def test_limits_are_those_of_the_command():
    for option, value in dict(time_limit=0, reference_time_limit=-1, min_time=-1, repeat=0,
                              scene_problems=0, scene_steps=0).items():
        refused(ValueError, f"{option} = ", bipot.compare, chain(2), solvers=["pgs"], **{option: value})
    refused(ValueError, "scene_problems = -3", bipot.problems, "compaction", scene_problems=-3)
    refused(ValueError, "worst = -1", bipot.judge, chain(1), [1, 0], worst=-1)
    refused(ValueError, "expected a positive number", bipot.judge(chain(1), [1, 0]).sentence, np.nan)


def test_bad_input_is_refused():
    refused(ValueError, "did you mean 'pgs'", bipot.compare, chain(2), solvers=["pgz"])
    refused(ValueError, "no such file", bipot.compare, "no_such_scene")
    refused(ValueError, "tolerance -1", bipot.compare, chain(2), solvers=["pgs"], tols=[-1])
    refused(TypeError, "expected a text, a Problem", bipot.compare, [3], solvers=["pgs"])
    with pytest.raises(TypeError, match="unknown option 'tol'; did you mean 'tols'"):
        bipot.compare(chain(2), tol=1e-2)

    def stop(row, done, total):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        bipot.compare(chain(2), solvers=["pgs", "apgd"], tols=[1e-2], on_row=stop, **QUICK)


def test_reports_and_rows_are_files(tmp_path):
    p = bipot.read(DATA / "problems" / "2d_triangular_lattice.hdf5")
    options = dict(solvers=["apgd", gauss_seidel], tols=[1e-1, 1e-2], out=tmp_path / "rows", **QUICK)
    t = bipot.compare(p, **options)
    t.report(tmp_path / "new" / "report")
    page = (tmp_path / "new" / "report" / "report.html").read_text()
    assert "gauss_seidel" in page and "2d_triangular_lattice" in page
    table = json.loads((tmp_path / "new" / "report" / "comparison.json").read_text())
    assert len(table["rows"]) == 4
    assert (tmp_path / "new" / "report" / "comparison.csv").read_text().count("\n") == 5
    again = bipot.compare(p, **options)  # taken up from the rows there: nothing runs
    assert again["cpu_min"].tolist() == t["cpu_min"].tolist()


def test_another_problem_of_the_same_name_is_refused(tmp_path):
    def blocks(v, contacts=1):
        A = np.eye(2 * contacts)
        return bipot.Problem(A=A, H=A, v_free=[-1, v] * contacts, mu=[0.5] * contacts)

    options = dict(solvers=["pgs"], tols=[1e-2], out=tmp_path / "rows", **QUICK)
    t = bipot.compare(blocks(0.75), **options)
    assert bipot.compare(blocks(0.75), **options)["cpu_min"].tolist() == t["cpu_min"].tolist()
    with pytest.raises(ValueError, match="problem_0 is not the one that the rows there were made for"):
        bipot.compare(blocks(0.1), **options)
    with pytest.raises(ValueError, match=r"made for \(2 rows, now 4\)"):
        bipot.compare(blocks(0.75, contacts=2), **options)


def test_warm_rows_follow_the_cold_ones(tmp_path, lattice):
    s = bipot.solve(lattice, tol=1e-8).s
    bipot.write(lattice, tmp_path / "p.hdf5", guesses=[s])
    t = bipot.compare(str(tmp_path / "p.hdf5"), solvers=["apgd"], tols=[1e-4], warm=True, **QUICK)
    assert t["warm"].tolist() == [0, 1]
    assert t["iterations"][1] == 0 < t["iterations"][0]
    direct = bipot.compare(bipot.read(tmp_path / "p.hdf5"), solvers=["apgd"], tols=[1e-4],
                           warm=True, **QUICK)
    assert direct["iterations"].tolist() == t["iterations"].tolist()


def test_targets_of_the_command_are_problems():
    ps = bipot.problems("square:5", "pyramid:4:mu=0.5")
    assert [p.name for p in ps] == ["square:5", "pyramid:4:mu=0.5"]
    assert ps[1].mu[0] == 0.5
    refused(ValueError, "side = 0", bipot.problems, "square:0")


def test_what_a_scene_leaves_out_is_a_warning(tmp_path, recwarn):
    scene = foreign_scene(tmp_path)
    for call in (
        lambda: bipot.compare([scene], tols=[1e-2], **QUICK),
        lambda: bipot.problems(str(scene)),
        lambda: bipot.advise(scene, time_limit=1),
    ):
        recwarn.clear()
        call()
        assert [str(w.message) for w in recwarn] == ["BODIES.DAT: 1 read, left out: 1 JONCx"]
        assert recwarn[0].filename == __file__ and recwarn[0].category is UserWarning
