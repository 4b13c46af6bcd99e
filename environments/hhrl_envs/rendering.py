"""Pictures of one row of a simulator: the road seen from above, to scale, with what the agent selected and measured.

Needs the ``render`` extra. Nothing is shown on a screen; a frame is an array, so it works on any machine.
"""

import numpy as np
from numpy.typing import NDArray

from hhrl_envs.extras import require
from hhrl_envs.moments import moment_of
from hhrl_envs.scenario import Scenario
from hhrl_envs.simulator import Simulator


class Renderer:
    """Draws frames of a scenario's worlds.

    Raises:
        MissingExtraError: the ``render`` extra is not installed.
    """

    def __init__(self, scenario: Scenario) -> None:
        require("pygame", extra="render")
        self.scenario = scenario

    def frame(self, simulator: Simulator, row: int = 0, option: int | None = None) -> NDArray[np.uint8]:
        """Return the picture of one row, uint8 [240, 960, 3].

        ``option`` is the selected sub-goal, whose target is highlighted; None or -1 for a flat agent.
        """
        from hhrl_envs.scene import picture  # noqa: PLC0415  (the extra is needed only from here on)

        return picture(moment_of(simulator, row, option))
