"""Trainings whose success curves are known, for tests of what is made of them."""

from collections.abc import Sequence

from hhrl_bench.training.learning_curves import SharesRecord, TrainingOutcomesRecord

STEPS = (0, 10_000, 20_000, 30_000)


def training(
    success: Sequence[Sequence[float | None]],
    method: str = "ddqn",
    task: str = "stop-line-v0",
    env_steps: Sequence[int] = STEPS,
    seeds: Sequence[int] | None = None,
) -> TrainingOutcomesRecord:
    """Return the record of a training with these success rates [seeds, reports]; what does not succeed times out."""
    won = tuple(map(tuple, success))
    timed_out = tuple(tuple(None if rate is None else 1.0 - rate for rate in curve) for curve in won)
    never = tuple(tuple(None if rate is None else 0.0 for rate in curve) for curve in won)
    shares = SharesRecord(success=won, timeout=timed_out, not_stop=never, collision=never)
    return TrainingOutcomesRecord(
        method=method,
        task=task,
        seeds=tuple(range(len(won)) if seeds is None else seeds),
        env_steps=tuple(env_steps),
        training=shares,
        testing=shares,
    )
