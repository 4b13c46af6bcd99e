"""What the fields of a scenario's parts may hold, declared one rule a field; a bad value is refused in one line.

``check(part, field=rule, ...)`` refuses a field alone, ``agree`` fields that contradict each other. Numbers are
Python's or numpy's, never booleans, and always finite; numpy's are kept as Python's, so that no narrow one overflows.
Sequences are tuples, so that scenarios stay hashable.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from operator import attrgetter
from typing import Any

import numpy as np

from hhrl_envs.errors import InputError

LONGEST = 80  # characters of a value that a message shows


@dataclass(frozen=True)
class Rule:
    """Whether a value is allowed, and in words what to write instead."""

    holds: Callable[[Any], bool]
    allowed: str


def check(part: object, label: str | None = None, /, **rules: Rule) -> None:
    """Refuse the first field of ``part`` that breaks its rule, and keep numbers of numpy as Python's.

    The message begins with ``label``, by default the name of the part's class, and the field's name; a ``{}`` in the
    label stands for the field's name.

    Raises:
        InputError: naming the field, its value and what to write instead.
    """
    for field, rule in rules.items():
        value = getattr(part, field)
        if not rule.holds(value):
            raise _refusal(part, label, (field,), rule.allowed)
        if isinstance(value, np.generic | tuple):
            object.__setattr__(part, field, _as_python(value))


def agree(part: object, holds: bool, *fields: str, write: str, label: str | None = None) -> None:
    """Refuse ``fields`` that contradict each other: unless ``holds``, raise an ``InputError`` that names them.

    For ``label`` see ``check``.
    """
    if not holds:
        raise _refusal(part, label, fields, write)


def is_integer(value: object) -> bool:
    """Return whether the value is an integer of Python or numpy, not a boolean."""
    return isinstance(value, (int, np.integer)) and not isinstance(value, bool)


def is_number(value: object, low: float, high: float) -> bool:
    """Return whether the value is a number, not a boolean, within [low, high]; NaN is not."""
    plain = value.item() if isinstance(value, np.generic) else value
    return isinstance(plain, (int, float)) and not isinstance(plain, bool) and low <= plain <= high


def number(low: float, high: float, unit: str) -> Rule:
    """Return the rule of a number within [low, high]."""
    return Rule(lambda value: is_number(value, low, high), f"{unit} from {_plain(low)} to {_plain(high)}")


def integer(low: float, high: float, unit: str) -> Rule:
    """Return the rule of an integer within [low, high]."""
    return Rule(
        lambda value: is_integer(value) and low <= value <= high,
        f"an integer from {_plain(low)} to {_plain(high)} ({unit})",
    )


def flag() -> Rule:
    """Return the rule of a boolean."""
    return Rule(lambda value: isinstance(value, (bool, np.bool_)), "True or False")


def interval(low: float, high: float, unit: str) -> Rule:
    """Return the rule of a tuple of two numbers with low <= first <= second <= high."""
    allowed = f"a tuple (low, high) in {unit} with {_plain(low)} <= low <= high <= {_plain(high)}"
    return Rule(lambda value: _numbers(value, 2, 2, low, high) and value[0] <= value[1], allowed)


def ascending(least: int, most: int, low: float, high: float, allowed: str) -> Rule:
    """Return the rule of a tuple of ``least`` to ``most`` numbers within [low, high], each above the one before."""
    known = f"a tuple of {allowed}, ascending from {_plain(low)} to {_plain(high)}"
    return Rule(lambda value: _numbers(value, least, most, low, high) and all(a < b for a, b in pairwise(value)), known)


def shares(least: int, most: int, allowed: str) -> Rule:
    """Return the rule of a tuple of ``least`` to ``most`` shares that add up to 1."""
    known = f"a tuple of {allowed}, which add up to 1"
    return Rule(lambda value: _numbers(value, least, most, 0.0, 1.0) and abs(sum(value) - 1.0) < 1e-9, known)


def text(pattern: str, allowed: str) -> Rule:
    """Return the rule of a string that matches the pattern as a whole."""
    return Rule(lambda value: isinstance(value, str) and re.fullmatch(pattern, value) is not None, allowed)


def one_of(*names: str) -> Rule:
    """Return the rule of a string that is one of these."""
    return Rule(lambda value: isinstance(value, str) and value in names, f"one of: {', '.join(names)}")


def instance(kind: type) -> Rule:
    """Return the rule of an instance of a class; of an enumeration, its members are named."""
    members = [f"{kind.__name__}.{member.name}" for member in kind] if issubclass(kind, Enum) else None
    allowed = f"one of {', '.join(members)}" if members else f"{kind.__name__}(...)"
    return Rule(lambda value: isinstance(value, kind), allowed)


def instances(kind: type) -> Rule:
    """Return the rule of a tuple of at least one instance of a class."""
    allowed = f"a tuple of at least one {kind.__name__}, such as ({kind.__name__}(...),)"
    return Rule(lambda v: isinstance(v, tuple) and len(v) > 0 and all(isinstance(one, kind) for one in v), allowed)


def optional(rule: Rule) -> Rule:
    """Return the rule of None, or of what another rule allows."""
    return Rule(lambda value: value is None or rule.holds(value), f"None or {rule.allowed}")


def _as_python(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_as_python(one) for one in value)
    return value.item() if isinstance(value, np.generic) else value


def _numbers(value: Any, least: int, most: int, low: float, high: float) -> bool:
    known = isinstance(value, tuple) and least <= len(value) <= most
    return known and all(is_number(one, low, high) for one in value)


def _refusal(part: object, label: str | None, fields: tuple[str, ...], write: str) -> InputError:
    label = f"{type(part).__name__}." if label is None else label
    first = label.replace("{}", fields[0], 1) if "{}" in label else label + fields[0]
    given = (
        f"{name} is {_shown(attrgetter(field)(part))}" for name, field in zip((first, *fields[1:]), fields, strict=True)
    )
    return InputError(f"{' and '.join(given)}; write {write}")


def _shown(value: object) -> str:
    value = getattr(value, "id", value)  # a scenario or a method is shown by its id
    shown = f"{type(value).__name__}.{value.name}" if isinstance(value, Enum) else " ".join(repr(value).splitlines())
    return shown if len(shown) <= LONGEST else f"{shown[:LONGEST]}..."


def _plain(value: float) -> str:
    return f"{value:.10g}"
