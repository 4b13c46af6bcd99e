"""Names and colours that the figures of an analysis share. Needs the ``report`` extra."""

from matplotlib.axes import Axes

from hhrl_bench import figures as fig
from hhrl_bench.analysis_records import LevelName, TermName
from hhrl_bench.records import OptionName
from hhrl_envs.observation import SYMBOLS

OPTION_NAMES: dict[OptionName, str] = {"stop": "stop at the line (SSL)", "follow": "follow the front vehicle (FFV)"}
OPTION_COLOURS: dict[OptionName, str] = {"stop": fig.ORANGE, "follow": fig.GREEN}
LEVEL_NAMES: dict[LevelName, str] = {"option": "$r^{option}$", "action": "$r^{action}$", "task": "$r^{task}$"}
LEVEL_WIDTHS: dict[LevelName, float] = {"option": 3.6, "action": 1.4, "task": 1.6}  # one is seen below the other
LEVEL_COLOURS: dict[LevelName, str] = {"option": fig.BLUE, "action": fig.VERMILLION, "task": fig.GREY}
TERM_NAMES: dict[TermName, str] = {
    "sub_goal": "sub-goal: time, success, timeout",
    "unsafe": "unsafe",
    "failure": "failure",
    "jerk": "jerk",
}
TERM_COLOURS: dict[TermName, str] = {
    "sub_goal": fig.SKY, "unsafe": fig.YELLOW, "failure": fig.VERMILLION, "jerk": fig.PURPLE
}  # fmt: skip


def label_weights(axes: Axes) -> None:
    """Return nothing; label the rows of a map of weights with the state elements, the first one on top."""
    axes.set_yticks(range(len(SYMBOLS)), [symbol(i) for i in range(len(SYMBOLS))])
    axes.tick_params(axis="y", length=0)


def symbol(index: int) -> str:
    """Return a state element's symbol as mathematics."""
    parts = [part.split("_") for part in SYMBOLS[index].split("/")]
    return "$" + "/".join(f"{letter}_{{{below}}}" for letter, below in parts) + "$"


def outline(axes: Axes) -> None:
    """Return nothing; draw all four sides of a map."""
    for side in axes.spines.values():
        side.set_visible(True)
