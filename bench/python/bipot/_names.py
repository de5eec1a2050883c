"""Refusal of unknown options, with the nearest name."""

import functools
import inspect

from . import _bipot


def refuse_unknown(given, valid):
    """Raises TypeError for the first name of `given` that is not in `valid`."""
    for name in given:
        if name not in valid:
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


def parameter_texts(parameters):
    """Values of solver parameters as the texts that solvers read; numbers to the last bit."""
    texts = {}
    for name, value in parameters.items():
        if isinstance(value, str):
            texts[name] = value
        elif isinstance(value, bool) or not hasattr(value, "__float__"):
            raise TypeError(f"parameter {name} = {value!r}: expected a number or a text")
        else:
            number = float(value)
            texts[name] = str(int(number)) if number.is_integer() else repr(number)
    return texts


def solver_name(solver):
    """Name of a solver, or of a callable."""
    return solver if isinstance(solver, str) else _bipot.name_of_callable(solver)
