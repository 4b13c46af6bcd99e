"""The source of a transfer: a run whose policies, one for each training seed, are reused in another task."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from hhrl_agents.methods.method import Method
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.loading import load_agents
from hhrl_bench.tasks.seeds import format_seeds
from hhrl_bench.transfer.arms import Arm
from hhrl_envs import Scenario

if TYPE_CHECKING:
    from hhrl_agents.policies.learned_agent import LearnedAgent
    from hhrl_agents.training.start import Start


@dataclass(frozen=True)
class Source:
    """A trained run: ``name`` as it was given, the scenario it was trained in, and by seed its policies and hashes."""

    name: str
    method: Method
    scenario: str
    policies: Mapping[int, "LearnedAgent"]
    sha256: Mapping[int, str]

    def require_seeds(self, seeds: Sequence[int]) -> None:
        """Return nothing.

        Raises:
            AgentError: if one of the seeds has no policy.
        """
        missing = [seed for seed in seeds if seed not in self.policies]
        if missing:
            raise AgentError(
                f"{self.name} has no seed {missing[0]}; write seeds of {format_seeds(sorted(self.policies))}, "
                "or train the others"
            )


@dataclass(frozen=True)
class Reuse:
    """What a training takes over: of which source, in which arm, and the command that asks for it."""

    source: Source
    arm: Arm
    command: str

    def start(self, method: Method, seeds: Sequence[int]) -> "Start":
        """Return what a training of ``method`` begins with: each seed with the source's policy of the same seed."""
        from hhrl_agents.training.start import Start  # noqa: PLC0415

        levels = [level for level in self.arm.carries if level in method.levels]
        prefixes = tuple(f"{level}." for level in levels)
        taken = [
            {name: value for name, value in self.source.policies[seed].parameters.items() if name.startswith(prefixes)}
            for seed in seeds
        ]
        return Start(taken, tuple(level for level in self.arm.fixed if level in levels), self.arm.epsilon)

    def config(self, seeds: Sequence[int]) -> dict[str, Any]:
        """Return the arm and, unless nothing is taken over, the hashes of the seeds' policies, as JSON data."""
        hashes = [self.source.sha256[seed] for seed in seeds] if self.arm.carries else []
        return {"arm": asdict(self.arm), "source": hashes}


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
