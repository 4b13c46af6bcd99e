"""From the state of a batch to what its agents see."""

from hhrl_envs.batch import Batch, Results
from hhrl_envs.compiled import kernel
from hhrl_envs.observation import observe
from hhrl_envs.sensing import derive, measure, perturb


@kernel
def measure_truth(b: Batch, low: int, high: int) -> None:
    """Write the true measurements of rows low to high."""
    measure(b.state, b.measured, 0, b.c, low, high)
    derive(b.measured, 0, b.c, low, high)


@kernel
def show(b: Batch, out: Results, low: int, high: int) -> None:
    """Write the observations: the truth as measured, or a delayed and noisy version of it."""
    if b.history.shape[0] > 0:
        perturb(b.measured, b.history, b.steps, b.keys, 0, b.c, low, high)
    observe(b.measured, out.observations, 0, low, high)
