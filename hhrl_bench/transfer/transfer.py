"""Transfer: a source run reused in a target task, arm by arm, each arm a training of its own run directory."""

import shlex
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from hhrl_agents import METHODS
from hhrl_agents.methods.method import Method
from hhrl_bench.errors import AgentError
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.tasks.tasks import Task
from hhrl_bench.training.source import Reuse, Source, load_source
from hhrl_bench.transfer.arms import ARMS, Arm
from hhrl_envs import get_scenario

if TYPE_CHECKING:
    from hhrl_bench.training.train import Plan

REPORTS = 20
"""Reports of a training in the target, after the one of step 0."""


@dataclass(frozen=True)
class Transfer:
    """A source reused in a target task with these seeds, trained there for ``env_steps`` a seed and arm.

    source: a run directory, or a method whose trained seeds come with the package; folder: holds the run directory of
    every arm, under the arm's id.
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
            AgentError: see :func:`hhrl_bench.training.source.load_source`; or it lacks a seed.
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
        method = target_method(source.method, self.target, self.env_steps)
        steps = self.env_steps if arms[arm].trains else 0
        reuse = Reuse(source, arms[arm], self.command)
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
