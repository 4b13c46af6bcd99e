"""The readable algorithms beside the learner that trains: errors, losses, gradients, one update and a hundred."""

from typing import Any

import numpy as np
import pytest
import torch

from hhrl_agents import METHODS
from hhrl_agents.algorithms import td_errors as td_kernels
from hhrl_agents.algorithms.double_dqn import DoubleDQNLearner
from hhrl_agents.methods.method import Method
from hhrl_agents.reference.algorithms import MiniBatch, ReferenceLearner, hybrid_rewards, td_errors
from hhrl_agents.reference.conversion import from_module, gradients_of
from hhrl_agents.training.learner import Start
from hhrl_envs import Simulator, get_scenario
from hhrl_envs.arrays import Floats32
from hhrl_envs.errors import InputError
from support.kinds import KINDS, method_of, parameters_of

MAIN = get_scenario("stop-line-v0")
B = 48
Tensors = dict[str, torch.Tensor]


class Pair:
    """The reference and the compiled learner with the same parameters; the targets have others."""

    def __init__(self, method: Method, fixed: tuple[str, ...] = ()) -> None:
        online, target = (parameters_of(method, MAIN, seed) for seed in (0, 1))
        levels = [level for level in method.levels if level not in fixed]
        self.levels = levels
        self.reference = ReferenceLearner(method, MAIN, online, target, levels)
        learned = {name: value for name, value in online.items() if not name.startswith("ffv.")}
        worlds = np.arange(method.config.n_envs, dtype=np.uint64)
        self.learner = DoubleDQNLearner(method, MAIN, 0, worlds, start=Start(learned, fixed))
        views = self.learner.parameters._views(self.learner.parameters.target)
        for name, value in views.items():
            value[...] = target[name]

    def learn(self, batch: MiniBatch, weights: Tensors, parts: dict[str, slice], rate: float) -> td_kernels.Found:
        """Take the compiled step and return what it found."""
        learner, count = self.learner, len(batch.options)
        columns = (batch.option_rewards, batch.action_rewards, batch.discounts, batch.options, batch.actions)
        numbers = torch.stack([column.float() for column in columns], 1)
        rows = torch.cat((batch.observations, batch.next_observations, numbers), 1).numpy()
        given = np.zeros(count, np.int64)
        if learner.method.hierarchical and "option" not in learner.method.levels:
            given = learner._given_options(batch.next_observations.numpy())
        firsts = np.array([parts[level].start or 0 for level in self.levels])
        weighed = np.stack([weights[level].numpy() for level in self.levels])
        drawn = td_kernels.Batch(rows, np.arange(count), given, firsts, weighed)
        found = td_kernels.Found(np.zeros((len(self.levels), count), np.float32), *np.zeros((2, len(self.levels))))
        settings = td_kernels.Settings(learner.config.advantage_learning, rate, learner.config.max_gradient_norm)
        td_kernels.learn(learner._memory, learner._levels, drawn, learner._room, settings, found)
        return found

    @property
    def gradients(self) -> dict[str, Floats32]:
        """The gradients of the levels that learn, each clipped as the step clips it."""
        parameters, gradient = self.learner.parameters, self.learner._memory.gradient.copy()
        for level in self.levels:
            part = slice(*parameters.parts[level])
            norm = np.linalg.norm(gradient[part].astype(np.float64))
            gradient[part] *= min(1.0, self.learner.config.max_gradient_norm / norm)
        return self._learned(gradient)

    @property
    def online(self) -> dict[str, Floats32]:
        return self._learned(self.learner.parameters.online)

    def _learned(self, numbers: Floats32) -> dict[str, Floats32]:
        named = self.learner.parameters._views(numbers).items()
        return {name: value for name, value in named if name.split(".")[0] in self.levels}


def batch_of(method: Method, seed: int = 0, rows: int = B) -> MiniBatch:
    rng = np.random.default_rng(seed)

    def normal(*shape: int) -> torch.Tensor:
        return torch.from_numpy(rng.normal(size=shape).astype(np.float32))

    return MiniBatch(
        observations=normal(rows, method.config.features),
        options=torch.from_numpy(rng.integers(0, 2, rows)),
        actions=torch.from_numpy(rng.integers(0, MAIN.num_actions, rows)),
        option_rewards=normal(rows),
        action_rewards=normal(rows),
        discounts=torch.from_numpy(rng.choice([0.0, 0.97], rows).astype(np.float32)),
        next_observations=normal(rows, method.config.features),
    )


def weights_of(method: Method, rows: int, seed: int = 0) -> Tensors:
    rng = np.random.default_rng(seed)
    return {level: torch.from_numpy(rng.uniform(0.1, 1.0, rows).astype(np.float32)) for level in method.levels}


