"""SUMO in this process (libsumo), stepped as reinforcement learning does: an ego behind five vehicles in one lane.

A step sets the ego's speed, simulates 0.1 s, and reads what an observation would be made of: the ego's speed, position
and acceleration, its leader with the gap to it, and the distance to the end of the road. Reading the leader's own speed
and packing an array would come on top. The first vehicle stops for good at the end of the road, so that all six remain
and no step of a round is cheaper for want of traffic. Loading a simulation, SUMO's reset, is not in the price.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from benchmarks.systems import System

LENGTH, SPEED, SIGHT = 500.0, 13.9, 200.0
NETWORK = f"""<net version="1.20">
  <location netOffset="0,0" convBoundary="0,0,{LENGTH},0" origBoundary="0,0,{LENGTH},0" projParameter="!"/>
  <edge id="road" from="start" to="end">
    <lane id="road_0" index="0" speed="{SPEED}" length="{LENGTH}" shape="0,0 {LENGTH},0"/>
  </edge>
  <junction id="start" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0"/>
  <junction id="end" type="dead_end" x="{LENGTH}" y="0" incLanes="road_0" intLanes="" shape="{LENGTH},0"/>
</net>
"""
STOP = f'<stop lane="road_0" endPos="{LENGTH - 1}" duration="1000000"/>'
VEHICLES = {"first": 160, "second": 130, "third": 100, "fourth": 70, "fifth": 40, "ego": 10}


def routes() -> str:
    """Return the six vehicles as SUMO reads them, each at its place along the road at 8 m/s."""
    vehicles = (
        f'<vehicle id="{name}" route="ahead" depart="0" departPos="{place}" departSpeed="8">'
        f"{STOP if name == 'first' else ''}</vehicle>"
        for name, place in VEHICLES.items()
    )
    return f'<routes><route id="ahead" edges="road"/>{"".join(vehicles)}</routes>'


@contextmanager
def sumo(folder: Path, steps: int = 10_000) -> Iterator[System]:
    """Yield the one simulation that a process may have, its files in ``folder``."""
    libsumo = pytest.importorskip("libsumo", reason="SUMO is not installed; install the extra [peers]")
    (folder / "road.net.xml").write_text(NETWORK)
    (folder / "queue.rou.xml").write_text(routes())
    files = ["-n", str(folder / "road.net.xml"), "-r", str(folder / "queue.rou.xml")]
    options = [*files, "--step-length", "0.1", "--time-to-teleport", "-1", "--no-step-log", "--no-warnings"]
    vehicle, speeds = libsumo.vehicle, np.random.default_rng(0).uniform(0.0, SPEED, steps).tolist()

    def prepare() -> None:
        libsumo.load(options)
        libsumo.simulationStep()

    def run() -> None:
        for speed in speeds:
            vehicle.setSpeed("ego", speed)
            libsumo.simulationStep()
            position = vehicle.getLanePosition("ego")
            leader = vehicle.getLeader("ego", SIGHT)
            _ = vehicle.getSpeed("ego"), vehicle.getAcceleration("ego"), leader, LENGTH - position

    libsumo.start(["sumo", *options])
    try:
        yield System("SUMO (libsumo), 6 vehicles", steps, prepare, run)
        assert vehicle.getIDCount() == len(VEHICLES), "SUMO was measured with fewer vehicles"
    finally:
        libsumo.close()
