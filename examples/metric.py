"""Add a metric: in how many steps the ego brakes harder than 3 m/s^2.

    hhrl-bench --extension examples/metric.py evaluate rule-4 rule-plus

A metric is declared once. It becomes a column of the results, a field of their JSON and of its schema.
"""

from hhrl_bench import Metric, Sum, register_metric
from hhrl_bench.evaluation.rollout import Step
from hhrl_envs.arrays import Flags
from hhrl_envs.observation import A_E, to_si


def brakes_hard(step: Step) -> Flags:
    """Return whether the ego brakes harder than 3 m/s^2 after a step, bool [B]."""
    return to_si(step.results.observations)[:, A_E] < -3.0


HARD_BRAKING = register_metric(
    Metric(
        key="hard_braking",
        heading="hard braking",
        of=Sum(brakes_hard, whole=True),
        meaning="steps in which the ego brakes harder than 3 m/s^2",
        better="lower",
    )
)

if __name__ == "__main__":
    import hhrl_bench

    for name in ("rule-4", "rule-plus"):
        records = hhrl_bench.evaluate(name, "stop-line-v0", episodes=100).records
        print(f"{name} brakes hard in {HARD_BRAKING.values(records).mean():.1f} steps an episode")
