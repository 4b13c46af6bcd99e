"""What a training takes over from another one: a source run, whose policies, one a training seed, are reused."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hhrl_agents.methods.method import Method
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_envs import Scenario

if TYPE_CHECKING:
    from hhrl_agents.policies.learned_agent import LearnedAgent
    from hhrl_agents.training.learner import Start


@dataclass(frozen=True)
class Source:
    """A trained run: ``name`` as it was given, the scenario it was trained in, and by seed its policies and hashes."""

    name: str
    method: Method
    scenario: str
    policies: Mapping[int, "LearnedAgent"]
    sha256: Mapping[int, str]

    def require_seeds(self, seeds: Sequence[int]) -> None:
        """Raise an ``AgentError`` if one of the seeds has no policy."""
        missing = [seed for seed in seeds if seed not in self.policies]
        if missing:
            raise AgentError(
                f"{self.name} has no seed {missing[0]}; write seeds of {format_seeds(sorted(self.policies))}, "
                "or train the others"
            )


@dataclass(frozen=True)
class Reuse:
    """What a training takes over from a source.

    Attributes:
        source: the trained run.
        levels: whose parameters are taken over; a seed takes those of the source's policy of the same seed.
        fixed: those of the levels that stay as they are.
        epsilon: share of random choices at the first step of training.
        seeds: all that are trained in this way, this one and those beside it.
        command: what asks for their training on the command line.
        arm: what the run directory says of the way in which the source is reused, as JSON data; ``id`` is its name.
    """

    source: Source
    levels: tuple[str, ...]
    fixed: tuple[str, ...]
    epsilon: float
    seeds: tuple[int, ...]
    command: str
    arm: Mapping[str, Any]

    def start(self, method: Method, seed: int) -> "Start":
        """Return what the training of a seed of ``method`` begins with."""
        from hhrl_agents.training.learner import Start  # noqa: PLC0415

        levels = [level for level in self.levels if level in method.levels]
        prefixes = tuple(f"{level}." for level in levels)
        parameters = self.source.policies[seed].parameters if levels else {}
        taken = {name: value for name, value in parameters.items() if name.startswith(prefixes)}
        return Start(taken, tuple(level for level in self.fixed if level in levels), self.epsilon)

    def config(self) -> dict[str, Any]:
        """Return the arm and, unless nothing is taken over, the hashes of all seeds' policies, as JSON data."""
        return {"arm": self.arm, "source": [self.source.sha256[seed] for seed in self.seeds] if self.levels else []}

    def origin(self, seed: int) -> dict[str, str | None]:
        """Return what the checkpoints of a seed say that it began with, wherever the source lies."""
        return {"arm": self.arm["id"], "source_sha256": self.source.sha256[seed] if self.levels else None}


def load_source(name: str, scenario: Scenario) -> Source:
    """Return the source that ``name`` names: a run directory, a checkpoint, or a method with shipped seeds.

    Raises:
        AgentError: if there is none, it is not trained by a learner that can begin with given parameters, or it sees or
            acts otherwise than the target ``scenario`` asks.
    """
    agents = {agent.training.seed: agent for agent in load_agents(name, scenario) if agent.training}
    if not agents:
        raise AgentError(
            f"{name} is not trained, so nothing can be transferred; write a run directory or a shipped method"
        )
    policies: dict[int, LearnedAgent] = {seed: agent.agent for seed, agent in agents.items()}  # type: ignore[misc]
    first = next(iter(policies.values()))
    if first.method.algorithm != "double-dqn":
        raise AgentError(
            f"{name} is trained by {first.method.algorithm}, which always begins from nothing; "
            "write a run of a Double DQN method"
        )
    return Source(
        name,
        first.method,
        str(first.metadata["scenario"]),
        policies,
        {seed: str(agent.sha256) for seed, agent in agents.items()},
    )