def halves(method: Method) -> dict[str, slice]:
    """Each level's own part of a mini-batch, as hierarchical replay draws them."""
    return {level: slice(index * B // 2, (index + 1) * B // 2) for index, level in enumerate(method.levels)}


def assert_same(found: dict[str, Floats32], wanted: Any, tolerance: float) -> None:
    for name, value in wanted.items():
        np.testing.assert_allclose(found[name], value, rtol=tolerance, atol=tolerance, err_msg=name)


@pytest.mark.parametrize("kind", KINDS)
def test_errors_are_the_learner_s(kind: str) -> None:
    method = method_of(kind)
    pair, batch = Pair(method), batch_of(method)
    found = td_errors(pair.reference.online, pair.reference.target, batch)
    wanted = pair.learn(batch, weights_of(method, B), dict.fromkeys(method.levels, slice(None)), 1e-3)
    assert list(found) == pair.levels
    for level, errors in zip(pair.levels, wanted.errors, strict=True):
        np.testing.assert_allclose(found[level].detach(), errors, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("kind", KINDS)
def test_losses_gradients_and_an_update_are_the_learner_s(kind: str) -> None:
    method = method_of(kind)
    pair, batch, weights, parts = Pair(method), batch_of(method), weights_of(method, B // 2), halves(method)
    before = from_module(pair.reference.online)
    losses = pair.reference.losses(batch, weights, parts)
    gradients = gradients_of(pair.reference.online)
    assert_same(from_module(pair.reference.online), before, 0.0)
    pair.reference.update(batch, weights, 1e-3, parts)
    wanted = pair.learn(batch, weights, parts, 1e-3)
    for level, loss in zip(pair.levels, wanted.losses, strict=True):
        assert losses[level].item() == pytest.approx(loss, rel=1e-4)
    assert_same(gradients, pair.gradients, 1e-4)
    after = from_module(pair.reference.online)
    assert_same(after, pair.online, 1e-5)
    moved = [name for name, value in after.items() if not np.array_equal(value, before[name])]
    assert sorted(moved) == sorted(pair.online)


@pytest.mark.parametrize("kind", ["flat", "attention", "memory", "figure-2", "layer-norm"])
def test_a_hundred_updates_lead_to_the_same_parameters(kind: str) -> None:
    method = method_of(kind)
    pair, everything = Pair(method), dict.fromkeys(method.levels, slice(None))
    for step in range(100):
        batch, weights, rate = batch_of(method, step), weights_of(method, B, step), 1e-3 / (1 + step)
        pair.reference.update(batch, weights, rate)
        pair.learn(batch, weights, everything, rate)
        if step % 20 == 19:
            pair.reference.move_target()
            pair.learner.parameters.move_target(method.config.target_rate)
    assert_same(from_module(pair.reference.online), pair.online, 1e-5)


def test_a_level_that_stays_fixed_chooses_and_does_not_learn() -> None:
    method = method_of("attention")
    pair, batch, weights = Pair(method, fixed=("option",)), batch_of(method), weights_of(method, B)
    before = {name: value.copy() for name, value in pair.learner.parameters.snapshot().items()}
    losses = pair.reference.update(batch, weights, 1e-2)
    found = pair.learn(batch, weights, {"action": slice(None)}, 1e-2)
    assert list(losses) == ["action"]
    assert losses["action"].item() == pytest.approx(found.losses[0], rel=1e-4)
    for name, value in pair.learner.parameters.snapshot().items():
        assert np.array_equal(value, before[name]) == name.startswith("option.")


def test_a_gradient_is_as_long_as_its_bound_at_most() -> None:
    method = method_of("attention")
    pair, batch, weights = Pair(method), batch_of(method), weights_of(method, B)
    pair.reference.losses(batch, {level: 1e4 * weight for level, weight in weights.items()})
    for level in method.levels:
        squares = [(g**2).sum() for name, g in gradients_of(pair.reference.online).items() if name.startswith(level)]
        assert np.sqrt(sum(squares)) == pytest.approx(method.config.max_gradient_norm, rel=1e-4)


def test_a_target_network_moves_by_its_rate() -> None:
    method = METHODS["hybrid-hrl"]
    pair = Pair(method_of("attention"))
    before, online = from_module(pair.reference.target), from_module(pair.reference.online)
    assert any(not np.array_equal(before[name], online[name]) for name in online)
    pair.reference.move_target()
    assert method.config.target_rate == 1.0
    assert_same(from_module(pair.reference.target), online, 0.0)


def test_another_algorithm_s_method_is_refused() -> None:
    method = METHODS["pqn"]
    with pytest.raises(InputError, match="method 'pqn' learns by pqn; name one that learns by double-dqn"):
        ReferenceLearner(method, MAIN, parameters_of(method, MAIN, seed=0))


def test_rewards_of_both_levels_are_the_simulator_s() -> None:
    rows, rng, ended = 64, np.random.default_rng(0), 0
    simulator = Simulator(MAIN, rows)
    simulator.reset(np.arange(rows, dtype=np.uint64))
    for step in range(150):
        simulator.step(np.full(rows, MAIN.num_actions - 1) if step < 60 else rng.integers(0, MAIN.num_actions, rows))
        results = simulator.of_agent(0)
        options = rng.integers(0, 2, rows)
        found = hybrid_rewards(torch.from_numpy(results.terms.copy()), torch.from_numpy(options))
        for mine, theirs in zip(found, (results.reward_option, results.reward_action), strict=True):
            np.testing.assert_allclose(mine, theirs[np.arange(rows), options], rtol=1e-12, atol=1e-12)
        over = results.outcomes != 0
        ended += int(over.sum())
        simulator.next_episode(over)
    assert ended > 10
