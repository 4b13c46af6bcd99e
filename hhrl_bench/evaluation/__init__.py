"""Evaluation: agents by name, the rollout of their episodes, the metrics of these, and the records of results."""
