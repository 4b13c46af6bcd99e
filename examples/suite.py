"""Add a suite: rule agents on the harder tiers.

    hhrl-bench --extension examples/suite.py run --suite rules-on-tiers --out runs/rules-on-tiers/entry.json

A suite names agents and tasks; `run` scores every agent on every task and writes a leaderboard file.
"""

from hhrl_bench import register_suite
from hhrl_bench.suites.suites import ScoreSuite

SUITE = ScoreSuite(
    "rules-on-tiers",
    agents=("rule-3", "rule-4", "rule-plus"),
    tasks=("stop-line-dense-v1", "stop-line-wet-v1"),
    episodes=200,
)
register_suite(SUITE)

if __name__ == "__main__":
    print(f"suite {SUITE.id} scores {', '.join(SUITE.agents)} on {', '.join(SUITE.tasks)}")
