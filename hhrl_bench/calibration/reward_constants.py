"""The constants sigma_1 to sigma_4 of the paper's reward, recovered from its Table I by a linear program.

The paper does not print them. A policy's r^o and r^a are read as means over its cases of undiscounted episode sums, its
"unsmoothness" as the mean number of steps that sigma_2 is charged for, its "unsafe" as the mean sum of both unsafe
penalties, a collision as charged with sigma_3 and a run line with v_e^2, each to one level, as in
:mod:`hhrl_envs.simulation.rewards`. With the steps n, the unsmoothness u and the share of success s of a policy:

    r^o = -sigma_1 n + sigma_4 s               - U^o - C^o - L^o      U^o + U^a = unsafe
    r^a = -sigma_1 n + sigma_4 s - sigma_2 u   - U^a - C^a - L^a      C^o + C^a = sigma_3 * share of collisions

How the unsafe penalties U and the collisions C split between the levels, and the charges L for running the line, are
not printed: they are unknowns, like sigma, none of them negative. Only what always is the selected sub-goal's is known:
C^o = L^a = 0 for Rule 1, which always follows, and C^a = L^o = 0 for Rule 2, which always stops. No policy of Table I
runs out of time.
"""

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

from hhrl_bench.paper_table import CASES, TABLE_I, PaperRow
from hhrl_bench.schema import Finite, Name, Record, finite
from hhrl_envs import SUB_GOALS, Option, Outcome
from hhrl_envs.arrays import Floats
from hhrl_envs.scenario.scenario import Reward

SIGMAS = ("sigma_1", "sigma_2", "sigma_3", "sigma_4")
ALWAYS: Mapping[str, Option] = {"rule-1": Option.FFV, "rule-2": Option.SSL}
"""The option that a policy of Table I always selects."""

_FIRST = len(SIGMAS)  # the splits of the first policy follow sigma
_SPLITS = range(6)
_UNSAFE_O, _UNSAFE_A, _COLLISION_O, _COLLISION_A, _LINE_O, _LINE_A = _SPLITS
_FAILURES = {Outcome.COLLISION: (_COLLISION_O, _COLLISION_A), Outcome.NOT_STOP: (_LINE_O, _LINE_A)}
"""What the failure of a sub-goal costs at the option level, and at the action level, in the order of splits."""


class Reading(NamedTuple):
    """A way to read Table I: sigma [4]; what it leaves of r^o and r^a, float64 [policies, 2], printed less computed.

    ``line_speed`` [policies] is the root mean square of the speed over the line, in m/s; NaN where no line was run, or
    where the option that ran it is not known.
    """

    sigma: tuple[float, ...]
    residuals: Floats
    line_speed: Floats

    @property
    def largest(self) -> float:
        """The largest residual, positive."""
        return float(np.abs(self.residuals).max())


class _Program(NamedTuple):
    """Rewards [2 x policies] = matrix @ unknowns; balance @ unknowns = total; the bounds of each unknown."""

    matrix: Floats
    rewards: Floats
    balance: Floats
    total: Floats
    bounds: list[tuple[float, float]]


def recover(rows: Sequence[PaperRow], held: Mapping[str, float] | None = None) -> Reading:
    """Return the reading of the rows with the smallest largest residual; ``held`` keeps some of `SIGMAS` at a value."""
    program = _program(rows, held or {})
    found = _solve(program, np.append(np.zeros(program.matrix.shape[1]), 1.0), math.inf)[:-1]
    residuals = (program.rewards - program.matrix @ found).reshape(-1, 2)
    charged = found[_FIRST:].reshape(-1, len(_SPLITS))[:, [_LINE_O, _LINE_A]].sum(axis=1)
    ran = np.array([row.not_stop / CASES if row.counterpart in ALWAYS else 0.0 for row in rows])
    speed = np.sqrt(np.divide(charged, ran, out=np.full(len(rows), np.nan), where=ran > 0.0))
    return Reading(tuple(found[:_FIRST].tolist()), residuals, speed)


def ranges(rows: Sequence[PaperRow], largest: float) -> tuple[tuple[float, float], ...]:
    """Return the least and the most that each of `SIGMAS` can be if no residual exceeds ``largest``."""
    program = _program(rows, {})
    costs = np.eye(_FIRST, program.matrix.shape[1] + 1)
    solved = [[_solve(program, sign * cost, largest)[k] for sign in (1.0, -1.0)] for k, cost in enumerate(costs)]
    return tuple((float(low), float(high)) for low, high in solved)


def _solve(program: _Program, cost: Floats, largest: float) -> Floats:
    """Return the unknowns, and behind them the largest residual, that cost least; it may be ``largest`` at most."""
    from scipy.optimize import linprog  # noqa: PLC0415

    margin = np.ones((len(program.rewards), 1))
    within: Floats = np.block([[program.matrix, -margin], [-program.matrix, -margin]])
    outcome = linprog(
        cost,
        A_ub=within,
        b_ub=np.concatenate([program.rewards, -program.rewards]),
        A_eq=np.pad(program.balance, ((0, 0), (0, 1))),
        b_eq=program.total,
        bounds=[*program.bounds, (0.0, largest)],
    )
    return np.asarray(outcome.x, np.float64)


