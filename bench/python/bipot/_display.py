"""What a notebook shows of an object."""

from html import escape

from ._bipot import Problem, Result, SphereState, SphereStep, State, Step


def table(title, rows):
    """A table of HTML from pairs."""
    cells = "".join(
        f"<tr><th style='text-align:left'>{escape(name)}</th>"
        f"<td style='text-align:left'>{escape(str(value))}</td></tr>"
        for name, value in rows
    )
    return f"<table><caption>{escape(title)}</caption>{cells}</table>"


def _counts(x):
    return f"{x.take_off} open, {x.stick} stick, {x.slip} slip"


def _of_problem(p):
    mu = p.mu
    friction = f"{mu.min():g} to {mu.max():g}" if len(mu) else "no contacts"
    given = [name for name in ("A", "H", "W") if getattr(p, name) is not None]
    return table(
        f"bipot.Problem {p.name}",
        [
            ("contacts", p.num_contacts),
            ("rows of a contact", p.dim),
            ("degrees of freedom", p.num_dofs or "not given"),
            ("friction", friction),
            ("matrices", ", ".join(given)),
            ("restitution", "none" if p.row_scale is None else "in row_scale"),
        ],
    )


def _of_result(r):
    return table(
        f"bipot.Result of {r.solver}",
        [
            ("status", f"{r.status}: {r.message}"),
            ("error", f"{r.guarded:.2e} (tolerance {r.tol:g})"),
            ("contacts", _counts(r)),
            ("iterations", r.iterations),
            ("time", f"{r.setup_seconds + r.solve_seconds:.3g} s"),
        ],
    )


def _of_state(s):
    return table(
        f"bipot.{type(s).__name__} {s.step}",
        [("t", f"{s.time:g} s"), ("bodies", len(s.radii)), ("contacts", len(s.contacts))],
    )


def _of_step(s):
    energies = ", ".join(f"{name} {value:.3g}" for name, value in s.energy.items())
    return table(
        f"bipot.{type(s).__name__} {s.step}",
        [
            ("t", f"{s.time:g} s"),
            ("bodies", len(s.radii)),
            ("contacts", len(s.contacts)),
            ("status", "converged" if s.converged else s.message),
            ("error", f"{s.guarded:.2e}"),
            ("largest overlap", f"{s.penetration:.2e} m"),
            ("energy [J]", energies),
        ],
    )


Problem._repr_html_ = _of_problem
Result._repr_html_ = _of_result
State._repr_html_ = SphereState._repr_html_ = _of_state
Step._repr_html_ = SphereStep._repr_html_ = _of_step
State.__repr__ = SphereState.__repr__ = lambda s: (
    f"<bipot.{type(s).__name__} {s.step} at t = {s.time:g} s: {len(s.radii)} bodies>"
)
