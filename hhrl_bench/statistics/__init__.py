"""Statistics: estimates with bootstrap and Wilson intervals, and medians of times that are censored at a budget."""
