"""An analysis as tables to read: option usage, per-level rewards, and the mean attention by option."""

from rich import box
from rich.console import Console
from rich.table import Table

from hhrl_bench.analysis.records import (
    AnalysisRecord,
    LevelRewardsRecord,
    OptionUsageRecord,
    Weights,
    grouped,
    named,
    shown,
)
from hhrl_bench.schema import OptionName
from hhrl_bench.text import NONE
from hhrl_envs.observation import SYMBOLS

FLAT = "The agent is flat: it has no options, so there is no option usage, and its only reward is r^task."
NO_ATTENTION = "No attention: only agents that learned an attention(observations, option) have one."


def print_analysis(console: Console, record: AnalysisRecord) -> None:
    """Print the tables, and a line in place of what the agent does not have."""
    parts: list[Table | str] = [f"{named(record)}, {record.task.episodes:,} test episodes"]
    parts += [FLAT] if record.option_usage is None else [_usage(record.option_usage), _places(record.option_usage)]
    parts += [_levels(record.level_rewards)]
    parts += [NO_ATTENTION if record.attention is None else _attention(record.attention)]
    for place, part in enumerate(parts):
        if place > 0:
            console.print()
        console.print(part, markup=False, highlight=False, soft_wrap=isinstance(part, str))


def _usage(usage: OptionUsageRecord) -> Table:
    table = _table("outcome", "episodes", "steps", *usage.overall.share, "switches an episode")
    for name, row in grouped(usage.overall, usage.by_outcome).items():
        shares = [f"{share:.1%}" for share in row.share.values()]
        table.add_row(name, f"{row.episodes:,}", f"{row.steps:,}", *shares, f"{row.switches:.2f}")
    return table


def _places(usage: OptionUsageRecord) -> Table:
    names = list(usage.overall.share)
    table = _table("metres", "d_d: steps", *names, "d_f: steps", *names)
    bins = {(one.low, one.high): ["0", *[NONE] * len(names)] * 2 for one in (*usage.by_d_d, *usage.by_d_f) if one.steps}
    for first, columns in ((0, usage.by_d_d), (1 + len(names), usage.by_d_f)):
        for one in columns:
            if one.share:
                cells = [f"{one.steps:,}", *(f"{share:.1%}" for share in one.share.values())]
                bins[one.low, one.high][first : first + len(cells)] = cells
    for low, high in sorted(bins, key=lambda bounds: (bounds[1] is None, bounds)):
        table.add_row(_bounds(low, high), *bins[low, high])
    return table


def _bounds(low: float, high: float | None) -> str:
    return "out of range" if high is None else f"{low:g} to {high:g}"


def _levels(rewards: LevelRewardsRecord) -> Table:
    table = _table("outcome", "level", "reward", "sub-goal", "unsafe", "failure", "jerk", texts=2)
    for name, group in grouped(rewards.overall, rewards.by_outcome).items():
        heading = f"{name} ({group.episodes:,})"
        for level, means in shown(group.levels).items():
            terms = [f"{value:z.2f}" for value in means.terms.values()]
            table.add_row(heading, f"r^{level}", f"{means.total:z.2f}", *terms)
            heading = ""
    return table


def _attention(attention: dict[OptionName, Weights]) -> Table:
    table = _table("mean attention", *attention)
    for symbol in SYMBOLS:
        table.add_row(symbol, *(f"{weights[symbol]:.1%}" for weights in attention.values()))
    return table


def _table(*headings: str, texts: int = 1) -> Table:
    """Return an empty table whose columns after the first ``texts`` hold numbers."""
    table = Table(box=box.HORIZONTALS, show_edge=False, pad_edge=False)
    for place, heading in enumerate(headings):
        table.add_column(heading, justify="left" if place < texts else "right", no_wrap=True)
    return table
