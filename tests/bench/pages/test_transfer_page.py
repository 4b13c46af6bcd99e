"""The table of docs/transfer.md says what the published leaderboard of transfers holds."""

import re
from pathlib import Path

import pytest

from hhrl_bench.leaderboard.entry import read_entry
from hhrl_bench.transfer.records import TransferRecord

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "transfer.md").read_text()
TRANSFER = read_entry(ROOT / "leaderboards" / "transfer.json").transfer
assert TRANSFER is not None
ARMS = {(row.target, row.method, row.arm): row for row in TRANSFER.rows}
METHODS = ("hybrid-hrl", "hybrid-hrl-plus", "ddqn")
TARGETS = ("stop-and-go-v0", "two-stops-v0", "red-light-v0", "solo-stop-v0", "option-only-v0")


def steps(row: TransferRecord | None) -> str:
    """Return the steps to the threshold as the table says them: how many seeds get there if fewer than six do."""
    if row is None:
        return ""
    reached, seeds, median = row.steps_to_threshold.reached, len(row.seeds), row.steps_to_threshold.median
    if median is None or reached < 6:
        return f"{reached} of {seeds}" if reached else "never"
    return f"{median / 1000:.0f}" + (f" ({reached} of {seeds})" if reached < seeds else "")


def worth(row: TransferRecord | None) -> list[str]:
    """Return the steps ratio and the forward transfer."""
    if row is None or row.over_scratch is None:
        return ["", ""]
    ratio, forward = row.over_scratch.steps_ratio, row.over_scratch.forward_transfer
    gain = f"{forward.mean:+.2f} ({forward.low:.2f}, {forward.high:.2f})"
    if ratio.at_least == 0.0 and ratio.at_most is None:
        return ["unknown", gain]
    at = f"{ratio.at_least:.2f}" if ratio.at_most is not None else f"at least {ratio.at_least:.2f}"
    high = "no bound" if ratio.high is None else f"{ratio.high:.2f}"
    return [f"{at} ({ratio.low:.2f}, {high})", gain]


def table() -> dict[tuple[str, str], list[str]]:
    """Return the other cells of every row by its target and method."""
    found, target = {}, ""
    for first, method, rest in re.findall(r"^\| (`[a-z0-9-]+`)? ?\| `([a-z-]+)` \| (.*)\|$", PAGE, re.MULTILINE):
        target = first.strip("`") or target
        found[target, method] = [cell.strip() for cell in rest.split("|")]
    return found


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("method", METHODS)
def test_a_row_holds_what_the_arms_come_to(target: str, method: str) -> None:
    arms = [ARMS.get((target, method, arm)) for arm in ("zero-shot", "frozen-action", "fine-tune", "scratch")]
    rows = table()
    assert ((target, method) in rows) == any(arms)
    if any(arms):
        assert rows[target, method] == [*map(steps, arms), *worth(arms[1])]
