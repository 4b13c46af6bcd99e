"""Scenarios as data: what a world is made of, which values are allowed, and the registry of known ones."""
