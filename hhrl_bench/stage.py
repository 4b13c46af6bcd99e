"""The stage of an evaluation: worlds in which an agent drives the vehicles of a cast, and partners the others."""

import numpy as np

from hhrl_agents import Agent, Decision
from hhrl_agents.base import IntArray
from hhrl_agents.cast import EGO_ALONE, Cast
from hhrl_bench.players import Player
from hhrl_bench.seeds import UInt64Array
from hhrl_envs import Option, Outcome, Scenario


class Stage:
    """``rows`` worlds of one scenario, played side by side by an agent; ``option`` holds its option fixed.

    Attributes:
        simulator: the worlds.
        slots: the vehicles that the agent drives in every row.
        results: what the agent's vehicles got from the last step, [B slots]: those of a row side by side.
    """

    def __init__(
        self, agent: Agent, scenario: Scenario, rows: int, option: Option | None = None, cast: Cast = EGO_ALONE
    ) -> None:
        self.simulator = cast.simulator(scenario, rows)
        self.slots = cast.slots
        self._cast, self._player = cast, Player(agent, scenario.num_actions, option)

    def begin(self, seeds: UInt64Array) -> None:
        """Return nothing; put every row at the start of episode 0 of its seed, uint64 [B]."""
        self.simulator.reset(seeds)
        self._cast.begin(np.ones(len(seeds), np.bool_))
        self.results = self._cast.results(self.simulator)
        self._player.reset(np.ones(len(self.results.outcomes), np.bool_))

    def decide(self) -> Decision:
        """Return what the agent decides for its vehicles, [B slots]."""
        return self._player.act(self.results.observations)

    def step(self, decision: Decision) -> IntArray:
        """Return the actions of all vehicles that are driven, [B] or [B, A]; every row has made a step with them."""
        actions = self._cast.actions(self.simulator, decision.action)
        self.simulator.step(actions)
        self.results = self._cast.results(self.simulator)
        return actions

    def is_over(self) -> bool:
        """Return whether the episodes of all agents of all rows have ended."""
        return not (self.simulator.agent_outcomes == Outcome.RUNNING).any()
