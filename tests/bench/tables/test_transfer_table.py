"""The transfer table fits its console, and says what is censored, bounded or undefined."""

from collections.abc import Sequence
from io import StringIO

import pytest
from rich.console import Console

from hhrl_bench.tables.terminal import print_tables
from hhrl_bench.tables.transfers import ARM_COLUMNS, transfer_tables
from hhrl_bench.text import NONE
from hhrl_bench.transfer.records import TransferRecord
from hhrl_bench.transfer.summary import ArmCurves, TransferCurves, transfer_set
from support.transfers import arms, study


def printed(rows: Sequence[TransferRecord], width: int) -> list[str]:
    out = StringIO()
    print_tables(Console(file=out, width=width), transfer_tables(rows, known=True))
    return out.getvalue().splitlines()


def line(lines: list[str], arm: str) -> list[str]:
    """Return the cells of an arm's first line."""
    return next(text.replace("<= ", "<=").replace(">= ", ">=").split() for text in lines if text.startswith(f"  {arm}"))


@pytest.mark.parametrize("width", [40, 60, 80, 100, 140])
def test_the_table_fits_and_names_every_method_source_target_and_arm(width: int) -> None:
    lines = printed(study().rows, width)
    assert max(map(len, lines)) <= width
    text = " ".join(" ".join(lines).split())
    assert "…" not in text
    for heading in ("ddqn trained on stop-line-v0, seeds 0-2,5", "hybrid-hrl trained on two-stops-v0, seeds 0-2,5"):
        assert heading in text
    assert text.count("zero-shot") == text.count("frozen-action") == text.count("fine-tune") == 5
    assert ("wider terminal" in text) == (width < 140)
    assert ("The pair with a number" in text) == (width == 140)


def test_an_arms_line_holds_its_numbers_and_the_line_below_their_intervals() -> None:
    lines = printed(transfer_set([TransferCurves("a", "b", "m", arms())]).rows, 140)
    assert line(lines, "zero-shot")[1:] == ["50.0%", "never", ">=1.00", "-0.10", "+0.50", "50.0%", "-0.50", "-0.08"]
    assert line(lines, "fine-tune")[1:] == ["50.0%", "30", "0.60", "+0.69", "+0.50", "100.0%", "+0.00", "+0.59"]
    assert line(lines, "scratch")[1:] == ["0.0%", "50", NONE, NONE, NONE, "100.0%", NONE, NONE]
    below = lines[next(i for i, text in enumerate(lines) if "fine-tune" in text) + 1]
    assert "50.0, 50.0" in below
    assert "0.60, 0.75" in below
    assert "1.00, inf" in "".join(lines)


def test_censored_seeds_are_counted_and_bounds_said() -> None:
    reached, never = (0.0, 0.5, 1.0), (0.0, 0.0, 0.0)
    grid, seeds = (0, 10_000, 20_000), (0, 1, 2)
    curves = {
        "fine-tune": ArmCurves(seeds, grid, (reached, reached, never)),
        "frozen-action": ArmCurves(seeds, grid, (reached, never, never)),
        "scratch": ArmCurves(seeds, grid, (never, never, (1.0,) * 3)),
    }
    lines = printed(transfer_set([TransferCurves("a", "b", "m", curves)]).rows, 100)  # type: ignore[arg-type]
    text = next(text for text in lines if "fine-tune" in text)
    assert "20 (2 of 3)" in text
    assert "<= 1.00" in text
    assert text.count("(1 of 3)") == 1  # transfer ratio, undefined where scratch has no area
    assert text.count("(2 of 3)") == 2  # and forward transfer, undefined where it has all
    assert " 1 of 3 " in next(text for text in lines if "frozen-action" in text)


def test_headings_are_unique() -> None:
    assert len({column.heading for column in ARM_COLUMNS}) == len(ARM_COLUMNS)
