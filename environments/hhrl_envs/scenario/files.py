"""Scenarios as JSON: what a file holds is the dataclass, key by key, and nothing else is read from it.

A key that is left out has the default of its field. Tuples are lists, a goal is its name, such as "STOP".
"""

import json
from collections.abc import Callable, Sequence
from dataclasses import MISSING, asdict, fields, is_dataclass
from difflib import get_close_matches
from enum import Enum
from pathlib import Path
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from hhrl_envs.errors import InputError
from hhrl_envs.scenario.scenario import Scenario

Read = TypeVar("Read")

LONGEST = 1 << 20
"""Most bytes of a scenario file."""


def scenario_to_json(scenario: Scenario) -> str:
    """Return a scenario as indented JSON, from which :func:`scenario_from_json` makes an equal one."""
    return json.dumps(_plain(asdict(scenario)), indent=2, allow_nan=False)


def scenario_from_json(text: str) -> Scenario:
    """Return the scenario that a JSON text holds.

    Raises:
        InputError: naming the first key that is unknown, missing or given twice, or value that has no meaning.
    """
    scenario: Scenario = _made(Scenario, read_json(text), "")
    return scenario


def read_scenario(path: str | Path) -> Scenario:
    """Return the scenario in a JSON file.

    Raises:
        InputError: as :func:`scenario_from_json`, with the file's name; or if it cannot be read.
    """
    return read_file(path, scenario_from_json, "a scenario file, such as hhrl-bench scenario show stop-line-v0 prints")


def read_file(path: str | Path, read: Callable[[str], Read], what: str) -> Read:
    """Return what ``read`` makes of the text of a file, which should be ``what``.

    Raises:
        InputError: with the file's name.
    """
    try:
        with Path(path).open("rb") as file:
            content = file.read(LONGEST + 1)
        text = content.decode()
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}; name {what}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path} is no text in UTF-8; name {what}") from error
    if len(content) > LONGEST:
        raise InputError(f"{path} has more than {LONGEST:,} bytes; name {what}")
    try:
        return read(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def read_json(text: str) -> Any:
    """Return the data of a JSON text; raise an ``InputError`` for another one, for NaN, or a key given twice."""
    try:
        return json.loads(text, object_pairs_hook=_unique, parse_constant=_refuse_constant)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"this is no JSON: {error}") from error


def _require_keys(data: Any, known: Sequence[str], required: Sequence[str], place: str) -> None:
    """Raise an ``InputError`` unless ``data`` is an object with the required keys, and others of the known ones."""
    where = place or "it"
    if not isinstance(data, dict):
        raise InputError(f"{where} is {_shown(data)}; write an object with the keys {', '.join(known)}")
    for key in data:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            meant = f", did you mean {near[0]!r}; write" if near else "; write"
            raise InputError(f"{where} has the unknown key {key!r}{meant} some of: {', '.join(known)}")
    missing = [key for key in required if key not in data]
    if missing:
        raise InputError(f"{where} lacks {missing[0]!r}; add it")


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, tuple):
        return [_plain(one) for one in value]
    return value.name if isinstance(value, Enum) else value


def _made(kind: type, data: Any, place: str) -> Any:
    """Return the instance of a dataclass that holds this data, each value as its field's type asks for it."""
    declared = {field.name: field for field in fields(kind)}
    required = [name for name, field in declared.items() if field.default is MISSING]
    _require_keys(data, list(declared), required, place)
    hints = get_type_hints(kind)
    inside = f"{place}." if place else ""
    values = {key: _value(hints[key], value, inside + key) for key, value in data.items()}
    try:
        return kind(**values)
    except InputError as error:  # which speaks of classes and tuples, where a file has keys and lists
        said = str(error).replace(f"{kind.__name__}.", inside, 1).replace("write a tuple", "write a list")
        raise InputError(said) from error


def _value(hint: Any, value: Any, place: str) -> Any:
    """Return a value as a type asks for it; one of another kind as it is, for the dataclass to refuse."""
    if get_origin(hint) is UnionType:
        (hint,) = [one for one in get_args(hint) if one is not type(None)]
        return None if value is None else _value(hint, value, place)
    if get_origin(hint) is tuple and isinstance(value, list):
        return tuple(_value(get_args(hint)[0], one, f"{place}[{i}]") for i, one in enumerate(value))
    if is_dataclass(hint) and isinstance(hint, type):
        return _made(hint, value, place)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _member(hint, value, place)
    return value


def _member(kind: type[Enum], value: Any, place: str) -> Enum:
    if not isinstance(value, str) or value not in kind.__members__:
        names = ", ".join(map(repr, kind.__members__))
        raise InputError(f"{place} is {_shown(value)}; write one of: {names}")
    return kind[value]


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        twice = next(key for i, (key, _) in enumerate(pairs) if key in dict(pairs[:i]))
        raise InputError(f"the key {twice!r} is given twice; give it once")
    return data


def _refuse_constant(name: str) -> None:
    raise InputError(f"{name} is no number; write a finite one")


def _shown(value: Any) -> str:
    shown = repr(value)
    return shown if len(shown) <= 80 else f"{shown[:80]}..."
