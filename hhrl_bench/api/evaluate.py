"""``evaluate``: agents, by their names or as objects, scored on the test episodes of a task."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from hhrl_agents import Agent, ClairvoyantAgent, rules
from hhrl_agents.policies.learned_agent import LearnedAgent
from hhrl_bench.api.evaluation import Evaluation, Scored
from hhrl_bench.errors import AgentError
from hhrl_bench.evaluation.guarded_agent import OPTIONS
from hhrl_bench.evaluation.loading import LoadedAgent, load_agents, training_record
from hhrl_bench.evaluation.records import Kind, TrainingRecord
from hhrl_bench.evaluation.results import Update, play_run, silent
from hhrl_bench.schema import OptionName
from hhrl_bench.tasks.tasks import AnyTask, Task, get_task
from hhrl_envs import Option, get_scenario

AnyAgent = str | Path | Agent
"""What names an agent, as on the command line; or an agent itself."""

Agents = AnyAgent | Sequence[AnyAgent] | Mapping[str, AnyAgent]


def evaluate(
    agents: Agents,
    task: AnyTask = "stop-line-v0",
    episodes: int = 1000,
    option: Option | None = None,
    update: Update = silent,
) -> Evaluation:
    """Return how agents do in the first ``episodes`` test episodes, the same worlds for each; equal on every call.

    Args:
        agents: one agent or several: what names it, see :func:`hhrl_bench.load_agent`, or an agent itself, see
            :class:`hhrl_agents.Agent`. A mapping gives them names. One that is named is scored for each of its training
            seeds.
        task: what names a task; see :func:`hhrl_bench.tasks.tasks.get_task`.
        episodes: how many test episodes, at least 1.
        option: hold this option fixed in place of the agents' own choice.
        update: is called with how many policies of an agent are done, of how many, and a word about the last one.

    Raises:
        InputError: in one line, for an unknown agent or task, an impossible number of episodes, or an agent that
            answers nonsense.
    """
    chosen, held = get_task(task), _option_name(option)
    chosen.test.take(episodes)
    scored = [_score(name, agent, chosen, episodes, held, update) for name, agent in _named(agents).items()]
    return Evaluation(chosen, episodes, scored)


def _score(name: str, agent: AnyAgent, task: Task, episodes: int, option: OptionName | None, update: Update) -> Scored:
    loaded, runs = _loaded(name, agent, task), []
    for one in loaded:
        with one if isinstance(agent, str | Path) else nullcontext():  # what the caller has made stays the caller's
            runs.append(play_run(name, one, task, episodes, option))
        update(len(runs), len(loaded), f"success {runs[-1].record.metrics.success:.1%}")
    return Scored(name, loaded[0].kind, task, option, tuple(runs))


def _loaded(name: str, agent: AnyAgent, task: Task) -> list[LoadedAgent]:
    if isinstance(agent, str | Path):
        return load_agents(agent, get_scenario(task.scenario))
    if isinstance(agent, LearnedAgent):
        return [LoadedAgent("learned", lambda: agent, training=_training(agent, name))]
    ours = type(agent).__module__.startswith(f"{rules.__name__}.")
    kind: Kind = "factory" if not ours else "oracle" if isinstance(agent, ClairvoyantAgent) else "rule"
    return [LoadedAgent(kind, lambda: agent)]


def _training(agent: LearnedAgent, name: str) -> TrainingRecord | None:
    try:
        return training_record(agent.metadata, Path(name))
    except AgentError:  # it was put together, not trained
        return None


def _named(agents: Agents) -> dict[str, AnyAgent]:
    """Return the agents by their names.

    Raises:
        AgentError: if something is no agent, or two have one name.
    """
    if isinstance(agents, Mapping):
        return {str(name): _agent(agent) for name, agent in agents.items()}
    several = [agents] if isinstance(agents, str | Path) or not isinstance(agents, Sequence) else agents
    names = [_name(_agent(agent)) for agent in several]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise AgentError(f"two agents are called {twice!r}; give them names: evaluate({{'first': ..., 'second': ...}})")
    if not names:
        raise AgentError("no agent is given; name one, such as 'rule-4'")
    return dict(zip(names, several, strict=True))


def _agent(agent: Any) -> AnyAgent:
    if isinstance(agent, type):
        raise AgentError(f"{agent.__name__} is a class; give an agent, such as {agent.__name__}(scenario)")
    if isinstance(agent, str | Path | Agent):
        return agent
    raise AgentError(f"{_shown(agent)} is no agent; {_instead(agent)}")


def _shown(thing: Any) -> str:
    return str(getattr(thing, "__name__", repr(thing) if thing is None else type(thing).__name__))


def _instead(thing: Any) -> str:
    """Return what to give in place of something that is no agent."""
    if hasattr(thing, "predict"):
        return "give from_sb3(model)"
    if isinstance(thing, Sequence):
        return "to give one agent several training seeds, name the folder of their files, or module:factory@0-9"
    if callable(thing):
        name = _shown(thing)
        return f"give what it makes, such as {name}(scenario), or from_callable({name}) if it decides itself"
    return "give its name, or an object with act and reset"


def _name(agent: AnyAgent) -> str:
    if isinstance(agent, str | Path):
        return str(agent)
    return agent.method.id if isinstance(agent, LearnedAgent) else str(getattr(agent, "name", type(agent).__name__))


def _option_name(option: Option | None) -> OptionName | None:
    return None if option is None else next(name for name, one in OPTIONS.items() if one == option)
