"""Seeds: disjoint ranges of worlds, and the spelling ``0-4,7`` of training seeds."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from hhrl_bench.errors import SeedError
from hhrl_envs.arrays import Keys

RANGE_SIZE = 10**9
MAX_TRAINING_SEED = 999
MAX_COUNT = 10**5


@dataclass(frozen=True, slots=True)
class SeedRange:
    """The half-open range of world seeds [start, start + size) under a name."""

    name: str
    start: int
    size: int = RANGE_SIZE

    def take(self, count: int, offset: int = 0) -> Keys:
        """Return the world seeds ``start + offset + i`` for i in 0 .. count - 1, uint64 [count].

        Raises:
            SeedError: if that is none, more than 100,000, or runs past the range.
        """
        if not 1 <= count <= MAX_COUNT:
            raise SeedError(f"cannot take {count} {self.name} seeds; ask for 1 to {MAX_COUNT}")
        if not 0 <= offset <= self.size - count:
            raise SeedError(f"{count} {self.name} seeds from {offset} on run past the range of {self.size}")
        return np.arange(self.start + offset, self.start + offset + count, dtype=np.uint64)


def consecutive_ranges(*names: str) -> tuple[SeedRange, ...]:
    """Return one range a name, each beginning where the one before it ends: disjoint by construction."""
    return tuple(SeedRange(name, i * RANGE_SIZE) for i, name in enumerate(names))


def parse_seeds(text: str) -> tuple[int, ...]:
    """Return the training seeds that a spelling such as ``0-4,7`` names, ascending.

    Raises:
        SeedError: if the spelling is none, a seed comes twice or lies outside 0 .. 999.
    """
    seeds = [seed for part in text.split(",") for seed in _parse_part(part, text)]
    if len(set(seeds)) != len(seeds):
        raise SeedError(f"seeds {text!r} name a seed twice; name each seed once")
    return tuple(sorted(seeds))


def _parse_part(part: str, text: str) -> range:
    match = re.fullmatch(r"\s*([0-9]{1,9})(?:-([0-9]{1,9}))?\s*", part)
    if match is None:
        raise SeedError(f"cannot read seeds {text!r}; write numbers and ranges such as 0-4,7")
    first = int(match[1])
    last = int(match[2] or first)
    if last < first:
        raise SeedError(f"seeds {text!r} hold the falling range {part.strip()}; write {last}-{first}")
    if last > MAX_TRAINING_SEED:
        raise SeedError(f"seeds {text!r} go past {MAX_TRAINING_SEED}; write seeds of 0 to {MAX_TRAINING_SEED}")
    return range(first, last + 1)


def format_seeds(seeds: Sequence[int]) -> str:
    """Return the shortest spelling of ascending seeds, such as ``0-4,7``: the inverse of :func:`parse_seeds`."""
    parts = []
    for _, group in groupby(enumerate(seeds), key=lambda pair: pair[1] - pair[0]):
        run = [seed for _, seed in group]
        parts.append(f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]))
    return ",".join(parts)
