"""Worlds with something that no single observation shows."""

from dataclasses import replace

from hhrl_envs import SCENARIOS, Ghosts, Scenario, Sensor, Slippery

FLICKERING = replace(
    SCENARIOS["stop-line-v0"],
    id="flickering-v0",
    sensor=Sensor(front_range=60.0, noise_distance=0.5, noise_speed=0.2, delay=3, dropout=0.6, dropout_time=1.2),
)
"""Its front sensor drops out, beside errors and a delay."""

SLIPPERY = replace(
    SCENARIOS["stop-line-v0"],
    id="slippery-v0",
    road=replace(SCENARIOS["stop-line-v0"].road, slippery=Slippery(share=0.6, friction=(0.08, 0.4))),
)
"""Its road is slippery in some worlds."""

HAUNTED = replace(
    SCENARIOS["stop-line-v0"],
    id="haunted-v0",
    sensor=replace(FLICKERING.sensor, dropout=0.2, ghosts=Ghosts(share=0.7, stretch=15.0, near=5.0)),
)
"""Its sensors report vehicles that are not there, beside errors, a delay and drop-outs."""

HIDDEN: dict[str, Scenario] = {one.id: one for one in (FLICKERING, SLIPPERY, HAUNTED)}
"""All of them by their ids."""
