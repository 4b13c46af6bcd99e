"""What every misuse comes to: one line that says what is wrong."""

from collections.abc import Callable

import pytest

from hhrl_envs import InputError


def refused(call: Callable[[], object], *said: str) -> None:
    """The call raises an ``InputError`` of one line that says all of these words."""
    with pytest.raises(InputError) as caught:
        call()
    message = str(caught.value)
    assert "\n" not in message
    for words in said:
        assert words in message
