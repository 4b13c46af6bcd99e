"""What the command ``sigma`` reports: ways to read Table I, as a record and as a table."""

from collections.abc import Mapping
from types import MappingProxyType

from rich import box
from rich.console import Console
from rich.table import Table

from hhrl_bench.metrics import finite
from hhrl_bench.paper import TABLE_I
from hhrl_bench.records import Finite, Name, Record
from hhrl_bench.sigma import SIGMAS, Reading, ranges, recover
from hhrl_envs.scenario import Reward

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
    """Return nothing; print a column a reading: sigma, the largest residual, and the ten residuals."""
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