def _program(rows: Sequence[PaperRow], held: Mapping[str, float]) -> _Program:
    unknowns = _FIRST + len(_SPLITS) * len(rows)
    matrix, balance = np.zeros((2, 2 * len(rows), unknowns))
    bounds = [(0.0, math.inf)] * unknowns
    for name, value in held.items():
        bounds[SIGMAS.index(name)] = value, value
    for i, row in enumerate(rows):
        first = _FIRST + len(_SPLITS) * i
        option, action, unsafe, collision = matrix[2 * i], matrix[2 * i + 1], balance[2 * i], balance[2 * i + 1]
        option[[0, 3]] = action[[0, 3]] = -row.steps, row.success / CASES
        action[1] = -row.unsmooth
        option[[first + split for split in (_UNSAFE_O, _COLLISION_O, _LINE_O)]] = -1.0
        action[[first + split for split in (_UNSAFE_A, _COLLISION_A, _LINE_A)]] = -1.0
        unsafe[[first + _UNSAFE_O, first + _UNSAFE_A]] = 1.0
        collision[[first + _COLLISION_O, first + _COLLISION_A]] = 1.0
        collision[2] = -row.collision / CASES
        for split in _never(row):
            bounds[first + split] = 0.0, 0.0
    rewards = np.array([(row.return_option, row.return_action) for row in rows]).ravel()
    total = np.array([(row.unsafe, 0.0) for row in rows]).ravel()
    return _Program(matrix, rewards, balance, total, bounds)


def _never(row: PaperRow) -> set[int]:
    """Return the splits that are zero: no line was run, or the option that always is selected answers for it."""
    never = set() if row.not_stop else {_LINE_O, _LINE_A}
    if (always := ALWAYS.get(row.counterpart)) is not None:
        for goal in SUB_GOALS:
            at_option, at_action = _FAILURES[goal.failure]
            never.add(at_option if goal.option == always else at_action)
    return never


DEFAULT = "default"
HELD: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "recovered": {},
        DEFAULT: {name: getattr(Reward(), name) for name in SIGMAS},
        "sigma_1 = 0.1": {"sigma_1": 0.1},
        "sigma_4 = 100": {"sigma_4": 100.0},
        "both": {"sigma_1": 0.1, "sigma_4": 100.0},
    }
)
"""The readings by name, and what each keeps fixed: nothing, the scenarios' sigma, or values that one might guess."""


class PolicyRecord(Record):
    """What a reading leaves of a policy's r^o and r^a, printed less computed, and its speed over the line in m/s."""

    policy: Name
    return_option: Finite
    return_action: Finite
    line_speed: Finite | None


class ReadingRecord(Record):
    """One reading of Table I: sigma, the largest residual, and the residuals of every policy."""

    name: Name
    sigma: dict[str, Finite]
    largest: Finite
    policies: tuple[PolicyRecord, ...]


class SigmaRecord(Record):
    """The readings, and the least and the most that sigma can be if no residual exceeds the default's largest."""

    readings: tuple[ReadingRecord, ...]
    least: dict[str, Finite]
    most: dict[str, Finite]


def measure() -> SigmaRecord:
    """Return the readings of Table I that are in `HELD`."""
    readings = tuple(_record(name, recover(TABLE_I, held)) for name, held in HELD.items())
    default = next(reading.largest for reading in readings if reading.name == DEFAULT)
    bounds = dict(zip(SIGMAS, ranges(TABLE_I, default), strict=True))
    return SigmaRecord(
        readings=readings,
        least={name: low for name, (low, _) in bounds.items()},
        most={name: high for name, (_, high) in bounds.items()},
    )


def print_sigma(console: Console, record: SigmaRecord) -> None:
    """Print a column a reading: sigma, the largest residual, and the ten residuals."""
    table = Table(box=box.HORIZONTALS, show_edge=False, pad_edge=False, caption_justify="left")
    table.caption = (
        "Residuals: Table I less what the reading gives, as small as the largest of them allows.\n"
        "Range: what sigma can be if no residual exceeds the default's largest.\n"
        "v: root mean square of Rule 1's speed over the line, m/s."
    )
    table.add_column("")
    for reading in record.readings:
        table.add_column(reading.name, justify="right")
    table.add_column("range", justify="right")
    for name in SIGMAS:
        said = f"{record.least[name]:.3g} to {record.most[name]:.3g}"
        table.add_row(name, *(f"{reading.sigma[name]:.3g}" for reading in record.readings), said)
    table.add_row("v", *(f"{reading.policies[0].line_speed:.2f}" for reading in record.readings))
    table.add_row("largest residual", *(f"{reading.largest:.2f}" for reading in record.readings))
    table.add_section()
    for i, policy in enumerate(TABLE_I):
        for column, symbol in (("return_option", "r^o"), ("return_action", "r^a")):
            left = (getattr(reading.policies[i], column) for reading in record.readings)
            table.add_row(f"{policy.policy} {symbol}", *(f"{value:+.2f}" for value in left))
    console.print(table)


def _record(name: str, reading: Reading) -> ReadingRecord:
    rows = zip(TABLE_I, reading.residuals.tolist(), reading.line_speed.tolist(), strict=True)
    policies = tuple(
        PolicyRecord(policy=row.policy, return_option=option, return_action=action, **finite({"line_speed": speed}))
        for row, (option, action), speed in rows
    )
    sigma = dict(zip(SIGMAS, reading.sigma, strict=True))
    return ReadingRecord(name=name, sigma=sigma, largest=reading.largest, policies=policies)
