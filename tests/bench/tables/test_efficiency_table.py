"""The table of sample efficiency fits its console, and says who never gets there."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from hhrl_bench.leaderboard.efficiency import efficiency
from hhrl_bench.tables.learning import efficiency_table
from hhrl_bench.tables.terminal import print_table
from support.trainings import training

SOON, NEVER = (0.0, 1.0, 1.0, 1.0), (0.0, 0.0, 0.0, 0.0)


def printed(width: int) -> list[str]:
    trainings = [
        training([SOON, NEVER, SOON]),
        training([NEVER, NEVER], method="hybrid-hrl"),
        training([SOON], task="stop-line-wet-v0", seeds=(4,)),
    ]
    out = StringIO()
    table = efficiency_table([efficiency(one, np.random.default_rng(0)) for one in trainings])
    print_table(Console(file=out, width=width), table, notes="below")
    return out.getvalue().splitlines()


@pytest.mark.parametrize("width", [30, 45, 60, 80, 140])
def test_the_table_fits_and_names_every_task_and_method(width: int) -> None:
    lines = printed(width)
    assert max(map(len, lines)) <= width
    text = " ".join(" ".join(lines).split())
    assert "…" not in text
    assert text.count("ddqn") == 2
    for said in ("to 93% validation success", "stop-line-v0", "stop-line-wet-v0", "hybrid-hrl"):
        assert said in text
    assert ("wider terminal" in text) == (width < 60)


def test_a_line_holds_median_interval_count_slowest_seed_and_budget() -> None:
    cells = [line.split() for line in printed(80)]
    assert ["ddqn", "10", "10,", "never", "2", "of", "3", "never", "(1)", "30"] in cells
    assert ["hybrid-hrl", "never", "30,", "never", "0", "of", "2", "never", "(0)", "30"] in cells
    assert ["ddqn", "10", "1", "of", "1", "10", "(4)", "30"] in cells
