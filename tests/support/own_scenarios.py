"""Scenarios that a test registers, and that the process forgets again."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from hhrl_envs.scenario import registry


@contextmanager
def forgotten_scenarios() -> Iterator[None]:
    """Forget what is registered and imported in this context."""
    scenarios, places, modules, path = dict(registry._by_id), dict(registry._places), set(sys.modules), [*sys.path]
    try:
        yield
    finally:
        registry._by_id.clear()
        registry._by_id.update(scenarios)
        registry._places.clear()
        registry._places.update(places)
        for name in [one for one in sys.modules if one in {"mine", "gentle", "noisy"} - modules]:
            del sys.modules[name]
        sys.path[:] = path
