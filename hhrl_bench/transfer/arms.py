"""The arms of a transfer: what a training in the target takes over from the source, and what of it stays fixed."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from hhrl_agents.methods.method import Method
from hhrl_envs import Scenario

ArmName = Literal["zero-shot", "frozen-action", "fine-tune", "scratch"]

CONTROL: ArmName = "scratch"


@dataclass(frozen=True, slots=True)
class Arm:
    """One way to reuse a source run in a target task, or the control.

    Attributes:
        id: its name.
        carries: levels that are taken over from the source.
        fixed: those of them that stay as they are.
        trains: whether anything is learned in the target.
        epsilon: share of random choices at the first step of training.
        summary: what it is, in a line.
    """

    id: ArmName
    carries: tuple[str, ...]
    fixed: tuple[str, ...] = ()
    trains: bool = True
    epsilon: float = 1.0
    summary: str = ""

    def fits(self, method: Method, scenario: Scenario) -> bool:
        """Return whether the arm makes sense: something is reused and, beside what is not, something is learned.

        A level that is given is neither reused nor learned; an option level with one option has nothing to learn.
        """
        learned = [level for level in method.levels if level not in self.fixed and _has_choice(level, scenario)]
        reused = set(self.carries) & set(method.levels)
        return bool(learned or not self.trains) and bool(reused or not self.carries)


_BOTH = ("option", "action")

ARMS: Mapping[ArmName, Arm] = MappingProxyType(
    {
        arm.id: arm
        for arm in (
            Arm("zero-shot", carries=_BOTH, trains=False, summary="the source's policy as it is"),
            Arm("frozen-action", ("action",), fixed=("action",), summary="action level kept, options learned anew"),
            Arm("fine-tune", carries=_BOTH, epsilon=0.2, summary="everything taken over goes on learning"),
            Arm(CONTROL, carries=(), summary="the control: the same method and budget from nothing"),
        )
    }
)
"""Every arm by its id; a training's arms share method, budget and seeds."""


def _has_choice(level: str, scenario: Scenario) -> bool:
    return level == "action" or sum(scenario.option_mask) > 1
