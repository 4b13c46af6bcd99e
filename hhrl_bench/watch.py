"""One test episode as a picture: a GIF that moves, or a PNG strip of key frames above speed and distance over time."""

from collections.abc import Callable, Sequence
from pathlib import Path

from hhrl_agents import Agent
from hhrl_agents.files import OutputError, require_writable, write_atomically
from hhrl_bench.casting import evaluation_cast
from hhrl_bench.errors import SeedError
from hhrl_bench.evaluation import BATCH_ROWS
from hhrl_bench.stage import Stage
from hhrl_bench.tasks import Task, get_task
from hhrl_envs import Option, Outcome, get_scenario
from hhrl_envs.extras import require
from hhrl_envs.moments import Moment, moment_of


def watch(agent: Agent, task: str | Task, out: str | Path, episode: int = 0, option: Option | None = None) -> Outcome:
    """Return how test episode ``episode`` of the task ends, having drawn it into the file ``out``.

    Args:
        agent: the agent to play; see :class:`hhrl_agents.Agent`.
        task: a task or its id.
        out: a ``.gif`` (every step, in real time) or a ``.png`` (a strip of key frames).
        episode: which test episode, as :func:`hhrl_bench.evaluate` counts them.
        option: hold this option fixed in place of the agent's own choice.

    Raises:
        InputError: in one line, for anything that cannot be played or written.
    """
    path = Path(out)
    draw = artist(path)
    require_writable(path)
    moments = record(agent, get_task(task), episode, option)
    write_atomically(path, draw(moments))
    return moments[-1].outcome


def record(agent: Agent, task: Task, episode: int, option: Option | None = None) -> list[Moment]:
    """Return every moment of one test episode, from its start to its outcome, with the option selected there.

    It is played in the batch that the evaluation plays it in, so that it is the same to the last bit.
    """
    if episode < 0:
        raise SeedError(f"episode is {episode}; write the number of a test episode, 0 or more")
    row = episode % BATCH_ROWS
    stage = Stage(agent, get_scenario(task.scenario), BATCH_ROWS, option, evaluation_cast(task))
    stage.begin(task.test.take(BATCH_ROWS, offset=episode - row))
    return moments_of(stage, row)


def moments_of(stage: Stage, row: int) -> list[Moment]:
    """Return every moment of one row of a stage, on which all rows have just begun, until its outcome."""
    simulator, ego = stage.simulator, row * len(stage.slots)
    moments: list[Moment] = []
    while (simulator.agent_outcomes[row] == Outcome.RUNNING).any():
        decision = stage.decide()
        moments.append(moment_of(simulator, row, int(decision.option[ego])))
        stage.step(decision)
    return [*moments, moment_of(simulator, row, int(decision.option[ego]))]


def artist(path: Path) -> Callable[[Sequence[Moment]], bytes]:
    """Return the function that draws what the suffix of ``path`` asks for."""
    if path.suffix.lower() not in {".gif", ".png"}:
        raise OutputError(f"cannot draw {path.name!r}; write a name that ends in .gif or .png")
    require("pygame", extra="render")
    require("PIL", extra="render")
    from hhrl_bench import film, strip  # noqa: PLC0415  (the extra is needed only from here on)

    return film.gif if path.suffix.lower() == ".gif" else strip.png
