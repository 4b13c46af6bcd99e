"""Registers every scenario with Gymnasium, single and native vector: ``stop-line-v0`` as ``hhrl_envs/StopLine-v0``."""

import gymnasium

from hhrl_envs.registry import SCENARIOS


def gym_id(scenario_id: str) -> str:
    """Return the Gymnasium id of a scenario id."""
    *words, version = scenario_id.split("-")
    return f"hhrl_envs/{''.join(word.capitalize() for word in words)}-{version}"


def register_all() -> None:
    """Register every scenario that is not registered yet."""
    for scenario_id in SCENARIOS:
        if gym_id(scenario_id) not in gymnasium.registry:
            gymnasium.register(
                gym_id(scenario_id),
                entry_point="hhrl_envs.gym_env:StopLineEnv",
                vector_entry_point="hhrl_envs.vector_env:StopLineVectorEnv",
                kwargs={"scenario": scenario_id},
            )
