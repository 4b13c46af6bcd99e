"""Worlds with something that no single observation shows."""

from dataclasses import replace

from hhrl_envs import SCENARIOS, Scenario, Sensor

FLICKERING = replace(
    SCENARIOS["stop-line-v0"],
    id="flickering-v0",
    sensor=Sensor(front_range=60.0, noise_distance=0.5, noise_speed=0.2, delay=3, dropout=0.6, dropout_time=1.2),
)
"""Its front sensor drops out, beside errors and a delay."""

HIDDEN: dict[str, Scenario] = {one.id: one for one in (FLICKERING,)}
"""All of them by their ids."""
