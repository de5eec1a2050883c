"""What pickle calls to make problems and results again: it finds Python's functions alone."""

from . import _bipot


def problem_of(parts):
    return _bipot._problem_of_parts(parts)


def result_of(parts):
    return _bipot._result_of_parts(parts)
