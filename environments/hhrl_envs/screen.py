"""What a view draws: a frame when asked for one, or a window that follows every step."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.errors import InputError
from hhrl_envs.options import Option
from hhrl_envs.rendering import Renderer
from hhrl_envs.simulator import Simulator

if TYPE_CHECKING:
    from hhrl_envs.window import Window


class Screen:
    """Draws row 0 of a simulator as ``render_mode`` says: 'human' into a window, 'rgb_array' as arrays.

    ``option`` is the sub-goal that the pictures show as selected, until the next episode begins; None for a flat agent.

    Raises:
        MissingExtraError: the ``render`` extra is not installed.
    """

    def __init__(self, simulator: Simulator, render_mode: str) -> None:
        self._simulator, self._mode = simulator, render_mode
        self._renderer = Renderer(simulator.scenario)
        self._window: Window | None = None
        self._began = False
        self.option: Option | None = None

    def begin(self) -> None:
        """Take note that an episode has begun."""
        self._began, self.option = True, None
        self.follow()

    def follow(self) -> None:
        """Show the present moment where the mode is 'human'."""
        if self._mode == "human" and not self._opened().closed:
            self._opened().show(self._frame())

    def render(self) -> NDArray[np.uint8] | None:
        """Return the picture of the present moment, uint8 [H, W, 3]; None where a window shows it already."""
        if not self._began:
            raise InputError("render before reset; call reset(seed=...) first")
        return None if self._mode == "human" else self._frame()

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()

    def _frame(self) -> NDArray[np.uint8]:
        return self._renderer.frame(self._simulator, option=self.option)

    def _opened(self) -> "Window":
        if self._window is None:
            from hhrl_envs.window import Window  # noqa: PLC0415  (only the render extra brings what it needs)

            scenario = self._simulator.scenario
            self._window = Window(f"hhrl-bench {scenario.id}", round(1.0 / scenario.dt))
        return self._window
