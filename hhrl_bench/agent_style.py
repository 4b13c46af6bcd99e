"""What agents look like in figures: the same everywhere, told apart by colour, dashes and marker.

Needs the ``report`` extra.
"""

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import NamedTuple

from hhrl_bench import figures as fig
from hhrl_bench.curve_style import Dashes, Line


class Look(NamedTuple):
    """Colour, dashes of the line, and a marker that can be filled."""

    colour: str
    dashes: Dashes
    marker: str


_LOOKS: Mapping[str, Look] = {
    "rule-1": Look(fig.GREY, "-", "<"),
    "rule-2": Look(fig.GREY, "--", ">"),
    "rule-3": Look(fig.GREY, "-.", "v"),
    "rule-4": Look(fig.GREY, ":", "^"),
    "rule-plus": Look(fig.INK, ":", "p"),
    "ddqn": Look(fig.INK, "-", "s"),
    "ddqn-plus": Look(fig.GREY, "--", "h"),
    "hrl-0": Look(fig.SKY, ":", "P"),
    "hrl-1": Look(fig.GREEN, "-.", "8"),
    "hrl-2": Look(fig.ORANGE, "--", "H"),
    "hrl-3": Look(fig.PURPLE, "-.", "*"),
    "hybrid-hrl": Look(fig.BLUE, "-", "o"),
    "hybrid-hrl-plus": Look(fig.VERMILLION, "-", "D"),
    "pqn": Look(fig.GREEN, ":", "X"),
    "ppo": Look(fig.ORANGE, ":", "P"),
}
_UNLIKE: tuple[tuple[Dashes, str], ...] = (("--", "H"), (":", "d"), ("-.", "8"))
_OTHERS = [
    Look(colour, dashes, marker)
    for dashes, marker in _UNLIKE
    for colour in (fig.BLUE, fig.VERMILLION, fig.PURPLE, fig.SKY)
]


def looks(agents: Sequence[str]) -> dict[str, Look]:
    """Return what each agent looks like; those that are not registered take in turn what is left."""
    others = cycle(_OTHERS)
    return {agent: _LOOKS.get(agent) or next(others) for agent in in_order(agents)}


def in_order(agents: Sequence[str]) -> list[str]:
    """Return the agents, each once: rules, then methods, then the others as they come."""
    known = [agent for agent in _LOOKS if agent in agents]
    return [*known, *(agent for agent in dict.fromkeys(agents) if agent not in _LOOKS)]


def lines(agents: Sequence[str]) -> dict[str, Line]:
    """Return the line of each agent."""
    return {agent: Line(agent, look.colour, look.dashes) for agent, look in looks(agents).items()}
