"""Refusal of unknown options with the nearest name, and of wrong types with the right one."""

import functools
import inspect
import math
import operator
import os
import reprlib

from . import _bipot

# What other programs call it.
_SYNONYMS = {
    "tol": "tolerance eps epsilon precision accuracy rtol atol abs_tol rel_tol",
    "tols": "tol tolerance tolerances",
    "max_iterations": "max_iter maxiter max_iters maxiters itermax iter_max iterations num_iterations",
    "time_limit": "timeout max_time maxtime time_out",
    "s0": "x0 initial guess start initial_guess warm_start",
    "solver": "method algorithm",
    "solvers": "methods solver",
    "callback": "on_iteration monitor",
    "threads": "num_threads n_threads n_jobs workers processes",
    "mu": "friction friction_coefficient friction_coefficients mu_s coulomb",
    "friction": "mu mu_s friction_coefficient",
    "restitution": "e e_n en cor restitution_coefficient",
    "A": "mass mass_matrix inertia a",
    "J": "jacobian Jc jac j",
    "W": "delassus G w",
    "H": "h wrench",
    "u_free": "q u0 bias free_velocity",
    "v_free": "v v0 v_star velocity",
    "v_before": "v_minus velocity_before",
    "u_before": "u_minus",
    "dim": "d dimension",
    "step": "dt h step_size timestep time_step",
    "num_steps": "steps n_steps nsteps",
    "force_error": "force forces",
    "s": "solution impulse",
    "guesses": "guess",
}


def refuse_unknown(given, valid):
    """Raises TypeError for the first name of `given` that is not in `valid`."""
    for name in given:
        if name in valid:
            continue
        for known, others in _SYNONYMS.items():
            if known in valid and name in others.split():
                raise TypeError(
                    f"unknown option '{name}'; did you mean '{known}'? Valid: {', '.join(valid)}"
                )
        raise TypeError(_bipot.unknown_name_message("option", name, list(valid)))


def named_options(function):
    """Unknown keywords of `function` are refused with the nearest of its own."""
    valid = [
        p.name
        for p in inspect.signature(function).parameters.values()
        if p.kind == p.KEYWORD_ONLY
    ]
    known = set(inspect.signature(function).parameters)

    @functools.wraps(function)
    def checked(*arguments, **options):
        refuse_unknown([name for name in options if name not in known], valid)
        return function(*arguments, **options)

    return checked


def wrong_type(name, expected, value):
    """The TypeError of a value."""
    return TypeError(
        f"{name}: expected {expected}, got {type(value).__name__} {reprlib.repr(value)}"
    )


def number(value, name):
    if type(value) is float:  # a solve of one contact takes microseconds
        return value
    if not isinstance(value, (str, bytes, bool)):
        try:
            return float(value)
        except (TypeError, ValueError):
            pass
    raise wrong_type(name, "a number", value)


def integer(value, name):
    if type(value) is int:
        return _in_32_bits(value, name)
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, bool):
        try:
            return _in_32_bits(operator.index(value), name)
        except TypeError:
            pass
    raise wrong_type(name, "an integer", value)


def _in_32_bits(value, name):
    if -(2**31) < value < 2**31:
        return value
    raise ValueError(f"{name} = {value} is beyond {2**31 - 1}")


def text(value, name):
    if not isinstance(value, str):
        raise wrong_type(name, "a text", value)
    return value


def flag(value, name):
    if not isinstance(value, bool) and type(value).__name__ not in ("bool_", "bool"):
        raise wrong_type(name, "True or False", value)
    return bool(value)


def positive(value, name):
    value = number(value, name)
    if not 0 < value < math.inf:
        raise ValueError(f"{name} = {value}: expected a positive number")
    return value


def not_negative(value, name):
    value = number(value, name)
    if not 0 <= value < math.inf:
        raise ValueError(f"{name} = {value}: expected a number that is not negative")
    return value


def count(value, name, least=1, most=2**31 - 1):
    """An integer between the two, both included."""
    value = integer(value, name)
    if not least <= value <= most:
        raise ValueError(f"{name} = {value}: expected an integer from {least} to {most}")
    return value


def optional(check, value, name):
    """None, or a value that passes the check."""
    return None if value is None else check(value, name)


def a_problem(value, name="problem"):
    if not isinstance(value, _bipot.Problem):
        raise wrong_type(name, "a bipot.Problem", value)
    return value


def parameter_texts(parameters):
    """Values of solver parameters as the texts that solvers read; numbers to the last bit."""
    texts = {}
    for name, value in parameters.items():
        if isinstance(value, (str, os.PathLike)):
            texts[name] = os.fspath(value)
        elif isinstance(value, bool) or not hasattr(value, "__float__"):
            raise TypeError(f"parameter {name} = {value!r}: expected a number or a text")
        else:
            number = float(value)
            texts[name] = str(int(number)) if number.is_integer() else repr(number)
    return texts


def solver_name(solver):
    """Name of a solver, or of a callable."""
    if not isinstance(solver, str) and not callable(solver):
        raise wrong_type("solver", "a name or a callable", solver)
    return solver if isinstance(solver, str) else _bipot.name_of_callable(solver)
