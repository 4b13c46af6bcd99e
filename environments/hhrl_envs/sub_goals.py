"""The sub-goals, each declared once, and how an episode ends.

Options and their masks, the state's elements, reward terms and hybrid rewards, words of the command line, names and
colours of pictures: all of them are derived from ``SUB_GOALS``. To add a sub-goal, add its ``Option`` and its
declaration here, its kernel in ``simulation.sub_goal_kernels`` and its controller in ``hhrl_agents.rules.controllers``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal


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
    """An element of the state.

    Attributes:
        symbol, unit, meaning: what it is called, measured in and stands for.
        scale: an observation is the SI value times it.
        clip: the values that it is clipped to, in words.
        noise: the kind of noise that a sensor adds to it: ``Sensor.noise_speed``, ``noise_accel`` or
            ``noise_distance``; None for what is known exactly and for what is computed from noisy elements.
        never_negative: whether a noisy value is clipped at 0.
    """

    symbol: str
    unit: str
    scale: float
    clip: str
    meaning: str
    noise: Literal["speed", "accel", "distance"] | None = None
    never_negative: bool = False


@dataclass(frozen=True)
class SubGoal:
    """A sub-goal of the option level.

    Attributes:
        option: its option; the code is its column in ``reward_option`` and ``reward_action``.
        name: the word for it on the command line and in files, such as ``"stop"``.
        title: what it asks for, such as "stop at the line".
        exists: whether a ``Scenario`` has it; where it does not, its option is masked.
        elements: the elements that it adds to the state.
        distance, critical, ratio: the symbols of three of them: its target distance d; d_c = d - d_s, where d_s is its
            safety distance; and d_c / d_s, floored and clipped. It is unsafe where d_c < 0, by -exp(-d_c / d_s) with
            that ratio, or as printed; see ``simulation.rewards``. The last two are computed from other elements; all
            else is measured.
        failure: the outcome that is its failure; of several in one step that with the lowest code counts.
        failure_title, failure_colour: how pictures show this outcome.
        target: what d reaches to, where pictures can show it on the road: "stop-line" or "front vehicle"; else None.
        colour: its colour in pictures, RGB as that of the failure.
    """

    option: Option
    name: str
    title: str
    exists: Callable[[Any], bool]
    elements: tuple[Element, ...]
    distance: str
    critical: str
    ratio: str
    failure: Outcome
    failure_title: str
    failure_colour: tuple[int, int, int]
    target: Literal["stop-line", "front vehicle"] | None
    colour: tuple[int, int, int]

    @property
    def spelling(self) -> str:
        """Its abbreviation in the paper, such as ``"SSL"``."""
        return self.option.name


def _has_line(scenario: Any) -> bool:
    return len(scenario.road.lines) > 0


def _has_traffic(scenario: Any) -> bool:
    return bool(scenario.traffic.max_fronts > 0)


_SPEED, _ACCEL, _JERK, _DISTANCE, _RATIO = 1 / 16, 1 / 8, 1 / 64, 1 / 64, 1 / 4

EGO_ELEMENTS = (
    Element("v_e", "m/s", _SPEED, "-", "speed of the ego", noise="speed", never_negative=True),
    Element("a_e", "m/s^2", _ACCEL, "-", "acceleration of the ego", noise="accel"),
    Element("j_e", "m/s^3", _JERK, "-", "jerk of the ego"),
)
"""The elements of the state that belong to no sub-goal; they come first."""

_TO_LINE = "distance to the active stop-line, negative past it; 100 m if there is none"
_STOPPING_SHARE = "the same as a share of the stopping distance, floored at 0.5 m"

SSL = SubGoal(
    option=Option.SSL,
    name="stop",
    title="stop at the line",
    exists=_has_line,
    elements=(
        Element("d_d", "m", _DISTANCE, "up to 100 m", _TO_LINE, noise="distance"),
        Element("d_dc", "m", _DISTANCE, "-", "d_d - d_ds, with d_ds = v_e^2 / (2 a_max)"),
        Element("d_dc/d_ds", "1", _RATIO, "[-1, 10]", _STOPPING_SHARE),
    ),
    distance="d_d",
    critical="d_dc",
    ratio="d_dc/d_ds",
    failure=Outcome.NOT_STOP,
    failure_title="NOT STOPPED",
    failure_colour=(150, 82, 122),
    target="stop-line",
    colour=(230, 159, 0),
)

_FRONT_GAP = "free road to the front vehicle's rear bumper"
_FRONT_SPEED = "speed of the front vehicle; the speed limit if none is in range"
_FRONT_ACCEL = "acceleration of the front vehicle; 0 if none is in range"

FFV = SubGoal(
    option=Option.FFV,
    name="follow",
    title="follow the front vehicle",
    exists=_has_traffic,
    elements=(
        Element("d_f", "m", _DISTANCE, "[0, sensor range]", _FRONT_GAP, noise="distance", never_negative=True),
        Element("v_f", "m/s", _SPEED, "-", _FRONT_SPEED, noise="speed", never_negative=True),
        Element("a_f", "m/s^2", _ACCEL, "-", _FRONT_ACCEL, noise="accel"),
        Element("d_fc", "m", _DISTANCE, "-", "d_f - d_fs, with d_fs = max((v_e^2 - v_f^2) / (2 a_max), d_0)"),
        Element("d_fc/d_fs", "1", _RATIO, "[-1, 10]", "the same as a share of the safety distance"),
    ),
    distance="d_f",
    critical="d_fc",
    ratio="d_fc/d_fs",
    failure=Outcome.COLLISION,
    failure_title="COLLISION",
    failure_colour=(213, 94, 0),
    target="front vehicle",
    colour=(0, 158, 115),
)

SUB_GOALS = (SSL, FFV)
"""All sub-goals, in the order of their options."""

STATE_ORDER = (FFV, SSL)
"""All sub-goals in the order of their elements in the state, Eq. (state). A new one comes last, so that a policy that
reads the elements of before reads the first ones."""
