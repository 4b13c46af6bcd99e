"""The codes of an episode: its options, what it asks of the ego, and how it ends."""

from enum import IntEnum


class Option(IntEnum):
    """A sub-goal of the option level: stop at the stop-line, or follow the front vehicle."""

    SSL = 0
    FFV = 1


class Goal(IntEnum):
    """What SUCCESS means: a stop at the last line, reaching the end of the route, or following until the horizon."""

    STOP = 0
    PASS = 1
    FOLLOW = 2


STOP, PASS, FOLLOW = (int(goal) for goal in Goal)


class Outcome(IntEnum):
    """The state of an episode. TIMEOUT truncates it, every other outcome terminates it.

    Where several hold in one step the earlier one in this list counts. REAR_ENDED befalls learned front vehicles only,
    and is not their fault. An adversary's episode ends with the ego's: in SUCCESS if the ego failed although it need
    not have, else FOILED.
    """

    RUNNING = 0
    COLLISION = 1
    NOT_STOP = 2
    SUCCESS = 3
    TIMEOUT = 4
    REAR_ENDED = 5
    FOILED = 6


RUNNING, COLLISION, NOT_STOP, SUCCESS, TIMEOUT, REAR_ENDED, FOILED = (float(outcome) for outcome in Outcome)
