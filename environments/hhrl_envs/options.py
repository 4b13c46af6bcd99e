"""The global option set (sub-goals), the same for every scenario."""

from enum import IntEnum


class Option(IntEnum):
    """A sub-goal of the option level: stop at the stop-line, or follow the front vehicle."""

    SSL = 0
    FFV = 1
