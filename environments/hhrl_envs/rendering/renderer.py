"""How a view draws itself: a picture when asked for one, or a window that follows every step."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.errors import InputError, require
from hhrl_envs.rendering.snapshot import snapshot_of
from hhrl_envs.simulation.simulator import Simulator
from hhrl_envs.sub_goals import Option

if TYPE_CHECKING:
    from hhrl_envs.rendering.window import Window


class Renderer:
    """Draws row 0 of a simulator as ``render_mode`` says: 'human' into a window, 'rgb_array' as arrays.

    ``option`` is the sub-goal that the pictures show as selected, until the next episode begins; None for a flat agent.

    Raises:
        MissingExtraError: the ``render`` extra is not installed.
    """

    def __init__(self, simulator: Simulator, render_mode: str) -> None:
        require("pygame", extra="render")
        self._simulator, self._mode = simulator, render_mode
        self._window: Window | None = None
        self._began = False
        self.option: Option | None = None

    def reset(self) -> None:
        """Start an episode: no option is selected, and its first state is shown where the mode is 'human'."""
        self._began, self.option = True, None
        self.follow()

    def follow(self) -> None:
        """Show the present state where the mode is 'human'."""
        if self._mode == "human" and not self._opened().closed:
            self._opened().show(self._frame())

    def render(self) -> NDArray[np.uint8] | None:
        """Return the picture of the present state, uint8 [H, W, 3]; None where a window shows it already."""
        if not self._began:
            raise InputError("render before reset; call reset(seed=...) first")
        return None if self._mode == "human" else self._frame()

    def close(self) -> None:
        """Close the window."""
        if self._window is not None:
            self._window.close()

    def _frame(self) -> NDArray[np.uint8]:
        return draw_row(self._simulator, option=self.option)

    def _opened(self) -> "Window":
        if self._window is None:
            from hhrl_envs.rendering.window import Window  # noqa: PLC0415  (only the render extra brings what it needs)

            scenario = self._simulator.scenario
            self._window = Window(f"hhrl-bench {scenario.id}", round(1.0 / scenario.dt))
        return self._window


def draw_row(simulator: Simulator, row: int = 0, option: int | None = None) -> NDArray[np.uint8]:
    """Return the picture of one row's present state, uint8 [240, 960, 3].

    ``option`` is the selected sub-goal, whose target is highlighted; None or -1 for a flat agent.

    Raises:
        MissingExtraError: the ``render`` extra is not installed.
    """
    require("pygame", extra="render")
    from hhrl_envs.rendering.picture import picture  # noqa: PLC0415  (the extra is needed only from here on)

    return picture(snapshot_of(simulator, row, option))
