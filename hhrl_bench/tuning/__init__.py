"""Tuning: search for the numbers of an agent within a task's training budget, on its training worlds."""
