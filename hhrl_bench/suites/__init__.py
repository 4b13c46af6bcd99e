"""Benchmark suites as data, the units of work that they come to, and the leaderboard made of what these came to."""
