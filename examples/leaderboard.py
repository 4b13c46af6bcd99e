"""Read a published leaderboard: the success of every agent with its 95% interval, and every training seed's."""

from pathlib import Path

from hhrl_bench.leaderboard.entry import read_entry

board = read_entry(Path(__file__).parents[1] / "leaderboards" / "quick.json")
for result in board.results:
    success = result.metrics.success
    low, high = success.low or 0.0, success.high or 0.0
    print(f"{result.agent} on {result.task}: {success.mean:.1%} ({low:.1%}, {high:.1%})")
    for run in result.runs:
        if run.training:
            print(f"  training seed {run.training.seed}: {run.metrics.success:.1%}")
