"""Worlds at the limits: scenarios drawn over all that validation can see, and what must hold of the accepted ones."""

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import partial
from math import inf, nan, nextafter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hhrl_envs import SCENARIOS, Ghosts, Goal, Reward, Scenario, Signal, Simulator, Slippery, observation
from hhrl_envs.scenario import limits
from hhrl_envs.scenario.limits import Limits
from hhrl_envs.scenario.profiles import ProfileFamily
from hhrl_envs.simulation.engine import layout as at
from hhrl_envs.simulation.engine.layout import count_fields
from hhrl_envs.sub_goals import RUNNING
from hhrl_envs.views.spaces import observation_space, state_space
from support.hostile import Rng

ROWS, CHUNK = 4, 128
SECONDS = 1.0  # of the processor, for a reset and all steps to the horizon
BASES = tuple(SCENARIOS.values())
HOSTILE: tuple[Any, ...] = (
    0.0, -0.0, 5e-324, 1e-320, 2.3e-308, 1e-300, 1e-30, 1e-12, 1e-9, -1e-9, 1e-6, 1e-3, -1.0, 1e7, 1e18, 1e300, 1.7e308,
    inf, -inf, nan, 10**400, -(2**70), True, None, "1", (), (nan, nan), (0.0, 5e-324), (1e-9, 1e-9), (-1e-9, 1e-9),
    (0.0, 1e308), (1e300, 1e308), (-inf, inf), np.float16(6e4), np.float32(1e-38), np.int8(1), np.int64(2**62),
)  # fmt: skip


def draw_scenario(rng: Rng) -> Scenario:
    """Return a scenario: a registered one with some, or all, of its numbers anywhere within their limits.

    Of some, one field is hostile.

    Raises:
        InputError: where validation refuses it.
    """
    base, bold = _with_goal(BASES[rng.integers(len(BASES))], rng), float(rng.choice([0.1, 0.5, 1.0]))
    change: Callable[[Any, Mapping[str, Limits]], Any] = partial(_changed, rng=rng, bold=bold)
    road = _road(base, rng, bold)
    parts: dict[str, Any] = {
        "vehicle": _with_levels(change(base.vehicle, limits.VEHICLE), rng, bold),
        "road": road,
        "sensor": replace(change(base.sensor, limits.SENSOR), ghosts=_ghosts(rng, bold)),
        "reward": _read(change(base.reward, limits.REWARD), rng),
        "band": _band(base, rng, bold),
        "traffic": _traffic(base, road.speed_limit, rng, bold),
    }
    if base.signal is not None:
        parts["signal"] = change(base.signal, limits.SIGNAL)
    if base.adversary is not None:
        parts["adversary"] = change(base.adversary, limits.ADVERSARY)
    parts |= _whole(base, rng, bold)
    if rng.random() < 0.2:
        _spoil(parts, rng)
    fronts = parts["traffic"].max_fronts
    learned = None if base.learned_fronts is None else min(base.learned_fronts, fronts)
    return replace(base, **{"learned_fronts": learned, "feasible_only": bool(rng.random() < 0.2), **parts})


def compile_kernels() -> None:
    """Compile what any scenario needs, so that it does not count as the time of one."""
    slippery = replace(BASES[0], road=replace(BASES[0].road, slippery=Slippery(0.5, (0.1, 0.5))))
    for scenario in (*BASES, slippery):
        simulator = Simulator(replace(scenario, feasible_only=False), 64)
        simulator.reset(np.arange(64))
        simulator.step(np.zeros(64, np.int64))


def run(scenario: Scenario, rng: Rng) -> None:
    """Run a scenario to its horizon and assert what must hold of every world.

    Raises:
        InputError: if a reset finds no feasible world.
    """
    legal = scenario.traffic.speed[1] <= scenario.road.speed_limit
    free = scenario.goal != Goal.FOLLOW and scenario.adversary is None and legal
    most = min(3, scenario.traffic.max_fronts) if free else 0
    learned = scenario.learned_fronts or int(rng.integers(most + 1) * (rng.random() < 0.5))
    simulator, seed = Simulator(scenario, ROWS, learned_fronts=learned), int(rng.integers(2**62))
    if _play(simulator, seed, watched=True) > SECONDS:
        spent = _play(simulator, seed, watched=False)
        assert spent < SECONDS, f"{spent:.1f} s for {scenario}"


