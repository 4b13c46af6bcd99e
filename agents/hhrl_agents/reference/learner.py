"""Training by the reference: Double DQN's loop with networks, gradients and Adam of torch, on the CPU or a GPU."""

from typing import Any

import numpy as np
import torch

from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.configs import DoubleDQNConfig
from hhrl_agents.methods.method import Method
from hhrl_agents.networks.architectures import FROZEN
from hhrl_agents.reference.algorithms import MiniBatch, ReferenceLearner, td_errors
from hhrl_agents.reference.conversion import from_module
from hhrl_agents.replay.buffer import ACTIONS, DISCOUNT, OPTIONS, REWARDS, Draw
from hhrl_agents.training.drivers import EGO_ALONE, Drivers
from hhrl_agents.training.learner import NOTHING, Learner, Start
from hhrl_envs import Scenario
from hhrl_envs.arrays import Keys
from hhrl_envs.errors import InputError, require_value
from hhrl_envs.state import State


class TorchLearner(DoubleDQNLearner):
    """Trains a method by Double DQN as the compiled learner does, with gradient steps by torch.

    Environments, exploration and replay are the compiled learner's, with the same random draws. After every gradient
    step the parameters go back to it, which acts by them. Torch's sums depend on the processor, so that the result is
    the compiled one's up to rounding at first, and another one later. A training that was stopped begins anew.

    device: where torch computes, "cpu" or "cuda".
    """

    exact = False

    def __init__(
        self,
        method: Method,
        scenario: Scenario,
        seed: int,
        world_seeds: Keys,
        drivers: Drivers = EGO_ALONE,
        start: Start = NOTHING,
        device: str = "cpu",
    ) -> None:
        learns = isinstance(method.config, DoubleDQNConfig)
        require_value(learns, "method", repr(method.id), "one that learns by double-dqn, to train by torch")
        require_device(device)
        super().__init__(method, scenario, seed, world_seeds, drivers, start)
        parameters = {**self.parameters.snapshot(), **self._frozen}
        self._device = torch.device(device)
        self._reference = ReferenceLearner(method, scenario, parameters, levels=self.levels, device=device)

    def state(self) -> State | None:  # type: ignore[override]  # this one cannot be saved
        """Return None: torch's optimiser is not saved; see `Learner.state`."""
        return None

    def restore(self, state: State) -> None:
        """Refuse; see `Learner.restore`."""
        Learner.restore(self, state)

    def _update(self, learning_rate: float) -> None:
        """Take one gradient step at every level, with one thread: small networks gain nothing from more."""
        threads = torch.get_num_threads()
        torch.set_num_threads(1)
        try:
            self._step(learning_rate)
        finally:
            torch.set_num_threads(threads)

    def _step(self, learning_rate: float) -> None:
        draw = self._sampler.draw(self._replay.stored)
        batch, size = self._batch(draw), draw.weights.shape[1]
        weights = {
            level: torch.from_numpy(row).to(self._device) for level, row in zip(self.levels, draw.weights, strict=True)
        }
        parts = {
            level: slice(first, first + size) for level, first in zip(self.levels, draw.firsts.tolist(), strict=True)
        }
        reference = self._reference
        with torch.no_grad():
            errors = td_errors(reference.online, reference.target, batch)
        losses = reference.update(batch, weights, learning_rate, parts)
        self._add_losses(losses[level].item() for level in self.levels)
        self._sampler.update(draw.indices, np.stack([errors[level].cpu().numpy() for level in self.levels]))
        self.updates += 1
        if self.updates % self.config.target_interval == 0:
            reference.move_target()
        learned = {name: value for name, value in from_module(reference.online).items() if not name.startswith(FROZEN)}
        self.parameters.take_over(learned)

    def _batch(self, draw: Draw) -> MiniBatch:
        """Return the drawn transitions on the device."""
        rows = torch.from_numpy(self._replay.rows[draw.indices]).to(self._device)
        features = self.config.features
        states, following, numbers = rows[:, :features], rows[:, features : 2 * features], rows[:, 2 * features :]
        return MiniBatch(
            states,
            numbers[:, OPTIONS].long(),
            numbers[:, ACTIONS].long(),
            numbers[:, REWARDS],
            numbers[:, REWARDS + 1],
            numbers[:, DISCOUNT],
            following,
        )

    def _metadata(self) -> dict[str, Any]:
        return {**super()._metadata(), "versions": {"torch": torch.__version__}}


def require_device(device: str) -> None:
    """Check that torch can compute on the device.

    Raises:
        InputError: if it cannot.
    """
    try:
        torch.zeros(1, device=device).cpu()
    except (RuntimeError, AssertionError) as error:
        raise InputError(
            f"torch cannot compute on device {device!r}; write cpu, or cuda where there is a GPU"
        ) from error
