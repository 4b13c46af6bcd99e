"""Benchmark tasks: scenarios with training budgets and the disjoint seed ranges of their worlds."""
