"""Hierarchical prioritised replay, the paper's Algorithm 3, for one seed in plain torch."""

import torch
from torch import Tensor

from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.reference.algorithms import ByLevel

SCALE_RATE = 0.01
"""Rate at which the running magnitude of a level's error follows the mini-batches."""


class HierarchicalReplay:
    """The priorities of Algorithm 3 for a buffer of `capacity` transitions, without a tree: each draw sums all of them.

    A level's errors, divided by its running magnitude, give the transitions of its own mini-batch new priorities: p^o =
    |delta_o|, and p^a = max(|delta_a| - p^o, 0), with the p^o that the option level found when it last learned from
    that transition, 0 before. `config.priority` = "shift" is the literal p^a, the undivided |delta_a| - p^o less its
    minimum over the mini-batch.
    """

    def __init__(self, capacity: int, config: DoubleDQNConfig) -> None:
        self._config = config
        self._powers = {level: torch.zeros(capacity, dtype=torch.float64) for level in ("option", "action")}
        self._of_option = torch.zeros(capacity, dtype=torch.float64)
        self._highest = dict.fromkeys(self._powers, 1.0)
        self._magnitude: dict[str, Tensor] = {}

    def added(self, indices: Tensor) -> None:
        """Give new transitions, int64 [n], the highest priority so far."""
        for level, powers in self._powers.items():
            powers[indices] = self._highest[level]
        self._of_option[indices] = 0.0

    def draw(self, level: str, shares: Tensor) -> Tensor:
        """Return the transition at each share of a level's priorities, int64 [K]; shares in [0, 1), float64 [K]."""
        upto = self._powers[level].cumsum(0)
        return torch.searchsorted(upto, shares * upto[-1], right=True)

    def weights(self, level: str, indices: Tensor, stored: int) -> Tensor:
        """Return w = [N P]^-beta / max w of the drawn transitions, float32 [K]; N: how many are stored."""
        chances = self._powers[level][indices] / self._powers[level].sum()
        weights = (stored * chances) ** -self._config.importance_exponent
        return (weights / weights.max()).float()

    def update(self, indices: ByLevel, errors: ByLevel) -> None:
        """Give every level's drawn transitions, int64 [K], their new priorities, from that level's errors, [K]."""
        for level in self._powers:
            drawn, error = indices[level], errors[level].detach().double().abs()
            powers = (
                self._priorities(level, drawn, error) + self._config.priority_floor
            ) ** self._config.priority_exponent
            self._powers[level][drawn] = powers
            self._highest[level] = max(self._highest[level], powers.max().item())

    def _priorities(self, level: str, drawn: Tensor, error: Tensor) -> Tensor:
        shift = self._config.priority == "shift"
        scaled = error if shift else error / self._magnitude_with(level, error)
        if level == "option":
            self._of_option[drawn] = scaled
            return scaled
        gap = scaled - self._of_option[drawn]
        return gap - gap.min() if shift else gap.clamp(min=0.0)

    def _magnitude_with(self, level: str, errors: Tensor) -> Tensor:
        """Return a level's running magnitude, these errors in it; the first ones are the first magnitude."""
        mean = errors.mean()
        before = self._magnitude.get(level, mean)
        self._magnitude[level] = before + SCALE_RATE * (mean - before)
        return self._magnitude[level].clamp(min=1e-12)
