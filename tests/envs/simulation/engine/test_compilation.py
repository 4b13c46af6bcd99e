"""What compiling leaves behind."""

import gc

import pytest

from hhrl_envs.simulation.engine.compilation import inner, kernel


@pytest.fixture
def collects() -> bool:
    return gc.isenabled()


@pytest.mark.parametrize("enabled", [True, False])
def test_the_garbage_collector_is_afterwards_as_it_was(collects: bool, enabled: bool) -> None:
    @inner
    def part(number: int) -> int:
        return number + 1

    @kernel
    def whole(number: int) -> int:
        return 2 * part(number)

    (gc.enable if enabled else gc.disable)()
    try:
        assert whole(3) == 8
        assert gc.isenabled() == enabled
    finally:
        (gc.enable if collects else gc.disable)()
