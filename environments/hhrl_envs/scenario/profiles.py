"""Behaviour profiles: how one front vehicle drives in one episode.

A profile is drawn per vehicle and per episode: a family by its weight, then every parameter uniformly from the family's
range. Units are SI. Sources of the ranges:

- car following (desired speed, headway, acceleration, comfortable deceleration, gap): the Intelligent Driver Model of
  Treiber, Hennecke and Helbing (2000), spread around the defaults of SUMO, nuPlan and Waymax;
- stop position: the first car of a queue halts 1.1 +- 1.1 m before the line (TRID 152931); queue gaps 1.5 to 3.7 m;
- braking for the line peaks near 2.5 m/s^2 at stop signs (SWOV), the design value is 3.4 m/s^2; hard braking lies
above;
- rolling stops: the mean minimum speed is 11.5 km/h (TRID 1496765);
- dwell: no distribution was found in print, the range is a design choice.
"""

from dataclasses import dataclass

from hhrl_envs.scenario.limits import FAMILY, PROFILE, intervals, numbers
from hhrl_envs.scenario.validation import check, shares, text

Range = tuple[float, float]

STYLES = ("full", "rolling", "runs")

PARAMETERS: dict[str, str] = {name: limits.unit for name, limits in PROFILE.items()}
"""Name and unit of every profile parameter, in the order of the fields of a vehicle's record from PROFILE on."""


@dataclass(frozen=True)
class ProfileFamily:
    """One family of drivers: its share of the traffic, its stop styles, and the range of every parameter.

    ``styles`` are the probabilities of a full stop, a rolling stop and running the line. A rolling vehicle passes the
    line at ``line_speed``; a full stop halts ``stop_position`` metres before the line (negative: past it) and stands
    for ``dwell``. With probability ``slow_chance`` the vehicle brakes without a reason, ``slow_at`` metres before the
    line and again every ``slow_every`` metres.
    """

    name: str
    weight: float
    desired_speed: Range = (8.0, 12.0)
    headway: Range = (0.8, 2.0)
    max_accel: Range = (0.8, 2.6)
    comfort_decel: Range = (1.5, 4.5)
    min_gap: Range = (1.0, 3.5)
    line_decel: Range = (1.5, 3.4)
    stop_position: Range = (0.0, 2.2)
    line_speed: Range = (2.0, 4.5)
    dwell: Range = (0.5, 4.0)
    start_delay: Range = (0.3, 1.5)
    slow_at: Range = (10.0, 50.0)
    slow_decel: Range = (2.0, 5.0)
    slow_time: Range = (0.5, 2.0)
    slow_every: Range = (1000.0, 1000.0)
    slow_chance: float = 0.0
    styles: tuple[float, float, float] = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Reject a family that no vehicle could be drawn from."""
        check(self, name=text(r"\S(.*\S)?", "a name of one line, such as 'calm'"))
        check(
            self,
            f"profile family {self.name!r}: ",
            **numbers(FAMILY, "weight", "slow_chance"),
            **intervals(PROFILE, *PROFILE),
            styles=shares(3, 3, f"the three shares of {', '.join(STYLES)}"),
        )
