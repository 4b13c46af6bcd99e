"""Reference rows: Table I of Qiao et al., IROS 2020 (arXiv 1911.03799), 100 test cases a policy."""

from typing import NamedTuple

CASES = 100
TABLE_I_TASK = "stop-line-paper-v0"
"""The only task that Table I is shown beside: its traffic is fitted to it."""


class PaperRow(NamedTuple):
    """One policy of Table I: rewards, counts and sums are means an episode; the last four are counts of 100 cases."""

    policy: str
    counterpart: str
    return_option: float
    return_action: float
    steps: float
    unsmooth: float
    unsafe: float
    collision: int
    not_stop: int
    timeout: int
    success: int


TABLE_I = (
    PaperRow("Rule 1", "rule-1", -36.82, -9.11, 112, 0.38, 8.05, 18, 82, 0, 0),
    PaperRow("Rule 2", "rule-2", -28.69, 0.33, 53, 0.32, 6.41, 89, 0, 0, 11),
    PaperRow("Rule 3", "rule-3", 26.42, 13.62, 128, 0.54, 13.39, 31, 0, 0, 69),
    PaperRow("Rule 4", "rule-4", 40.02, 17.20, 149, 0.58, 16.50, 14, 0, 0, 86),
    PaperRow("Hybrid HRL", "hybrid-hrl", 43.52, 28.87, 178, 5.32, 1.23, 0, 7, 0, 93),
)
