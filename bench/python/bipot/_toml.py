"""A scene that Python has as a dictionary, as the text of a scene file."""

import json
import math
import os

from ._names import wrong_type


def to_toml(scene):
    """Tables and lists of tables get a heading; all else stands in a line."""
    lines, tables = [], []
    for key, value in scene.items():
        if isinstance(value, dict):
            tables.append((f"[{_key(key)}]", key, value))
        elif isinstance(value, (list, tuple)) and value and isinstance(value[0], dict):
            tables += [(f"[[{_key(key)}]]", key, item) for item in value]
        else:
            lines.append(f"{_key(key)} = {_value(value, key)}")
    for heading, key, table in tables:
        if not isinstance(table, dict):
            raise wrong_type(key, "a list of dictionaries", table)
        lines.append(heading)
        lines += [f"{_key(name)} = {_value(value, f'{key}.{name}')}" for name, value in table.items()]
    return "\n".join(lines) + "\n"


def _key(key):
    if not isinstance(key, str):
        raise wrong_type("scene", "texts as keys", key)
    return _text(key)


def _text(value):
    """TOML escapes one character more than JSON."""
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value, key, depth=0):
    if hasattr(value, "tolist"):  # of numpy
        value = value.tolist()
    if depth > 8:
        raise ValueError(f"{key}: nested too deeply")
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, (str, os.PathLike)):
        return _text(os.fspath(value))
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_value(item, key, depth + 1) for item in value) + "]"
    if isinstance(value, dict):
        inside = (f"{_key(k)} = {_value(v, f'{key}.{k}', depth + 1)}" for k, v in value.items())
        return "{" + ", ".join(inside) + "}"
    raise wrong_type(key, "a number, a text, a truth value, a list or a dictionary", value)