def _play(simulator: Simulator, seed: int, watched: bool) -> float:
    """Return the seconds of the processor that a reset takes and all steps until all agents have ended."""
    rng, begun = np.random.default_rng(seed), time.thread_time()
    try:
        simulator.reset(rng.integers(0, 2**62, ROWS))
    finally:
        assert time.thread_time() - begun < SECONDS, f"a reset takes too long in {simulator.scenario}"
    recording = Recording(simulator) if watched else None
    for actions in _driving(simulator, rng):
        simulator.step(actions)
        if recording is not None:
            recording.note()
        if simulator.ended == ROWS * simulator.num_agents:
            break
    if recording is not None:
        recording.check()
    return time.thread_time() - begun


class Recording:
    """What the agents of a simulator see and get, and where vehicles are, of the last steps."""

    def __init__(self, simulator: Simulator) -> None:
        agents, scenario = simulator.num_agents, simulator.scenario
        self.simulator, self.count = simulator, 0
        self.seen = np.empty((CHUNK, *simulator.arrays.all_observations.shape), np.float32)
        self.got = np.empty((CHUNK, *simulator.arrays.all_results.shape))
        self.live = np.empty((CHUNK, agents, ROWS), bool)
        record = count_fields(at.VEHICLE)
        first = count_fields(at.ROW) + agents * record + count_fields(at.POSITION)
        self.scripted = simulator._memory.fields[0, first::record, :ROWS]
        self.present = self.scripted < 0.5 * at.FAR
        self.places = np.empty((CHUNK, *self.scripted.shape))
        self.space, self.state = (
            _bounds(space) for space in (observation_space(scenario), state_space(scenario, agents))
        )
        self.running = np.ones((agents, ROWS), bool)
        self.note()

    def note(self) -> None:
        """Take a step down, and check what is there once it is much."""
        arrays, place = self.simulator.arrays, self.count
        self.seen[place], self.got[place] = arrays.all_observations, arrays.all_results
        self.places[place], self.live[place] = self.scripted, self.running
        self.running = arrays.all_codes[0] == RUNNING
        self.count += 1
        if self.count == CHUNK:
            self.check()

    def check(self) -> None:
        """Assert what must hold of the steps that were noted."""
        seen, places, live = self.seen[: self.count], self.places[: self.count], self.live[: self.count]
        scenario, self.count = self.simulator.scenario, 0
        assert np.isfinite(self.got[: len(seen)]).all(), f"rewards of {scenario}"
        assert np.isfinite(self.simulator._numbers).all(), f"numbers of {scenario}"
        _require_inside(self.space, seen, live, scenario)
        _require_inside(self.state, seen, np.broadcast_to(live.any(axis=1, keepdims=True), live.shape), scenario)
        gaps = np.diff(places, axis=1) - scenario.vehicle.length
        assert (gaps >= 0.0).all(), f"overlap of {-gaps.min()} m in {scenario}"
        assert (places[:, self.present] < 0.5 * at.FAR).all(), f"a vehicle where absent ones are kept in {scenario}"


