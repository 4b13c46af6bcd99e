"""What sensors distort: how far they see, how exact and how late they are, and what they miss or make up."""

from dataclasses import dataclass, field

from hhrl_envs.scenario import limits
from hhrl_envs.scenario.hashing import ADDITION
from hhrl_envs.scenario.limits import numbers
from hhrl_envs.scenario.validation import check, instance, integer, optional


@dataclass(frozen=True)
class Ghosts:
    """Standing vehicles that sensors report and that do not exist, as a radar does below bridges and signs.

    The road is cut into stretches of ``stretch`` metres, the first of them from the farthest place that an ego may
    start at. A ``share`` of them has a ghost, anywhere in it. An agent reads a vehicle that
    stands where the nearest of the ghosts at least ``near`` metres ahead is, if that one is nearer than its front
    vehicle.
    """

    share: float
    stretch: float = 40.0
    near: float = 8.0

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        check(self, **numbers(limits.GHOSTS, "share", "stretch", "near"))


@dataclass(frozen=True)
class Sensor:
    """What the agents' sensors do: ranges, normal noise on the base quantities (standard deviations), delay in steps.

    Safety distances are computed from the noisy quantities; rewards and outcomes use the truth.

    The front sensor may drop out. An episode is cut into windows of ``dropout_time`` seconds, rounded to whole steps,
    the first of them from its start on. With the chance ``dropout`` an agent reads a free road all through a window,
    whatever is in front. In the first window nothing drops out, so every agent has once seen who is in front of it.
    It may report ``ghosts``, too; while it drops out it reports nothing.
    """

    front_range: float = 100.0
    line_range: float = 100.0
    noise_distance: float = 0.0
    noise_speed: float = 0.0
    noise_accel: float = 0.0
    delay: int = 0
    dropout: float = field(default=0.0, metadata=ADDITION)
    dropout_time: float = field(default=1.0, metadata=ADDITION)
    ghosts: Ghosts | None = field(default=None, metadata=ADDITION)

    def __post_init__(self) -> None:
        """Reject values without a meaning."""
        measured = ("front_range", "line_range", "noise_distance", "noise_speed", "noise_accel")
        dropouts = numbers(limits.SENSOR, "dropout", "dropout_time")
        check(self, **numbers(limits.SENSOR, *measured), **dropouts, delay=integer(*limits.SENSOR["delay"]))
        check(self, ghosts=optional(instance(Ghosts)))

    @property
    def perfect(self) -> bool:
        """Whether the agents see the truth."""
        exact = self.noise_distance == self.noise_speed == self.noise_accel == 0.0
        return exact and self.delay == 0 and self.dropout == 0.0 and self.ghosts is None
