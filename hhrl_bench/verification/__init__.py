"""Verification: whether an entry says what its stored decisions, its checkpoints and its own numbers come to."""
