"""Transfer: a source run reused in a target task, arm by arm; an arm is a training with its own run directory."""

import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

from hhrl_agents import METHODS
from hhrl_agents.methods.method import Method
from hhrl_bench.errors import AgentError
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.training.reuse import Reuse, Source, load_source
from hhrl_envs import Scenario, get_scenario

if TYPE_CHECKING:
    from hhrl_bench.training.train import Plan

ArmName = Literal["zero-shot", "frozen-action", "fine-tune", "scratch"]

CONTROL: ArmName = "scratch"

REPORTS = 20
"""Reports of a training in the target, after the one of step 0."""

_BOTH = ("option", "action")


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


def _has_choice(level: str, scenario: Scenario) -> bool:
    return level == "action" or sum(scenario.option_mask) > 1


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
"""Every arm by its id; the trainings of the arms share method, budget and seeds."""


@dataclass(frozen=True)
class Transfer:
    """A source reused in a target task with these seeds, trained there for ``env_steps`` a seed and arm.

    Attributes:
        source: a run directory, or a method whose trained seeds come with the package.
        target: the task in which the source is reused.
        seeds: training seeds.
        env_steps: budget of a seed in an arm.
        folder: holds the run directory of every arm, under the arm's id.
    """

    source: str
    target: Task
    seeds: tuple[int, ...]
    env_steps: int
    folder: Path

    @property
    def command(self) -> str:
        """The command that does the same again."""
        words = ["hhrl-bench", "transfer", "--source", self.source, "--target", self.target.id]
        return shlex.join([*words, "--seeds", format_seeds(self.seeds), "--env-steps", str(self.env_steps)])

    def load(self) -> Source:
        """Return the source.

        Raises:
            AgentError: see :func:`hhrl_bench.training.reuse.load_source`; or it lacks a seed.
        """
        source = load_source(self.source, get_scenario(self.target.scenario))
        source.require_seeds(self.seeds)
        return source

    def plan(self, arm: str, source: Source) -> "Plan":
        """Return the training of an arm; zero-shot's has no step.

        Raises:
            AgentError: if the arm makes no sense for the source's method in the target.
        """
        from hhrl_bench.training.train import Plan  # noqa: PLC0415

        arms = {one.id: one for one in sensible_arms(source.method, self.target)}
        if arm not in arms:
            raise AgentError(
                f"{arm} makes no sense for {source.method.id} in {self.target.id}; "
                + (f"write one of: {', '.join(arms)}" if arms else "nothing of it can be reused there")
            )
        own = arms[arm]
        method = target_method(source.method, self.target, self.env_steps)
        steps = self.env_steps if own.trains else 0
        reuse = Reuse(source, own.carries, own.fixed, own.epsilon, self.seeds, self.command, asdict(own))
        return Plan(method, self.target, self.seeds, steps, self.folder_of(arm), reuse=reuse)

    def folder_of(self, arm: str) -> Path:
        """Return the run directory of an arm."""
        return self.folder / arm


def sensible_arms(method: Method, target: Task) -> tuple[Arm, ...]:
    """Return the arms that make sense for a method in a target task, in the order of ``ARMS``."""
    if target.ego or (target.given_actions and "option" not in method.levels):  # an adversary is no ego
        return ()
    own = target_method(method, target, 1)
    return tuple(arm for arm in ARMS.values() if arm.fits(own, get_scenario(target.scenario)))


def target_method(method: Method, target: Task, env_steps: int) -> Method:
    """Return how the method learns in the target: it reports often; where actions are given it learns options alone."""
    method = replace(method, config=replace(method.config, report_every=max(1, env_steps // REPORTS)))
    if not target.given_actions:
        return method
    replay = "prioritised" if method.replay == "hierarchical" else method.replay
    return replace(method, ffv=METHODS["option-only"].ffv, attention=False, replay=replay)