def _bounds(space: Any) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the least and the largest observation of an agent, float32 [1, SIZE, 1, 1]; all have the same ones."""
    shape = 1, observation.SIZE, 1, 1
    return space.low[: observation.SIZE].reshape(shape), space.high[: observation.SIZE].reshape(shape)


def _require_inside(
    bounds: tuple[NDArray[np.float32], NDArray[np.float32]],
    seen: NDArray[np.float32],
    live: NDArray[np.bool_],
    scenario: Scenario,
) -> None:
    """Assert that observations [step, SIZE, agent, row] lie within bounds where an agent [step, agent, row] is live."""
    low, high = bounds
    outside = ~((seen >= low) & (seen <= high)) & live[:, None]
    if outside.any():
        step, element, agent, row = (int(index) for index in np.argwhere(outside)[0])
        known = f"{low[0, element, 0, 0]} to {high[0, element, 0, 0]}"
        value, symbol = seen[step, element, agent, row], observation.SYMBOLS[element]
        raise AssertionError(f"{symbol} of agent {agent}, scaled, is {value}, not {known}, in {scenario}")


def _driving(simulator: Simulator, rng: Rng) -> Iterator[NDArray[Any]]:
    """Yield actions to the horizon: full brake, full throttle, or levels or accelerations that are held for a while."""
    levels, shape = simulator.scenario.vehicle.levels, (ROWS, simulator.num_agents)[: 1 + (simulator.num_agents > 1)]
    way, held = int(rng.integers(4)), int(rng.integers(1, 60))
    actions: NDArray[Any] = np.full(shape, 0 if way == 0 else len(levels) - 1)
    for step in range(simulator.scenario.horizon):
        if way == 2 and step % held == 0:
            actions = rng.integers(0, len(levels), shape)
        if way == 3 and step % held == 0:
            actions = np.clip(rng.uniform(levels[0], levels[-1], shape), levels[0], levels[-1])
        yield actions


def _draw(known: Limits, rng: Rng) -> float:
    """Return a number within limits: at a limit or beside it, of any magnitude, or anywhere."""
    low, high = float(known.low), float(known.high)
    match int(rng.integers(8)):
        case 0:
            return low
        case 1:
            return high
        case 2:
            return nextafter(low, high) if rng.random() < 0.5 else nextafter(high, low)
        case 3 | 4 if high > 1e-9:
            least = max(low, high * 1e-9)
            return float(min(max(least * (high / least) ** rng.random(), low), high))
        case 5 if high >= 1.0 >= low:
            return float(np.clip(round(rng.uniform(low, high)), low, high))
        case _:
            return float(rng.uniform(low, high))


def _drawn(before: Any, known: Limits, rng: Rng) -> Any:
    """Return a value like the one before within limits: an integer, a range or a number."""
    if isinstance(before, tuple):
        ends = sorted((_draw(known, rng), _draw(known, rng)))
        return (ends[0], ends[0]) if rng.random() < 0.2 else tuple(ends)
    drawn = _draw(known, rng)
    if isinstance(before, int):
        return int(drawn)
    kind = (np.float64, np.float32, np.float16)[rng.integers(3)] if rng.random() < 0.03 and drawn < 6e4 else float
    narrow = kind(drawn)
    return narrow if known.low <= float(narrow) <= known.high else drawn


def _changed(part: Any, known: Mapping[str, Limits], rng: Rng, bold: float) -> Any:
    names = [name for name in known if name not in {"levels", "lines"} and rng.random() < bold]
    return replace(part, **{name: _drawn(getattr(part, name), known[name], rng) for name in names})


def _with_goal(base: Scenario, rng: Rng) -> Scenario:
    """Return the scenario with another goal, other lines or another signal now and then."""
    if base.goal == Goal.FOLLOW or base.adversary is not None or rng.random() < 0.7:
        return base
    lines = ((), (0.0,), (0.0, 30.0))[rng.integers(3)]
    goal = Goal.STOP if lines and rng.random() < 0.5 else Goal.PASS
    signal = Signal((5.0, 30.0)) if goal == Goal.PASS and len(lines) == 1 and rng.random() < 0.5 else None
    return replace(base, goal=goal, signal=signal, road=replace(base.road, lines=lines))


def _with_levels(vehicle: Any, rng: Rng, bold: float) -> Any:
    if rng.random() >= bold:
        return vehicle
    low, high, _ = limits.VEHICLE["levels"]
    brake, throttle = _draw(Limits(low, -limits.WEAKEST, ""), rng), _draw(Limits(limits.WEAKEST, high, ""), rng)
    between = {_draw(Limits(brake, throttle, ""), rng) for _ in range(rng.integers(4))}
    return replace(vehicle, levels=tuple(sorted({brake, throttle, *between})))


def _read(reward: Reward, rng: Rng) -> Reward:
    return replace(reward, unsafe="printed") if rng.random() < 0.5 else reward


def _road(base: Scenario, rng: Rng, bold: float) -> Any:
    limit = _drawn(base.road.speed_limit, limits.ROAD["speed_limit"], rng) if rng.random() < bold else 0.0
    limit = limit or base.road.speed_limit
    zone = _drawn(base.road.stop_zone, limits.ROAD["stop_zone"], rng) if rng.random() < bold else base.road.stop_zone
    speed = limits.ROAD["start_speed"]._replace(high=float(limit))
    distance = limits.ROAD["start_distance"]._replace(low=float(zone))
    lines = base.road.lines
    if lines and rng.random() < bold:
        lines = tuple(sorted({_draw(limits.ROAD["lines"], rng) for _ in lines}))
    road = replace(
        base.road,
        speed_limit=limit,
        stop_zone=zone,
        lines=lines,
        slippery=_slippery(rng, bold),
        start_speed=_drawn((0.0, 0.0), speed, rng),
        start_distance=_drawn((0.0, 0.0), distance, rng),
    )
    return _changed(road, {name: limits.ROAD[name] for name in ("stop_speed", "friction")}, rng, bold)


def _slippery(rng: Rng, bold: float) -> Slippery | None:
    return _changed(Slippery(0.5, (0.05, 0.5)), limits.SLIPPERY, rng, bold) if rng.random() < 0.4 else None


def _ghosts(rng: Rng, bold: float) -> Ghosts | None:
    return _changed(Ghosts(0.5), limits.GHOSTS, rng, bold) if rng.random() < 0.2 else None


def _band(base: Scenario, rng: Rng, bold: float) -> Any:
    high = _drawn(base.band.high, limits.BAND["high"], rng) if rng.random() < bold else base.band.high
    low = _drawn(base.band.low, Limits(0.0, nextafter(float(high), 0.0), ""), rng)
    names = ("headway", "share")
    return _changed(replace(base.band, low=low, high=high), {name: limits.BAND[name] for name in names}, rng, bold)


def _traffic(base: Scenario, limit: float, rng: Rng, bold: float) -> Any:
    families = base.traffic.families
    families = tuple(_family(family, rng, bold) for family in families[: rng.integers(1, len(families) + 1)])
    counts = base.traffic.count_shares
    if rng.random() < bold and base.traffic.max_fronts:
        size = int(rng.choice([2, 3, 5, 9, 30, limits.MOST_FRONTS + 1], p=[0.2, 0.3, 0.3, 0.16, 0.03, 0.01]))
        drawn = rng.dirichlet(np.full(size, 0.3))
        drawn[0] = 0.0 if base.goal == Goal.FOLLOW or base.learned_fronts else drawn[0]
        drawn[-1] += 1.0 - drawn.sum()
        counts = tuple(drawn.tolist())
    traffic = replace(base.traffic, families=families, count_shares=counts)
    known = limits.TRAFFIC
    if base.learned_fronts or rng.random() < 0.2:
        known = known | {"speed": known["speed"]._replace(high=float(limit))}
        traffic = replace(traffic, speed=_drawn(traffic.speed, known["speed"], rng))
    return _changed(traffic, known, rng, bold)


def _family(family: ProfileFamily, rng: Rng, bold: float) -> ProfileFamily:
    family = _changed(family, {**limits.PROFILE, **limits.FAMILY}, rng, bold)
    if rng.random() < bold:
        corners = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.5, 0.25, 0.25))
        family = replace(family, styles=corners[rng.integers(len(corners))])
    return family


def _whole(base: Scenario, rng: Rng, bold: float) -> dict[str, Any]:
    """Return the scenario's own numbers; of long horizons few, because they take long."""
    whole: dict[str, Any] = {}
    if rng.random() < bold:
        whole["route_end"] = _drawn(base.route_end, limits.SCENARIO["route_end"], rng)
    if rng.random() < max(bold, 0.5):
        whole["dt"] = _drawn(base.dt, limits.SCENARIO["dt"], rng)
    most = min(limits.SCENARIO["horizon"].high, int(limits.LONGEST / float(whole.get("dt", base.dt))))
    if rng.random() < 0.003:
        whole["horizon"] = most
    elif rng.random() < 0.8 or base.horizon > most:
        whole["horizon"] = min(int(10.0 ** rng.uniform(0.0, 3.2)), most)
    return whole


def _spoil(parts: dict[str, Any], rng: Rng) -> None:
    """Put a hostile value, or one just beyond a limit, into a field of a part or of the whole."""
    value = HOSTILE[rng.integers(len(HOSTILE))]
    names = [*parts, "families"]
    name = names[rng.integers(len(names))]
    if name == "families":
        family = parts["traffic"].families[0]
        own = fields(family)[rng.integers(1, len(fields(family)))].name
        parts["traffic"] = replace(parts["traffic"], families=(replace(family, **{own: value}),))
    elif hasattr(parts[name], "__dataclass_fields__"):
        own = fields(parts[name])[rng.integers(len(fields(parts[name])))].name
        parts[name] = replace(parts[name], **{own: value})
    else:
        parts[name] = value
