"""The sub-goals, each declared once, and how an episode ends.

Options and their masks, the state's elements, reward terms and hybrid rewards, words of the command line, names and
colours of pictures: all of them are derived from ``SUB_GOALS``. To add a sub-goal, add its ``Option`` and its
declaration here, its kernel in ``simulation.sub_goal_kernels`` and its controller in ``hhrl_agents.rules.controllers``.
"""

from dataclasses import dataclass
from enum import IntEnum


class Option(IntEnum):
    """What the option level chooses: the place of a sub-goal in ``SUB_GOALS``."""

    SSL = 0
    FFV = 1


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


@dataclass(frozen=True)
class Element:
    """An element of the state: symbol, unit, scale (an observation is the SI value times it), clip and meaning."""

    symbol: str
    unit: str
    scale: float
    clip: str
    meaning: str


@dataclass(frozen=True)
class SubGoal:
    """A sub-goal of the option level.

    Attributes:
        option: its option; the code is its column in ``reward_option`` and ``reward_action``.
        name: the word for it on the command line and in files, such as ``"stop"``.
        title: what it asks for, such as "stop at the stop-line".
        elements: the elements that it adds to the state.
        distance, critical, ratio: the symbols of three of them: its target distance d; d_c = d - d_s, where d_s is its
            safety distance; and d_c / d_s. It is unsafe where d_c < 0, by -exp(-d_c / d_s).
        failure: the outcome that is its failure.
        colour: its colour in pictures, RGB.
    """

    option: Option
    name: str
    title: str
    elements: tuple[Element, ...]
    distance: str
    critical: str
    ratio: str
    failure: Outcome
    colour: tuple[int, int, int]

    @property
    def spelling(self) -> str:
        """Its abbreviation in the paper, such as ``"SSL"``."""
        return self.option.name


_SPEED, _ACCEL, _JERK, _DISTANCE, _RATIO = 1 / 16, 1 / 8, 1 / 64, 1 / 64, 1 / 4

EGO_ELEMENTS = (
    Element("v_e", "m/s", _SPEED, "-", "speed of the ego"),
    Element("a_e", "m/s^2", _ACCEL, "-", "acceleration of the ego"),
    Element("j_e", "m/s^3", _JERK, "-", "jerk of the ego"),
)
"""The elements of the state that belong to no sub-goal; they come first."""

SSL = SubGoal(
    option=Option.SSL,
    name="stop",
    title="stop at the stop-line",
    elements=(
        Element("d_d", "m", _DISTANCE, "up to 100 m", "distance to the active stop-line; 100 m if there is none"),
        Element("d_dc", "m", _DISTANCE, "-", "d_d - d_ds, with d_ds = v_e^2 / (2 a_max)"),
        Element("d_dc/d_ds", "1", _RATIO, "[-1, 10]", "the same as a share of the stopping distance, at least 0.5 m"),
    ),
    distance="d_d",
    critical="d_dc",
    ratio="d_dc/d_ds",
    failure=Outcome.NOT_STOP,
    colour=(230, 159, 0),
)

FFV = SubGoal(
    option=Option.FFV,
    name="follow",
    title="follow the front vehicle",
    elements=(
        Element("d_f", "m", _DISTANCE, "[0, sensor range]", "free road to the front vehicle's rear bumper"),
        Element("v_f", "m/s", _SPEED, "-", "speed of the front vehicle; the speed limit if none is in range"),
        Element("a_f", "m/s^2", _ACCEL, "-", "acceleration of the front vehicle; 0 if none is in range"),
        Element("d_fc", "m", _DISTANCE, "-", "d_f - d_fs, with d_fs = max((v_e^2 - v_f^2) / (2 a_max), d_0)"),
        Element("d_fc/d_fs", "1", _RATIO, "[-1, 10]", "the same as a share of the safety distance"),
    ),
    distance="d_f",
    critical="d_fc",
    ratio="d_fc/d_fs",
    failure=Outcome.COLLISION,
    colour=(0, 158, 115),
)

SUB_GOALS = (SSL, FFV)
"""All sub-goals, in the order of their options."""

STATE_ORDER = (FFV, SSL)
"""All sub-goals in the order of their elements in the state, Eq. (state). A new one comes last, so that a policy that
reads the elements of before reads the first ones."""
