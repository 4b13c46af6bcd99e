"""Differences between what a record says and what it should say, each with its place."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from hhrl_envs.errors import one_line


class Finding(NamedTuple):
    """Something in an entry that does not hold: where, such as ``results[2].metrics.success.mean``, and what."""

    place: str
    said: str

    def __str__(self) -> str:
        return one_line(f"{self.place}: {self.said}")


def differences(place: str, published: Any, found: Any) -> Iterator[Finding]:
    """Return a finding for every number or word in which ``found`` differs from ``published``, both plain data.

    Numbers are equal if they are spelled so: 1 is not 1.0, and -0.0 is not 0.0.
    """
    if isinstance(published, Mapping) and isinstance(found, Mapping):
        for key in dict.fromkeys([*published, *found]):
            yield from differences(f"{place}.{key}" if place else key, published.get(key), found.get(key))
    elif _is_list(published) and _is_list(found) and len(published) == len(found):
        for index, (one, other) in enumerate(zip(published, found, strict=True)):
            yield from differences(f"{place}[{index}]", one, other)
    elif repr(published) != repr(found):
        yield Finding(place, f"{_short(published)} is published, {_short(found)} was found")


def _is_list(value: object) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _short(value: object) -> str:
    text = "nothing" if value is None else str(value)
    return text if len(text) <= 80 else text[:77] + "..."
