"""Changes of JSON data and of bytes, for tests of whether they are noticed."""

import json
import string
from collections.abc import Iterator
from typing import Any

import numpy as np

Place = tuple[str | int, ...]


def leaves(data: Any, place: Place = ()) -> Iterator[Place]:
    """The places of all numbers, words and nulls."""
    if not isinstance(data, dict | list):
        yield place
        return
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        yield from leaves(value, (*place, key))


def at(data: Any, place: Place) -> Any:
    """What stands at a place."""
    for key in place:
        data = data[key]
    return data


def put(data: Any, place: Place, value: object) -> Any:
    """A copy of the data with this value at a place."""
    if not place:
        return value
    changed: Any = dict(data) if isinstance(data, dict) else list(data)
    changed[place[0]] = put(data[place[0]], place[1:], value)
    return changed


def spelt(place: Place) -> str:
    """A place as a finding spells it."""
    return "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in place).removeprefix(".")


def other(value: Any, rng: np.random.Generator) -> Any:
    """A number, word or hash that differs by a digit; the other bool; a number for null."""
    if value is None:
        return 1
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return _other_digit(value, string.hexdigits[:16], rng)
    for _ in range(100):
        try:
            changed = json.loads(_other_digit(json.dumps(value), string.digits, rng))
        except ValueError:  # 0 may not lead
            continue
        if changed != value:
            return changed
    return 1


def _other_digit(text: str, digits: str, rng: np.random.Generator) -> str:
    places = [i for i, char in enumerate(text) if char in digits]
    if not places:
        return text + "x"
    place = rng.choice(places)
    digit = rng.choice([digit for digit in digits if digit != text[place]])
    return f"{text[:place]}{digit}{text[place + 1 :]}"
