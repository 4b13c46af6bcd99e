"""The beginning of episodes: draw a world, decide its feasibility, show its first observation."""

from hhrl_envs.batch import EPISODE, SEED, Batch, Results
from hhrl_envs.compiled import Flags, as_row, kernel
from hhrl_envs.feasibility import is_feasible
from hhrl_envs.outcomes import RUNNING
from hhrl_envs.showing import measure_truth, show
from hhrl_envs.streams import stream
from hhrl_envs.worlds import draw_world

MAX_ATTEMPTS = 1000


@kernel
def begin_row(b: Batch, feasible_only: bool, i: int) -> bool:
    """Put row ``i`` at the start of its current episode and return whether that is feasible.

    With ``feasible_only`` worlds are drawn anew, each attempt from streams of its own, until one is.
    """
    for attempt in range(MAX_ATTEMPTS):
        key = stream(b.keys[SEED, i], b.keys[EPISODE, i], attempt, 0)
        fronts = draw_world(b.state, b.profile, b.rows, i, key, b.keys[EPISODE, i], b.c, b.counts, b.families)
        feasible = is_feasible(b.state, b.profile, b.rows, fronts, i, b.c)
        if feasible or not feasible_only:
            return feasible
    return False


@kernel
def begin_rows(b: Batch, chosen: Flags, out: Results, feasible_only: bool, low: int, high: int) -> None:
    """Put the chosen rows, bool [row], from low to high at the start of their current episodes, with reward 0."""
    for i in range(as_row(low), as_row(high)):
        if chosen[i]:
            b.feasible[i] = begin_row(b, feasible_only, i)
            b.steps[i] = 0
            for agent in range(out.ended.shape[0]):
                out.ended[agent, i] = RUNNING
                for field in range(out.rewards.shape[0]):
                    out.rewards[field, agent, i] = 0.0
            measure_truth(b, i, i + as_row(1))
            show(b, out, i, i + as_row(1))
