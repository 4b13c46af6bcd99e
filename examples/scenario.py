"""Add a scenario: a slippery road behind drivers who brake late.

    hhrl-bench --extension examples/scenario.py evaluate rule-4 rule-plus --task stop-line-greasy-v0

A scenario is frozen data. What is not given is that of ``stop-line-v0``; a value without a meaning is refused in one
line. Every scenario whose only agent is the ego is a task of the same id.
"""

from dataclasses import replace

from hhrl_envs import SCENARIOS, ProfileFamily, Traffic, register

MAIN = SCENARIOS["stop-line-v0"]

LATE = ProfileFamily("late", weight=1.0, desired_speed=(8.0, 11.0), line_decel=(3.0, 4.5), dwell=(1.0, 3.0))

SCENARIO = replace(
    MAIN,
    id="stop-line-greasy-v0",
    road=replace(MAIN.road, friction=0.45),
    traffic=Traffic(families=(LATE,), count_shares=(0.2, 0.4, 0.4)),
    feasible_only=False,
)
env, raw_env, parallel_env = register(SCENARIO)  # PettingZoo's constructors; it is in Gymnasium's registry now, too

if __name__ == "__main__":
    from hhrl_envs.simulation.survey import feasible_share

    print(f"{SCENARIO.id}: {feasible_share(SCENARIO, 2_000):.1%} of the worlds can be solved")
    vehicle = parallel_env()
    observations, infos = vehicle.reset(seed=7)
    while vehicle.agents:
        full_braking = dict.fromkeys(vehicle.agents, 0)
        observations, rewards, terminations, truncations, infos = vehicle.step(full_braking)
    print("full braking from the start ends in", infos["ego"]["outcome"].name)
