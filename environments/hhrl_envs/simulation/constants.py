"""The scenario's numbers as the kernels read them: one array; see ``layout`` for what lies where."""

import numpy as np

from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.profiles import PARAMETERS, ProfileFamily
from hhrl_envs.scenario.scenario import Adversary, Goal, Scenario
from hhrl_envs.scenario.sensors import Ghosts
from hhrl_envs.simulation.engine import layout
from hhrl_envs.simulation.engine.layout import FAMILY_TABLE_WIDTH, SLOW_CHANCE, STYLE_SHARES, WEIGHT
from hhrl_envs.simulation.traffic import guard_margin


def pack(scenario: Scenario, agents: int = 1) -> Floats:
    """Return the numbers of a scenario with so many agents, float64 [...].

    The named constants come first, then the cumulative shares of the numbers of front vehicles, then `family_table`.
    """
    c = np.zeros(layout.CONSTANTS_SIZE)
    numbers = {**_physics(scenario), **_judgement(scenario), **_draws(scenario), **_perception(scenario)}
    for place, value in numbers.items():
        c[place] = value
    c[layout.FEASIBLE_ONLY], c[layout.SLOTS], c[layout.AGENTS] = (
        scenario.feasible_only,
        scenario.num_vehicles + 1,
        agents,
    )
    c[layout.ADVERSARY] = scenario.adversary is not None and agents > 1
    return np.concatenate([c, _cumulative_counts(scenario), family_table(scenario.traffic.families).ravel()])


def _physics(scenario: Scenario) -> dict[int, float]:
    vehicle, road, lines = scenario.vehicle, scenario.road, scenario.road.lines
    return {
        layout.DT: scenario.dt,
        layout.PER_DT: 1.0 / scenario.dt,
        layout.HORIZON: scenario.horizon,
        layout.LENGTH: vehicle.length,
        layout.LAG_GAIN: scenario.dt / (vehicle.lag + scenario.dt),
        layout.JERK_STEP: vehicle.jerk_limit * scenario.dt,
        layout.EGO_MIN_ACCEL: vehicle.levels[0],
        layout.THROTTLE: vehicle.levels[-1],
        layout.FRICTION: road.friction,
        layout.FREE_THROTTLE: 0.0 if road.slippery else np.inf,
        layout.GUARD: guard_margin(scenario),
        layout.SPEED_LIMIT: road.speed_limit,
        layout.FIRST_LINE: lines[0] if lines else layout.FAR,
        layout.LAST_LINE: lines[-1] if lines else layout.FAR,
        layout.GOAL_PLACE: _goal_place(scenario),
        layout.FARTHEST: lines[0] if scenario.goal == Goal.STOP else layout.FAR,
    }


def _goal_place(scenario: Scenario) -> float:
    """Return the position that the front vehicle's rear must leave free for the ego to succeed."""
    if scenario.goal == Goal.FOLLOW:
        return -layout.FAR
    return scenario.route_end if scenario.goal == Goal.PASS else scenario.road.lines[-1]


def _judgement(scenario: Scenario) -> dict[int, float]:
    reward, road, band, adversary = scenario.reward, scenario.road, scenario.band, scenario.adversary or Adversary()
    return {
        layout.STOP_ZONE: road.stop_zone,
        layout.STOP_SPEED: road.stop_speed,
        layout.GOAL: scenario.goal,
        layout.ROUTE_END: scenario.route_end,
        layout.CLEAR_BY: scenario.clear_by,
        layout.SIGMA_1: reward.sigma_1,
        layout.SIGMA_2: reward.sigma_2,
        layout.SIGMA_3: reward.sigma_3,
        layout.SIGMA_4: reward.sigma_4,
        layout.JERK_THRESHOLD: reward.jerk_threshold,
        layout.POSITIVE_JERK_ONLY: reward.positive_jerk_only,
        layout.PRINTED_UNSAFE: reward.unsafe == "printed",
        layout.SAFE_GAP: reward.safe_gap,
        layout.PER_TWICE_DECEL: 1.0 / (2.0 * scenario.vehicle.max_decel),
        layout.TIMEOUT_SCALE: reward.timeout_scale,
        layout.BAND_LOW: band.low,
        layout.BAND_HIGH: band.high,
        layout.BAND_HEADWAY: band.headway,
        layout.BAND_SHARE: band.share,
        layout.HARDEST_BRAKE: adversary.hardest_brake,
        layout.PATIENCE: adversary.patience,
    }


def _draws(scenario: Scenario) -> dict[int, float]:
    road, traffic, slippery = scenario.road, scenario.traffic, scenario.road.slippery
    ranges = {
        layout.START_LOW: road.start_distance,
        layout.START_SPEED_LOW: road.start_speed,
        layout.GAP_LOW: traffic.gap,
        layout.FRONT_SPEED_LOW: traffic.speed,
        layout.SLIPPERY_LOW: slippery.friction if slippery else road.frictions,
        layout.GREEN_LOW: scenario.signal.green_at if scenario.signal else (layout.FAR, layout.FAR),
    }
    numbers = {place + end: drawn[end] for place, drawn in ranges.items() for end in (0, 1)}
    share = slippery.share if slippery else 0.0
    return {**numbers, layout.SIGNAL: scenario.signal is not None, layout.SLIPPERY_SHARE: share}


def _perception(scenario: Scenario) -> dict[int, float]:
    sensor, ghosts = scenario.sensor, scenario.sensor.ghosts or Ghosts(share=0.0)
    return {
        layout.FRONT_RANGE: sensor.front_range,
        layout.LINE_RANGE: sensor.line_range,
        layout.NOISE_SPEED: sensor.noise_speed,
        layout.NOISE_ACCEL: sensor.noise_accel,
        layout.NOISE_DISTANCE: sensor.noise_distance,
        layout.DROPOUT: sensor.dropout,
        layout.DROPOUT_STEPS: max(round(sensor.dropout_time / scenario.dt), 1),
        layout.GHOSTS: ghosts.share,
        layout.GHOST_STRETCH: ghosts.stretch,
        layout.GHOST_NEAR: ghosts.near,
    }


def _cumulative_counts(scenario: Scenario) -> Floats:
    """Return the cumulative shares of 0, 1, 2, ... front vehicles, float64 [max_fronts + 1]."""
    shares = np.cumsum(scenario.traffic.count_shares[: scenario.traffic.max_fronts + 1])
    shares[-1] = 1.0
    return shares


def family_table(families: tuple[ProfileFamily, ...]) -> Floats:
    """Return the families as float64 [family, FAMILY_TABLE_WIDTH] for the compiled sampler."""
    table = np.empty((len(families), FAMILY_TABLE_WIDTH))
    weights = np.cumsum([family.weight for family in families])
    for row, family in enumerate(families):
        for column, name in enumerate(PARAMETERS):
            table[row, 2 * column : 2 * column + 2] = getattr(family, name)
        table[row, WEIGHT] = weights[row] / weights[-1]
        table[row, SLOW_CHANCE] = family.slow_chance
        table[row, STYLE_SHARES:] = np.cumsum(family.styles)
    table[-1, WEIGHT] = 1.0
    return table
